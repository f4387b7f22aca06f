"""A few points, simulated one after the other in this process, without a cluster."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from functools import partial

from pipeline.progress import Progress, Report, silent
from pipeline.store.points import copy_points
from pipeline.store.store import Store
from pipeline.sweep.plan import PointRecord, choose_stored_steps, run_point
from pipeline.sweep.sweep import Point
from tribo import TriboError


def run_serial(
    store: Store, points: Sequence[Point] = (), source: Store | None = None, report: Report = silent
) -> None:
    """Simulate the pending points of the tests in a store, then `points`, in their order.

    Points that the store `source` has are copied. An error at the first of `points` is raised;
    another one becomes the message of its point. `report` is called with the number of steps done,
    of those of all points.
    """
    if source is not None:
        copy_points(store, source)
    groups: list[tuple[Store, Sequence[Point], Sequence[Point]]] = [(store, points, points[:1])]
    if store.tests:
        groups.insert(0, (store.tests, store.tests.pending(), points[:0]))
    total = sum(
        _step_count(group, point) for group, group_points, _ in groups for point in group_points
    )
    done = 0
    for group, group_points, needed in groups:
        group.commit(_simulate(group, group_points, needed, report, done, total))
        done += sum(_step_count(group, point) for point in group_points)


def _step_count(store: Store, point: Point) -> int:
    """Number of steps that are simulated at a point."""
    scene = store.sweep.case(point.case).scene
    return choose_stored_steps(store.sweep).select(scene, point.load)[-1].index


def _report_steps(report: Report, before: int, total: int, progress: Progress) -> None:
    """Report the steps of a point, after `before` steps of other points."""
    report(Progress(done=before + progress.done, total=total))


def _simulate(
    store: Store,
    points: Sequence[Point],
    needed: Sequence[Point],
    report: Report,
    done: int,
    total: int,
) -> Iterator[PointRecord]:
    """Yield the record of each point; reports begin at `done` of `total` steps."""
    stored_steps = choose_stored_steps(store.sweep)
    for point in points:
        case = store.sweep.case(point.case)
        report_steps = partial(_report_steps, report, done, total)
        try:
            fields = store.fields_of(point.case)
            result = run_point(
                case.scene, stored_steps, point, None, report_steps, case.has_film, fields
            )
        except TriboError as error:
            if point in needed:
                raise
            yield PointRecord(point, None, str(error))
        else:
            yield result.record(bool(fields))
        done += _step_count(store, point)
