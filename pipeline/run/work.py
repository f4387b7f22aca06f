"""What a worker does: the task of a point, whose records stay there until they are asked for.

The driver takes records, and versions: other code must not enter the same store.

::

    TriboError
    └── ExecutionError       the workers do not start, are lost, or run other code
        └── UnsentError      a worker does not have the scene yet
"""

from __future__ import annotations

import functools
import hashlib
import os
import pickle
import platform
import sys
import threading
import time
from collections.abc import Collection, Iterable, Mapping, Sequence
from contextlib import suppress
from pathlib import Path
from typing import NamedTuple

import cloudpickle
import numpy as np
import scipy
from distributed import Worker, get_worker

import tribo
from pipeline.store.checksum import packed
from pipeline.sweep.identity import Simulated
from pipeline.sweep.laws import code_of, given_laws
from pipeline.sweep.model import Point, Sweep
from pipeline.sweep.plan import PointRecord, run_points
from tribo import TriboError
from tribo.simulation import Trunks

SAFE = "finished points are safe, run the sweep again to go on"
INSTALL = f"install the same version in both places and restart the workers; {SAFE}"

Versions = Mapping[str, str]

_FOLDERS = (Path(tribo.__file__).parent, Path(__file__).parents[1])
_PACKAGES = ("python", "numpy", "scipy")


def hash_of_code(folders: Iterable[Path] = _FOLDERS) -> str:
    """Hash of the source files of packages, by their names and contents."""
    digest = hashlib.sha256()
    for folder in folders:
        for file in sorted(folder.rglob("*.py")):
            name = os.fspath(file.relative_to(folder.parent))
            digest.update(f"{name} {file.stat().st_size}\n".encode())
            digest.update(file.read_bytes())
    return digest.hexdigest()[:12]


# Taken as this module is imported, so that a process that runs on after its files have changed
# names the code that it runs, and not the files.
_HERE: Versions = {
    "code": hash_of_code(),
    "numpy": np.__version__,
    "scipy": scipy.__version__,
    "python": platform.python_version(),
    "folder": os.fspath(_FOLDERS[1].parent),
}


def versions() -> Versions:
    """Versions of this process, and the folder that its code was loaded from."""
    return _HERE


def packages_of(theirs: Versions) -> dict[str, str]:
    """Versions of Python, NumPy and SciPy alone."""
    return {name: theirs[name] for name in _PACKAGES}


def other_packages(theirs: Versions) -> str:
    """Differences in Python, NumPy and SciPy between a worker and this process, in words."""
    return ", ".join(
        f"{name} {version} (here {_HERE[name]})"
        for name, version in packages_of(theirs).items()
        if version != _HERE[name]
    )


class ExecutionError(TriboError):
    """Workers that do not start, are lost, or run other code.

    Examples
    --------
    >>> from pipeline import ExecutionError
    >>> from pipeline.run.cluster import client_of
    >>> try:
    ...     client_of("tcp://127.0.0.1:1", patience=1.0)
    ... except ExecutionError:
    ...     print("nobody answers there")
    nobody answers there
    """


class UnsentError(ExecutionError):
    """A worker that a task has come to before its scene.

    Examples
    --------
    >>> from pipeline.sweep.model import Point
    >>> try:
    ...     compute_points("a task", "a run", [Point(600.0, 1.5)])
    ... except UnsentError:
    ...     print("to be sent again")
    to be sent again
    """


def require_same_code(theirs: Versions, worker: str) -> None:
    """Raise an `ExecutionError` for a worker with other code than this process."""
    if theirs["code"] != (ours := versions())["code"]:
        raise ExecutionError(
            f"the Dask worker {worker} runs code {theirs['code']} of tribo and pipeline from "
            f"{theirs['folder']}, and this program code {ours['code']} from {ours['folder']}; "
            f"{INSTALL}"
        )


# Threads of one process gain 6 % at most: tests/benchmarks/threads.py.
_one_at_a_time = threading.Lock()
_now: str | None = None  # name of the task that holds it
_trunks = Trunks()
_parcels: dict[str, bytes] = {}  # pickled sweeps, and whether fields are stored, by run
_RUNS = 4  # whose parcels a worker keeps
_ARRIVAL, _PAUSE = 20.0, 0.05  # [s] that a task may wait for a parcel, and between two looks


def parcel_of(sweep: Sweep, with_fields: bool) -> bytes:
    """What workers need of a run, with the user's laws by value: their modules are not there."""
    laws = filter(None, [*given_laws(sweep.scene), sweep.conditions.rule])
    names = {code_of(law).__module__ for law in laws}
    added = [
        sys.modules[name]
        for name in names - cloudpickle.list_registry_pickle_by_value()
        if name in sys.modules
    ]
    for module in added:
        cloudpickle.register_pickle_by_value(module)
    try:
        content: bytes = cloudpickle.dumps((sweep, with_fields))
    finally:
        for module in added:
            cloudpickle.unregister_pickle_by_value(module)
    return content


class WorkerReport(NamedTuple):
    """What a worker tells: its versions, the task that it computes, and pickled records by task."""

    versions: Versions
    now: str | None
    records: dict[str, bytes]


def compute_points(name: str, run: str, points: Sequence[Point]) -> list[PointRecord]:
    """Compute a point, or points at one load that share a contact, from what this process has.

    The name is that of the task. Raise an `UnsentError` if the run's parcel has not come yet.
    """
    global _now
    _wait_for_parcel(run)
    sweep, with_fields, simulated = _unpacked(run)
    with _one_at_a_time:
        _now = name
        try:
            return _computed(sweep, points, with_fields, simulated)
        finally:
            _now = None


def _wait_for_parcel(run: str) -> None:
    """Wait some time on a worker that has a task before the driver knows the worker."""
    with suppress(ValueError):  # no worker
        get_worker()
        limit = time.monotonic() + _ARRIVAL
        while run not in _parcels and time.monotonic() < limit:
            time.sleep(_PAUSE)


def _computed(
    sweep: Sweep, points: Sequence[Point], with_fields: bool, simulated: Simulated
) -> list[PointRecord]:
    """Records of points of one contact."""
    try:
        results = run_points(sweep, points, _trunks)
    except Exception as error:
        if len(points) > 1:  # the others may have a solution
            alone = (_computed(sweep, (point,), with_fields, simulated) for point in points)
            return [record for records in alone for record in records]
        message = f"{type(error).__name__}: {error}"
        return [packed(PointRecord(points[0], None, message), simulated)]
    return [packed(result.record(with_fields), simulated) for result in results]


def records_here(
    keys: Collection[str], run: str, parcel: bytes | None, dask_worker: Worker
) -> WorkerReport:
    """Records of those of these tasks whose results lie on a worker, told from its event loop.

    The parcel is kept for the tasks of the run.
    """
    if parcel is not None:
        _parcels[run] = parcel
        for old in [*_parcels][:-_RUNS]:
            del _parcels[old]
    found = {key: pickle.dumps(dask_worker.data[key]) for key in keys if key in dask_worker.data}
    return WorkerReport(versions(), _now, found)


@functools.lru_cache(maxsize=1)
def _unpacked(run: str) -> tuple[Sweep, bool, Simulated]:
    if run not in _parcels:
        raise UnsentError(f"a worker does not have the scene; {SAFE}")
    try:
        sweep, with_fields = pickle.loads(_parcels[run])
    except Exception as error:  # a law may import what is not here
        raise ExecutionError(f"a worker cannot read the scene: {error}; {SAFE}") from error
    return sweep, with_fields, Simulated(sweep)
