"""What a worker does: the task of a point, and what it tells the driver while it computes.

A task leaves its result on the worker, since the next point of the ramp continues its trunk. The
driver takes the records alone, some times a minute, without a task.
"""

from __future__ import annotations

import functools
import pickle
import threading
from collections.abc import Collection, Sequence
from dataclasses import dataclass
from typing import Any, NamedTuple

from distributed import Worker

from pipeline.run.cluster import Versions, versions
from pipeline.run.source import SAFE, ExecutionError
from pipeline.store.attributes import Simulated
from pipeline.store.packing import packed
from pipeline.sweep.model import Point, Sweep
from pipeline.sweep.plan import PointRecord, Trunk, run_points
from tribo import InputError

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


class Report(NamedTuple):
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

    One that fails is recorded, and the next load continues the same trunk. The name is that of the
    task, the parcel a pickled sweep, whether fields are stored, and hashes of what is simulated.
    Points at lower loads that are known to have failed are no stations.
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


def records_here(keys: Collection[str], dask_worker: Worker) -> Report:
    """Records of those of these tasks whose results lie on a worker, and what it does.

    It runs in the worker's event loop, so that a long point does not keep finished ones waiting.
    """
    found = {key: dask_worker.data[key].records for key in keys if key in dask_worker.data}
    return Report(versions(), _now, {key: pickle.dumps(records) for key, records in found.items()})


@functools.lru_cache(maxsize=1)
def _unpacked(parcel: bytes) -> tuple[Sweep, bool, Simulated]:
    try:
        contents: tuple[Sweep, bool, Simulated] = pickle.loads(parcel)
    except InputError as error:  # of a law whose text is another one here
        raise ExecutionError(f"a worker cannot take the scene: {error}; {SAFE}") from error
    return contents
