"""A few points, simulated one after the other in this process, without a cluster."""

from __future__ import annotations

from collections.abc import Sequence

from pipeline.progress import Progress, Report, silent
from pipeline.store.points import copy_points
from pipeline.store.store import Store
from pipeline.sweep.plan import CaseInputs, PointRecord
from pipeline.sweep.sweep import Point
from tribo import TriboError


def run_serial(
    store: Store, points: Sequence[Point] = (), source: Store | None = None, report: Report = silent
) -> None:
    """Simulate the pending points of the tests in a store, then `points`, in their order.

    Points that the store `source` has are copied. An error at the first of `points` is raised;
    another one becomes the message of its point. `report` is called after each point.
    """
    if source is not None:
        copy_points(store, source)
    tests = [(group, point) for group in store.groups[1:] for point in group.pending()]
    todo = [*tests, *((store, point) for point in points)]
    for number, (group, point) in enumerate(todo, 1):
        try:
            record = CaseInputs.from_sweep(group.sweep, point.case).simulate(point)
        except TriboError as error:
            if point in points[:1]:
                raise
            record = PointRecord(point, None, str(error))
        group.commit([record])
        report(Progress(done=number, total=len(todo)))
