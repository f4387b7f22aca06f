"""What a worker does: it computes the point of a task, and returns its record.

::

    TriboError
    └── ExecutionError       points could not be computed, most often for lack of workers
"""

from __future__ import annotations

import hashlib
import os
import pickle
import sys
import threading
from collections.abc import Iterable
from functools import cached_property
from pathlib import Path

import cloudpickle
from distributed import WorkerPlugin, get_worker

import tribo
from pipeline.store.checksum import packed
from pipeline.sweep.laws import code_of, given_laws
from pipeline.sweep.model import Point, Sweep
from pipeline.sweep.plan import PointRecord, run_point
from tribo import TriboError
from tribo.simulation import Trunks

SAFE = "finished points are safe, run the sweep again to go on"
INSTALL = f"install the same version in both places and restart the workers; {SAFE}"

_FOLDERS = (Path(tribo.__file__).parent, Path(__file__).parents[1])


def hash_of_code(folders: Iterable[Path] = _FOLDERS) -> str:
    """Hash of the names and contents of all source files in `folders`."""
    digest = hashlib.sha256()
    for folder in folders:
        for file in sorted(folder.rglob("*.py")):
            name = os.fspath(file.relative_to(folder.parent))
            digest.update(f"{name} {file.stat().st_size}\n".encode())
            digest.update(file.read_bytes())
    return digest.hexdigest()[:12]


# Taken as this module is imported, so that a process whose files have changed since then names the
# code that it runs.
CODE, FOLDER = hash_of_code(), os.fspath(_FOLDERS[1].parent)


class ExecutionError(TriboError):
    """Points of a sweep could not be computed.

    Most often Dask workers did not start, were lost, or have another version of this package.

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


class Run(WorkerPlugin):  # type: ignore[misc]
    """Dask plugin that brings the sweep of a run to each worker, also to workers that join later.

    It carries the code of the user's own laws, since their modules are not on the workers.
    """

    def __init__(self, name: str, sweep: Sweep, with_fields: bool) -> None:
        self.name, self.with_fields = name, with_fields
        self.code, self.folder = CODE, FOLDER
        self._sweep = _pickled(sweep)

    @cached_property
    def sweep(self) -> Sweep:
        """The sweep, unpickled once in each process."""
        sweep: Sweep = pickle.loads(self._sweep)
        return sweep

    def require_same_code(self, worker: str) -> None:
        """Raise an `ExecutionError` if the source files of worker and driver differ.

        `worker` is the address of the worker, for the message.
        """
        if self.code != CODE:
            raise ExecutionError(
                f"the Dask worker {worker} runs tribo and pipeline from {FOLDER} (hash {CODE}), "
                f"but this program runs them from {self.folder} ({self.code}); {INSTALL}"
            )


def _pickled(sweep: Sweep) -> bytes:
    """Pickle a sweep together with the code of the user's laws."""
    laws = filter(None, [*given_laws(sweep.scene), sweep.conditions.rule])
    for name in {code_of(law).__module__ for law in laws} & sys.modules.keys():
        cloudpickle.register_pickle_by_value(sys.modules[name])
    return bytes(cloudpickle.dumps(sweep))


# Several threads of one process gained 6 % at most.
_one_at_a_time = threading.Lock()
_trunks = Trunks()


def compute_point(name: str, point: Point) -> bytes:
    """On a worker: compute a point, for the run with a `name`; return its pickled record."""
    worker = get_worker()
    run: Run = worker.plugins[name]
    run.require_same_code(worker.address)
    with _one_at_a_time:
        return pickle.dumps(_record(run, point))


def _record(run: Run, point: Point) -> PointRecord:
    """Simulate a point of the sweep of `run`; return its record, with the reason if it failed."""
    try:
        result = run_point(run.sweep, point, _trunks)
        return packed(result.record(run.with_fields), run.sweep)
    except Exception as error:
        message = f"{type(error).__name__}: {error}"
        return packed(PointRecord(point, None, message), run.sweep)
