"""Boundary mode: a sweep that chooses its own velocities, to find the boundary and no more."""

from __future__ import annotations

import math
from collections import deque
from collections.abc import Callable, Iterable, Iterator, Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from pipeline.analysis.interpolation import crossing
from pipeline.run.boundary_search import BoundarySearch
from pipeline.run.sweep import Outcome, Progress, run_sweep
from pipeline.store import FAILED, PENDING, ROOT, PathLike, Store, StoreError, folder_of
from pipeline.sweep.criterion import Conditions, at_bulks, rise_limit, worst_moment
from pipeline.sweep.model import Point, Sweep
from pipeline.sweep.plan import points
from tribo import InputError
from tribo.thermal import rise_exceeded
from tribo.types import Array

_Place = tuple[Any, ...]  # surface and sample of a point

_FIRST = 16  # samples that are searched without knowing where others found their boundary
_GROWTH = 2.0  # of the number of samples that are searched at a time


def follow_boundary(
    sweep: Sweep,
    out: PathLike,
    tolerance: float = 0.01,
    workers: int | None = None,
    scheduler: str | None = None,
    progress: Callable[[Progress], None] | None = None,
    retry_failed: bool = False,
    tell: Callable[[str], None] | None = None,
) -> Outcome:
    """Find the critical velocity at each load of a sweep, with as few points as that takes.

    Where there are several surfaces, the boundary of each is searched for. So is that of each
    sample of unknown inputs: of a few first, of the others about where these let it be expected;
    samples that differ in friction and temperatures alone share their points. The result is a store
    like that of `pipeline.run_sweep`, with velocities that the search chose between the sweep's
    lowest and highest. It is resumed in the same way, begins with what is there, and can be
    completed to the whole sweep later.

    Parameters
    ----------
    sweep : Sweep
    out, workers, scheduler, progress, retry_failed, tell
        See `pipeline.run_sweep`.
    tolerance : float
        Relative error of the critical velocity, besides that of the scene's fidelity.

    Raises
    ------
    InputError
        If there is no boundary to look for: no friction, or one velocity alone.
    StoreMismatchError, StoreError, ExecutionError
        See `pipeline.run_sweep`.

    Examples
    --------
    >>> import pipeline
    >>> scene = pipeline.load_scene("workflows/first_try.toml")
    >>> outcome = pipeline.follow_boundary(scene, "results/edge.zarr")  # doctest: +SKIP
    >>> outcome.done  # doctest: +SKIP
    11
    """
    moving = [velocity for velocity in sweep.velocities if velocity > 0]
    variants = _variants(sweep)
    limits = [rise_limit(each) for variant in variants for each in variant.conditions]
    if not np.isfinite(limits).all() or len(moving) < 2:
        raise InputError(
            "there is no boundary to look for without friction, or between fewer than two "
            "velocities above 0"
        )
    search = _Search(BoundarySearch(sweep.loads, moving[0], moving[-1], limits[0], tolerance), out)
    batches = deque(_batches(variants) if sweep.samples else [variants])
    searched: list[_Variant] = []

    def further() -> Sweep | None:
        """The sweep at the points that are known or failed, and at those to look at next."""
        search.look(variants)
        while batches:
            if wanted := search.wanted(batches[0]):
                return _with_points(sweep, search.there | wanted)
            searched.extend(batches.popleft())
            if sweep.samples and batches:
                search.learn(searched)
        return None

    begun = further() or _with_points(sweep, search.there)
    return run_sweep(begun, out, workers, scheduler, progress, retry_failed, further, tell)


@dataclass(frozen=True, slots=True, eq=False)
class _Variant:
    """What has points of its own: a surface, a sample, or the scene itself.

    Attributes
    ----------
    place : tuple of int or None
        Surface and sample of its points.
    conditions : tuple of Conditions
        Conditions under each of which to find the boundary.
    inputs : tuple of tuple of float
        Values drawn for each of the conditions, on scales on which the boundary is about linear;
        none but for samples.
    """

    place: _Place
    conditions: tuple[Conditions, ...]
    inputs: tuple[tuple[float, ...], ...] = ()


def _variants(sweep: Sweep) -> list[_Variant]:
    if sweep.samples is None:
        seeds = sweep.realizations or (None,)
        return [_Variant((seed, None), (sweep.conditions,)) for seed in seeds]
    samples = sweep.samples
    conditions = [sweep.variant(sample=number).conditions for number in range(len(samples))]
    if not samples.are_simulated:
        return [_Variant((None, None), tuple(conditions))]
    alike: dict[int, list[int]] = {}
    for number, first in enumerate(samples.simulations):
        alike.setdefault(first, []).append(number)
    return [
        _Variant(
            (None, first),
            tuple(conditions[number] for number in each),
            tuple(samples.scaled(number) for number in each),
        )
        for first, each in alike.items()
    ]


def _batches(variants: Sequence[_Variant]) -> Iterator[Sequence[_Variant]]:
    """Samples to search at a time: few at first, from which the others learn."""
    begin, size = 0, _FIRST
    while begin < len(variants):
        yield variants[begin : begin + size]
        begin, size = begin + size, int(_GROWTH * size)


class _Search:
    """The search for the boundary of each variant, and what is known so far."""

    def __init__(self, search: BoundarySearch, out: PathLike) -> None:
        self.there: set[Point] = set()
        self._search, self._out = search, out
        self._rises: dict[_Place, dict[Point, Array]] = {}
        self._failed: dict[_Place, set[Point]] = {}
        self._seen: NDArray[np.int8] | None = None
        self._fits: dict[float, Array] = {}  # coefficients of planes, by load

    def look(self, variants: Sequence[_Variant]) -> None:
        """Read from the store what was not known yet."""
        if not (folder_of(self._out) / ROOT).exists():
            return
        store, by_place = Store(self._out), {each.place: each for each in variants}
        flags, _ = store.flags()
        before = np.full_like(flags, PENDING)
        if self._seen is not None:  # by a store that may have grown since
            before[tuple(map(slice, self._seen.shape))] = self._seen
        self._seen = flags
        for point in store.points_at(np.nonzero(flags != before)):
            status = flags[store.index(point)]
            if status == PENDING or point.load not in self._search.loads:
                continue
            if (variant := by_place.get(point[2:])) is None:
                continue
            at, known = Point(*point[:2]), self._rises.setdefault(point[2:], {})
            self.there.add(point)
            if status == FAILED:
                self._failed.setdefault(point[2:], set()).add(at)
            elif at not in known:
                try:
                    known[at] = _rises(store, point, variant.conditions)
                except StoreError:  # damaged, and computed again
                    flags[store.index(point)] = PENDING

    def wanted(self, variants: Sequence[_Variant]) -> set[Point]:
        """Points to look at next."""
        found: set[Point] = set()
        for variant in variants:
            known = self._rises.get(variant.place, {})
            failed = self._failed.get(variant.place, set())
            for number, conditions in enumerate(variant.conditions):
                search = replace(self._search, limit=rise_limit(conditions))
                own = {at: float(rises[number]) for at, rises in known.items()}
                expected = self._expected(variant.inputs[number]) if self._fits else None
                asked = search.wanted(own, failed, None if own else expected)
                found |= {Point(*at[:2], *variant.place) for at in asked}
        return found

    def learn(self, variants: Sequence[_Variant]) -> None:
        """Expect the boundary of further samples from that of those that were searched."""
        inputs = np.array([row for each in variants for row in each.inputs])
        found = np.log([row for each in variants for row in self._critical(each)])
        for load, column in zip(self._search.loads, found.T, strict=True):
            at = np.isfinite(column)
            if np.count_nonzero(at) > inputs.shape[1] + 1:
                self._fits[load] = _plane(inputs[at], column[at])

    def _expected(self, inputs: tuple[float, ...]) -> dict[float, float]:
        """Where the critical velocity of a sample is to be expected, by load."""
        at, lowest, highest = np.array([1.0, *inputs]), self._search.lowest, self._search.highest
        return {
            load: min(max(math.exp(float(at @ fit)), lowest), highest)
            for load, fit in self._fits.items()
        }

    def _critical(self, variant: _Variant) -> Array:
        """Critical velocity under each of its conditions, by load; NaN where it does not cross."""
        found = np.full((len(variant.conditions), len(self._search.loads)), math.nan)
        known = self._rises.get(variant.place, {})
        for column, load in enumerate(self._search.loads):
            row = sorted((at.velocity, at) for at in known if at.load == load)
            if len(row) < 2:
                continue
            velocities = np.array([velocity for velocity, _ in row])
            rises = np.array([known[at] for _, at in row])
            for number, conditions in enumerate(variant.conditions):
                limit = rise_limit(conditions)
                found[number, column] = crossing(velocities, rises[:, number], limit)
        return found


def _plane(inputs: Array, values: Array) -> Array:
    """Coefficients of the plane that is nearest to values over inputs, the constant first."""
    scale = np.maximum(np.ptp(inputs, axis=0), 1e-300)
    columns = np.column_stack([np.ones(len(inputs)), inputs / scale])
    fit: Array = np.linalg.lstsq(columns, values)[0]
    return np.append(fit[:1], fit[1:] / scale)


def _rises(store: Store, point: Point, each: Sequence[Conditions]) -> Array:
    """Decisive rise at a point under each of some conditions [K]."""
    names = [name for name in ("rise_quantile", "bulk_rise_quantile") if name in store.names]
    found = store.at(point, [*names, "normal_load"])
    known: dict[tuple[float, float], float] = {}
    for conditions in each:
        judged = conditions.failing_share, conditions.bulk_ratio
        if judged not in known:
            rises = rise_exceeded(at_bulks(found, conditions), conditions.failing_share)
            known[judged] = float(rises[worst_moment(rises, found["normal_load"], point.load)])
    return np.array([known[own.failing_share, own.bulk_ratio] for own in each])


def _with_points(sweep: Sweep, chosen: Iterable[Point]) -> Sweep:
    """The same sweep at these points alone."""
    asked = replace(sweep, chosen=tuple(chosen))
    velocities = tuple(sorted({point.velocity for point in points(asked)}))
    return replace(asked, velocities=velocities, chosen=points(asked))
