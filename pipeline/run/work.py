"""Tasks of a worker: points of a chain, one after the other.

The trunk at the end stays on the worker for the next task of the chain; the driver takes the
records alone, and writes them.
"""

from __future__ import annotations

import functools
import itertools
import pickle
import threading
import time
from collections.abc import Iterable
from dataclasses import dataclass
from typing import Any

from pipeline.run.source import SAFE, ExecutionError
from pipeline.run.versions import Versions, versions
from pipeline.store.packing import packed
from pipeline.sweep.model import Point, Sweep
from pipeline.sweep.plan import PointRecord, Trunk, run_points
from tribo import InputError

# Buffers of the transforms are shared within a process. The second thread computes while the
# results of the first are on their way.
_one_at_a_time = threading.Lock()


@dataclass(frozen=True, eq=False)
class Stretch:
    """Result of a task: its points, and the trunk of a ramp that the next load continues."""

    records: tuple[PointRecord, ...]
    trunk: Trunk | None
    ramp: tuple[Any, ...] | None

    def __reduce__(self) -> tuple[Any, ...]:
        # Dask rebuilds arrays at odd addresses, where NumPy sums in another order: last digits of
        # a point would depend on whether its trunk had travelled. Bytes are unpickled as usual.
        return _unpickled, (pickle.dumps((self.records, self.trunk, self.ramp)),)


def _unpickled(parts: bytes) -> Stretch:
    return Stretch(*pickle.loads(parts))


def compute_points(
    parcel: bytes, points: Iterable[Point], before: Stretch | None, seconds: float
) -> Stretch:
    """Compute points of one or more chains, at least one, until the time is up.

    A point that fails is recorded, and the next one continues the same trunk. The parcel is a
    pickled sweep, and whether fields are stored.
    """
    sweep, with_fields = _unpacked(parcel)
    trunk, ramp = (before.trunk, before.ramp) if before else (None, None)
    end = time.monotonic() + seconds
    records: list[PointRecord] = []
    for (contact, _), rows in itertools.groupby(
        points, key=lambda point: (sweep.contact_of(point), point.load)
    ):
        if contact != ramp:
            trunk, ramp = None, contact
        new, trunk = _computed(sweep, tuple(rows), trunk, with_fields)
        records += new
        if time.monotonic() > end:
            break
    return Stretch(tuple(records), trunk, ramp)


def _computed(
    sweep: Sweep, points: tuple[Point, ...], trunk: Trunk | None, with_fields: bool
) -> tuple[list[PointRecord], Trunk | None]:
    """Records of points of one contact, and the trunk after them."""
    try:
        with _one_at_a_time:
            results = run_points(sweep, points, trunk)
    except Exception as error:
        if len(points) > 1:  # the others may have a solution
            alone = [_computed(sweep, (point,), None, with_fields)[0] for point in points]
            return [record for records in alone for record in records], None
        return [PointRecord(points[0], None, f"{type(error).__name__}: {error}")], trunk
    return [packed(result.record(with_fields)) for result in results], results[0].trunk


def records_of(stretch: Stretch) -> tuple[Versions, bytes]:
    """Pickled records of a task, without its trunk, and the versions that computed them."""
    return versions(), pickle.dumps(stretch.records)


@functools.lru_cache(maxsize=1)
def _unpacked(parcel: bytes) -> tuple[Sweep, bool]:
    try:
        contents: tuple[Sweep, bool] = pickle.loads(parcel)
    except InputError as error:  # of a law whose text is another one here
        raise ExecutionError(f"a worker cannot take the scene: {error}; {SAFE}") from error
    return contents
