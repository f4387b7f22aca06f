"""The search for the boundary of several surfaces or samples, gone through again from the store.

What a search asks for next follows from what it asked for before. So a search that goes on with a
store begins anew, takes from there what it asks for as long as it is there, and asks for the rest
as if it had never been interrupted. Only where there are points that no search asks for, such as
those of a whole plane, all that is there is known from the beginning.
"""

from __future__ import annotations

import functools
import math
from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass, field, replace

import numpy as np
from numpy.typing import NDArray

from pipeline.analysis.interpolation import crossing
from pipeline.run.boundary_search import BoundarySearch
from pipeline.store.schema import DONE, FAILED, LEADING, PENDING, chunks_of
from pipeline.store.write import Store
from pipeline.sweep.conditions import Conditions
from pipeline.sweep.criterion import decisive_rises, rise_limit
from pipeline.sweep.model import Point
from pipeline.sweep.rises import columns_needed
from tribo import Corrections, Criterion
from tribo.types import Array

_COLUMNS = (
    "normal_load",
    "rise_quantile",
    "mean_rise",
    "bulk_rise_quantile",
    "mean_bulk_response",
)


def _judged(conditions: Conditions) -> tuple[Criterion, float, Corrections | None]:
    """Conditions on which the decisive rise depends."""
    return conditions.decisive, conditions.bulk_ratio, conditions.corrections


_Place = tuple[int | None, int | None]  # surface and sample of a point
_Status = NDArray[np.int8]


@dataclass(frozen=True, slots=True, eq=False)
class Variant:
    """A surface, a sample or the scene itself, with points of its own.

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


@dataclass(slots=True)
class _Seen:
    """Points that the search for the boundary of a variant has seen, and those it waits for."""

    rises: dict[Point, Array] = field(default_factory=dict)
    failed: set[Point] = field(default_factory=set)
    asked: tuple[Point, ...] | None = None

    def note(self, found: dict[Point, Array | None]) -> None:
        """Take note of the rises at points, None where one failed."""
        for at, rises in found.items():
            if rises is None:
                self.failed.add(at)
            else:
                self.failed.discard(at)
                self.rises[at] = rises


class Replay:
    """The search for the boundary of each variant, and what it knows so far.

    Parameters
    ----------
    search : BoundarySearch
        The search at any limit.
    variants : sequence of Variant
        All that is searched.
    retry_failed : bool
        Whether points that have failed by now are asked for again.
    """

    def __init__(
        self,
        search: BoundarySearch,
        variants: Sequence[Variant],
        retry_failed: bool = False,
    ) -> None:
        self._search, self._variants = search, variants
        self._ended = (DONE,) if retry_failed else (DONE, FAILED)
        self._held: _Held | None = None
        self._seen: dict[_Place, _Seen] = {}
        self._inputs: list[tuple[float, ...]] = []
        self._critical: list[list[float]] = []
        self._fits: dict[float, Array] = {}  # coefficients of planes, by load

    def look(self, store: Store | None) -> None:
        """See in a store, if there is one, which points are done or have failed."""
        if store:
            self._held = _Held(store, self._search)

    def there(self) -> Iterator[Point]:
        """Points of the variants that are done or have failed."""
        if self._held:
            for variant in self._variants:
                for at in self._held.ended(variant.place):
                    yield Point(*at[:2], *variant.place)

    def wanted(self, variants: Sequence[Variant]) -> list[Point]:
        """Points to look at next; none once the boundary of each of these variants is known."""
        found = [
            Point(*at[:2], *variant.place) for variant in variants for at in self._missing(variant)
        ]
        self._ended = (DONE, FAILED)
        return found

    def leave(self, variants: Sequence[Variant]) -> None:
        """Expect the boundary of further variants from that of these, and forget their points.

        Of samples that share their points the first is learnt from, so that more change nothing.
        """
        for variant in variants:
            seen = self._seen.pop(variant.place)
            if variant.inputs:
                self._inputs.append(variant.inputs[0])
                self._critical.append(self._crossings(seen, rise_limit(variant.conditions[0])))
        if not self._inputs:
            return
        inputs, critical = np.array(self._inputs), np.log(self._critical)
        for load, column in zip(self._search.loads, critical.T, strict=True):
            at = np.isfinite(column)
            if np.count_nonzero(at) > inputs.shape[1] + 1:
                self._fits[load] = _plane(inputs[at], column[at])

    def _missing(self, variant: Variant) -> Sequence[Point]:
        """Points that the search for the boundary of a variant asks for, and the store lacks."""
        seen, held = self._seen.setdefault(variant.place, _Seen()), self._held
        if held and held.has_others(variant.place):
            seen.note(self._read(held, variant, held.ended(variant.place)))
            seen.asked = None
        if seen.asked is None:
            seen.asked = self._asked(variant, seen)
        while seen.asked:
            flags = [held.flag(variant.place, at) if held else PENDING for at in seen.asked]
            missing = [
                at for at, flag in zip(seen.asked, flags, strict=True) if flag not in self._ended
            ]
            if missing or held is None:
                return missing
            seen.note(self._read(held, variant, seen.asked))
            seen.asked = self._asked(variant, seen)
        return ()

    def _asked(self, variant: Variant, seen: _Seen) -> tuple[Point, ...]:
        """Points that the search for the boundary of a variant asks for next."""
        asked: set[Point] = set()
        for number, conditions in enumerate(variant.conditions):
            search = replace(self._search, limit=rise_limit(conditions))
            own = {at: float(rises[number]) for at, rises in seen.rises.items()}
            is_begun = bool(own) or not self._fits
            expected = None if is_begun else self._expected(variant.inputs[number])
            asked.update(search.wanted(own, seen.failed, expected))
        return tuple(asked)

    def _read(
        self, held: _Held, variant: Variant, ended: Iterable[Point]
    ) -> dict[Point, Array | None]:
        """Rises at points that have ended, None where one failed."""
        return {
            at: None
            if held.flag(variant.place, at) == FAILED
            else held.rises(Point(*at[:2], *variant.place), variant.conditions)
            for at in ended
        }

    def _expected(self, inputs: tuple[float, ...]) -> dict[float, float]:
        """Critical velocity that is expected of a sample, by load [m/s]."""
        at, lowest, highest = np.array([1.0, *inputs]), self._search.lowest, self._search.highest
        return {
            load: min(max(math.exp(float(at @ fit)), lowest), highest)
            for load, fit in self._fits.items()
        }

    def _crossings(self, seen: _Seen, limit: float) -> list[float]:
        """Critical velocity of a variant under its first conditions, by load; NaN where none is."""
        found = []
        for load in self._search.loads:
            row = sorted(at for at in seen.rises if at.load == load)
            velocities = np.array([at.velocity for at in row])
            rises = np.array([seen.rises[at][0] for at in row])
            found.append(crossing(velocities, rises, limit) if len(row) > 1 else math.nan)
        return found


class _Held:
    """Points of a store that belong to the variants that are searched.

    Parameters
    ----------
    store : Store
        The store, of these variants or of others.
    search : BoundarySearch
        The search at any limit.
    """

    def __init__(self, store: Store, search: BoundarySearch) -> None:
        self._store, self._flags = store, store.flags.copy()
        self._places = {
            name: {value: index for index, value in enumerate(store.axes[name])}
            for name in store.dims
        }
        self._chunks: dict[tuple[str, tuple[int, ...]], Array] = {}
        self._loads, self._velocities = store.axes["load"], store.axes["velocity"]
        self._are_searched = np.isin(self._loads, search.loads)[:, None]
        self._are_others = np.array([not search.may_ask(v) for v in self._velocities])

    def flag(self, place: _Place, at: Point) -> int:
        """Status of a point; pending if the store has no room for it."""
        velocity = self._places["velocity"].get(at.velocity)
        load = self._places["load"].get(at.load)
        if load is None or velocity is None:
            return PENDING
        return int(self._row(place)[load, velocity])

    def ended(self, place: _Place) -> list[Point]:
        """Points at the loads of the search that are done or have failed."""
        found = np.argwhere((self._row(place) != PENDING) & self._are_searched)
        return [Point(self._loads[i], self._velocities[j]) for i, j in found.tolist()]

    def has_others(self, place: _Place) -> bool:
        """Return whether the search never asks for one of them."""
        found = (self._row(place) != PENDING) & self._are_searched & self._are_others
        return bool(found.any())

    def _row(self, place: _Place) -> _Status:
        """Status of the points of a surface or sample by load and velocity."""
        given = {name: each for name, each in zip(LEADING, place, strict=True) if each is not None}
        leading = [name for name in LEADING if name in self._places]
        if list(given) != leading:
            return self._none
        indices = [self._places[name].get(given[name]) for name in leading]
        if None in indices:
            return self._none
        row: _Status = self._flags[(*indices,)]
        return row

    def rises(self, point: Point, each: Sequence[Conditions]) -> Array:
        """Decisive rise at a point under each of some conditions [K]."""
        names = dict.fromkeys((*_COLUMNS, *(name for own in each for name in columns_needed(own))))
        columns = {name: self._at(name, point) for name in names if name in self._store.arrays}
        rises: dict[tuple[Criterion, float, Corrections | None], float] = {}
        for conditions in each:
            judged = _judged(conditions)
            if judged not in rises:
                rises[judged] = float(decisive_rises(columns, point.load, conditions))
        return np.array([rises[_judged(own)] for own in each])

    def _at(self, name: str, point: Point) -> Array:
        """Column of a point, out of its chunk, which is kept for its neighbours."""
        index, sizes = self._store.index(point), chunks_of(self._store.metadata[name])
        chunk = tuple(i // n for i, n in zip(index, sizes, strict=False))
        block = self._store.block(chunk, sizes)
        if (name, chunk) not in self._chunks:
            self._chunks[name, chunk] = self._store.read(name, block)
        within = tuple(i - part.start for i, part in zip(index, block, strict=True))
        column: Array = self._chunks[name, chunk][within]
        return column

    @functools.cached_property
    def _none(self) -> _Status:
        return np.full((len(self._loads), len(self._velocities)), PENDING)


def _plane(inputs: Array, values: Array) -> Array:
    """Coefficients of the plane that is nearest to values over inputs, the constant first."""
    scale = np.maximum(np.ptp(inputs, axis=0), 1e-300)
    columns = np.column_stack([np.ones(len(inputs)), inputs / scale])
    fit: Array = np.linalg.lstsq(columns, values)[0]
    return np.append(fit[:1], fit[1:] / scale)
