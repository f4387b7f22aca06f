"""What a worker does: the task of a point, whose result stays there for the next load.

The driver takes records, and versions: other code must not enter the same store.

::

    TriboError
    └── ExecutionError   the workers do not start, are lost, or run other code
"""

from __future__ import annotations

import functools
import hashlib
import os
import pickle
import platform
import threading
from collections.abc import Collection, Iterable, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
import scipy
from distributed import Worker

import tribo
from pipeline.store.checksum import packed
from pipeline.sweep.model import Point, Sweep
from pipeline.sweep.plan import PointRecord, Trunk, run_points
from pipeline.sweep.stored import Simulated
from tribo import InputError, TriboError

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
    >>> from pipeline.run.cluster import client_of
    >>> try:
    ...     client_of("tcp://127.0.0.1:1", patience=1.0)
    ... except ExecutionError:
    ...     print("nobody answers there")
    nobody answers there
    """


def require_same_code(theirs: Versions, worker: str) -> None:
    """Raise an `ExecutionError` for a worker with other code than this process."""
    if theirs["code"] != (ours := versions())["code"]:
        raise ExecutionError(
            f"the Dask worker {worker} runs code {theirs['code']} of tribo and pipeline from "
            f"{theirs['folder']}, and this program code {ours['code']} from {ours['folder']}; "
            f"{INSTALL}"
        )


# Buffers of the transforms are shared within a process.
_one_at_a_time = threading.Lock()
_now: str | None = None  # name of the task that holds it


@dataclass(frozen=True, eq=False)
class Computed:
    """Result of a task: records of its points, and the trunk that the next load continues."""

    records: tuple[PointRecord, ...]
    trunk: Trunk | None

    def __reduce__(self) -> tuple[Any, ...]:
        # Dask rebuilds arrays at odd addresses, where NumPy sums in another order: last digits of
        # a point would depend on whether its trunk had travelled. Bytes are unpickled as usual.
        return _unpickled, (pickle.dumps((self.records, self.trunk)),)


def _unpickled(parts: bytes) -> Computed:
    return Computed(*pickle.loads(parts))


class WorkerReport(NamedTuple):
    """What a worker tells: its versions, the task that it computes, and pickled records by task."""

    versions: Versions
    now: str | None
    records: dict[str, bytes]


def compute_points(
    name: str,
    parcel: bytes,
    points: Sequence[Point],
    below: Computed | None,
    failed: Collection[Point] = (),
) -> Computed:
    """Compute a point, or points at one load that share a contact, on from the load below.

    The name is that of the task, the parcel a pickled sweep and whether fields are stored. Points
    that are known to have failed are no stations.
    """
    global _now
    sweep, with_fields, simulated = _unpacked(parcel)
    with _one_at_a_time:
        _now = name
        try:
            trunk = below.trunk if below else None
            records, trunk = _computed(sweep, points, trunk, failed, with_fields, simulated)
        finally:
            _now = None
    return Computed(tuple(records), trunk)


def _computed(
    sweep: Sweep,
    points: Sequence[Point],
    trunk: Trunk | None,
    failed: Collection[Point],
    with_fields: bool,
    simulated: Simulated,
) -> tuple[list[PointRecord], Trunk | None]:
    """Records of points of one contact, and the trunk after them."""
    try:
        results = run_points(sweep, points, trunk, failed=failed)
    except Exception as error:
        if len(points) > 1:  # the others may have a solution
            parts = failed, with_fields, simulated
            alone = [_computed(sweep, (point,), None, *parts)[0] for point in points]
            return [record for records in alone for record in records], None
        record = PointRecord(points[0], None, f"{type(error).__name__}: {error}")
        return [packed(record, simulated)], trunk.without(points) if trunk else None
    return [packed(result.record(with_fields), simulated) for result in results], results[0].trunk


def records_here(keys: Collection[str], dask_worker: Worker) -> WorkerReport:
    """Records of those of these tasks whose results lie on a worker, told from its event loop."""
    found = {key: dask_worker.data[key].records for key in keys if key in dask_worker.data}
    return WorkerReport(
        versions(), _now, {key: pickle.dumps(records) for key, records in found.items()}
    )


@functools.lru_cache(maxsize=1)
def _unpacked(parcel: bytes) -> tuple[Sweep, bool, Simulated]:
    try:
        sweep, with_fields = pickle.loads(parcel)
    except InputError as error:  # of a law whose text is another one here
        raise ExecutionError(f"a worker cannot take the scene: {error}; {SAFE}") from error
    return sweep, with_fields, Simulated(sweep)
