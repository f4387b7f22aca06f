"""A few points, simulated one after the other in this process, without a cluster."""

from __future__ import annotations

from collections.abc import Iterator, Sequence

import xarray as xr

from pipeline.progress import Report, silent
from pipeline.store.create import copy_points
from pipeline.store.read import store_dataset
from pipeline.store.store import Store, opened
from pipeline.sweep.plan import PointRecord, choose_stored_steps, run_point
from pipeline.sweep.sweep import Point
from tribo import TriboError


def run_serial(
    store: Store, points: Sequence[Point] = (), source: str | None = None, report: Report = silent
) -> None:
    """Simulate the pending points of the tests in a store, then `points`, in their order.

    Points that the store at `source` has are copied. An error at the first of `points` is
    raised; another one becomes the message of its point.
    """
    if source is not None:
        copy_points(store, opened(source))
    if store.tests:
        store.tests.commit(_simulated(store.tests, store.tests.pending(), (), report))
    store.commit(_simulated(store, points, points[:1], report))


def computed_dataset(store: Store) -> xr.Dataset:
    """Dataset of an open store."""
    return store_dataset(store).load()


def _simulated(
    store: Store, points: Sequence[Point], needed: Sequence[Point], report: Report
) -> Iterator[PointRecord]:
    stored_steps = choose_stored_steps(store.sweep)
    for point in points:
        scene = store.sweep.case(point.case).scene
        try:
            film, fields = store.sweep.case(point.case).has_film, store.fields_of(point.case)
            result = run_point(scene, stored_steps, point, None, report, film, fields)
        except TriboError as error:
            if point in needed:
                raise
            yield PointRecord(point, None, str(error))
        else:
            yield result.record(bool(fields))
