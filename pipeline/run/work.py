"""The task of a worker: simulate a point, and return its record.

::

    TriboError
    └── ExecutionError       points could not be computed, most often for lack of workers
"""

from __future__ import annotations

import functools
import hashlib
import pickle
import sys
import threading
import zlib
from pathlib import Path
from platform import python_version
from typing import NamedTuple

import cloudpickle
import numpy as np
import scipy

from pipeline.sweep.plan import CaseInputs, PointRecord
from pipeline.sweep.sweep import Point
from pipeline.sweep.user_laws import UserObject
from tribo import TriboError
from tribo.simulation import RampCache


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


class Program(NamedTuple):
    """Identity of the program that computes points: hash of its sources, and versions."""

    code: str
    versions: str


_ON_WORKERS = "tribo", "pipeline/sweep", "pipeline/run/work.py"


def _hash_of_code(root: Path = Path(__file__).parents[2]) -> str:
    digest = hashlib.sha256()
    for part in _ON_WORKERS:
        for file in sorted((root / part).rglob("*.py")) or [root / part]:
            digest.update(file.relative_to(root).as_posix().encode() + b"\0" + file.read_bytes())
    return digest.hexdigest()[:12]


# Taken as this module is imported: files may change while a process runs.
PROGRAM = Program(
    _hash_of_code(), f"Python {python_version()}, NumPy {np.__version__}, SciPy {scipy.__version__}"
)


def program() -> Program:
    """The program of the process that calls this."""
    return PROGRAM


def pickled(inputs: CaseInputs) -> bytes:
    """The inputs of a case as bytes, which a scan of a surface may fill with megabytes.

    They contain the code of a user's wear law or surface, which workers need not have.
    """
    for part in (inputs.scene.wear, inputs.scene.roughness):
        if isinstance(part, UserObject):
            for package in part.packages:
                cloudpickle.register_pickle_by_value(sys.modules[package])
    return zlib.compress(cloudpickle.dumps(inputs), level=1)


@functools.lru_cache(maxsize=64)
def _unpickle_case(case: bytes) -> CaseInputs:
    inputs: CaseInputs = pickle.loads(zlib.decompress(case))
    return inputs


_ramps = RampCache()  # the loading ramps that this worker has computed, for the points to come
_simulation_lock = threading.Lock()  # several threads of one process gained 6 % at most


def simulate_point(case: bytes, point: Point) -> bytes:
    """Simulate a case at a point; return its record and the program, for `unpack_result`.

    An error becomes the message of the record.
    """
    with _simulation_lock:
        try:
            record = _unpickle_case(case).simulate(point, _ramps)
        except Exception as error:
            record = PointRecord(point, None, f"{type(error).__name__}: {error}")
        # Dask would send each array by itself, which took the driver 2 ms a point.
        return pickle.dumps((record, PROGRAM))


def unpack_result(result: bytes) -> tuple[PointRecord, Program]:
    """The record of a point and its program, from the result of `simulate_point`."""
    record_and_program: tuple[PointRecord, Program] = pickle.loads(result)
    return record_and_program
