"""What a worker does: it computes the point of a task, and returns its record.

::

    TriboError
    └── ExecutionError       points could not be computed, most often for lack of workers
"""

from __future__ import annotations

import functools
import hashlib
import os
import pickle
import threading
import zlib
from dataclasses import dataclass
from pathlib import Path
from platform import python_version
from typing import Any

import numpy as np
import scipy
from distributed import get_worker

from pipeline.sweep.plan import PointRecord, run_point
from pipeline.sweep.stations import Stations
from pipeline.sweep.sweep import Point
from tribo import Scene, TriboError
from tribo.simulation import Trunks

SAFE = "finished points are safe, run the sweep again to go on"
INSTALL = f"install the same version in both places and restart the workers; {SAFE}"

_ROOT = Path(__file__).parents[2]
_ON_WORKERS = (
    "tribo", "pipeline/sweep", "pipeline/quantities.py", "pipeline/run/work.py",
)  # fmt: skip
VERSIONS = f"Python {python_version()}, NumPy {np.__version__}, SciPy {scipy.__version__}"
"""Versions on which the last digits of results may depend."""


def hash_of_code(root: Path = _ROOT) -> str:
    """Hash of the names and contents of the sources in the folder `root` that compute a point."""
    digest = hashlib.sha256()
    for part in _ON_WORKERS:
        for file in sorted((root / part).rglob("*.py")) or [root / part]:
            digest.update(f"{file.relative_to(root).as_posix()} {file.stat().st_size}\n".encode())
            digest.update(file.read_bytes())
    return digest.hexdigest()[:12]


# Taken as this module is imported, so that a process whose files have changed since then names the
# code that it runs.
CODE, FOLDER = hash_of_code(), os.fspath(_ROOT)


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


@dataclass(frozen=True, slots=True)
class Work:
    """What the points of one case have in common: the scene, and what is recorded of them."""

    scene: Scene
    stations: Stations
    with_fields: bool
    with_film: bool

    def pickled(self) -> bytes:
        """The work as bytes."""
        return zlib.compress(pickle.dumps(self), level=1)


@functools.lru_cache(maxsize=64)
def _unpickled(work: bytes) -> Work:
    unpickled: Work = pickle.loads(zlib.decompress(work))
    return unpickled


# Several threads of one process gained 6 % at most.
_one_at_a_time = threading.Lock()
_trunks = Trunks()


# A task is this text, for `eval`: a worker that cannot unpickle a task drops its connection
# without a word, while an import that fails within the task is an error of the task.
TASK = "__import__('pipeline.run.work', fromlist=['work']).compute_point(*given)"


def compute_point(code: str, folder: str, work: bytes, place: tuple[Any, ...]) -> bytes:
    """Compute the point at a load, velocity and variant; return its record and `VERSIONS`, pickled.

    `code` and `folder` are those of the driver's program. An error is the message of the record.
    """
    if code != CODE:
        raise ExecutionError(
            f"the Dask worker {get_worker().address} runs tribo and pipeline from {FOLDER} (hash "
            f"{CODE}), but this program runs them from {folder} ({code}); {INSTALL}"
        )
    point = Point(*place)
    with _one_at_a_time:
        try:
            given = _unpickled(work)
            result = run_point(
                given.scene, given.stations, point, _trunks, with_film=given.with_film
            )
            record = result.record(given.with_fields)
        except Exception as error:
            record = PointRecord(point, None, f"{type(error).__name__}: {error}")
        return pickle.dumps((record, VERSIONS))
