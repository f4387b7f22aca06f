"""The goal of a run: searches of the boundaries of a sweep's scenes, on the points of its store."""

from __future__ import annotations

import math
from dataclasses import dataclass, field

import numpy as np

from pipeline.analysis.preset_error import velocity_error
from pipeline.analysis.reached import percent
from pipeline.analysis.specimen import Alone
from pipeline.run.search import MOST_PATCHES, Goal, Place, Search
from pipeline.scene.entries import entry_at
from pipeline.store.schema import DONE, NOT_ASKED, PENDING
from pipeline.store.store import Store
from pipeline.sweep.case import Case
from pipeline.sweep.conditions import rise_limit
from pipeline.sweep.stations import load_that_counts
from pipeline.sweep.sweep import Point, Sweep
from pipeline.sweep.variants import Variant
from tribo import InputError, SelfAffineRoughness
from tribo.simulation.severity import relative_sampling, worst_rises

_ROUNDING = 1e-9
_MORE = 1.4  # further patches that are needed at last, over those by one patch's own estimate


def require_boundary(sweep: Sweep) -> None:
    """Raise an `InputError` unless a sweep has a boundary, whose error can be a goal."""
    if any({"load", "velocity"} & row.keys() for row in sweep.variants.rows):
        raise InputError(
            "each row of the sweep has its own load and velocity, so there is no boundary in a "
            "plane of them; run without --accuracy"
        )
    if not any(velocity > 0 for velocity in sweep.velocities):
        raise InputError(
            "sweep.velocities has none above 0, so there is no boundary; give others, or run "
            "without --accuracy"
        )
    if not np.isfinite([rise_limit(case.conditions) for case in sweep.cases]).all():
        raise InputError("there is no boundary without friction: set friction.coefficient")


def why_fixed(sweep: Sweep) -> str:
    """Why there are no further patches of a sweep's surface, in words; empty if there are."""
    seeds = entry_at(sweep.source.entries, "sweep.realizations") if sweep.source else None
    if isinstance(seeds, list):
        return f"{len(seeds)} listed seeds, not reduced by computing"
    if isinstance(sweep.scene.roughness, SelfAffineRoughness):
        return ""
    kind = "one scan" if sweep.scene.roughness else "smooth"
    return f"{kind}, not reduced by computing"


@dataclass
class _Searched:
    """The search of one scene, and the points that it has asked for."""

    name: Variant
    case: Case
    search: Search
    batch: list[Place] = field(default_factory=list)


class Searches:
    """Searches of the boundary of each scene of a sweep, side by side.

    The whole error is to be below `accuracy`; with `only_first` that by points left out of the
    first patch. `patches` is the number of those that a store has.
    """

    def __init__(
        self, sweep: Sweep, accuracy: float, only_first: bool = False, patches: int = 1
    ) -> None:
        self._accuracy, self._only_first = accuracy, only_first
        self.asked_for = None if only_first else accuracy
        self._grows = not only_first and not why_fixed(sweep)
        self.sweep = sweep._with_patches(patches) if self._grows else sweep
        seeds = self.sweep.variants.axes.get("realization", (0,))
        self._seeds = range(int(seeds[0]), 2**31) if self._grows else seeds
        most = MOST_PATCHES if self._grows else 1 if only_first else len(seeds)
        promised = 0.0 if only_first else velocity_error(sweep) or 0.0
        goal = Goal(accuracy, promised, most, counts_surface=self._grows)
        loads = np.array(sweep.loads)
        velocities = np.array([one for one in sweep.velocities if one > 0])
        self._all = [
            _Searched(
                tuple(label for label in case.name if label[0] != "realization"),
                case,
                Search(
                    loads, velocities, case.conditions, goal._replace(alone=Alone.of(case.scene))
                ),
            )
            for case in sweep._given
        ]
        self._told = False
        self.is_on_first_patch = True

    def next_points(self, store: Store) -> list[Point]:
        """Points to compute next, all on the first patch or all on further ones; empty at the end.

        It tells each search what the store has of the points that the search has asked for.
        `sweep` then has as many patches as these points need.
        """
        missing: list[Point] = []
        most = 1
        for one in self._all:
            while batch := one.batch or one.search.ask():
                one.batch = batch
                lacking = [point for point in self._points(one) if self._is_missing(store, point)]
                if lacking:
                    missing += lacking
                    # Those to come, too: to grow the store takes as long as some points.
                    most = max(most, one.search.patches, *(place.patch + 1 for place in batch))
                    break
                self._tell(store, one)
                one.batch = []
        if self._grows and most > len(self.sweep.variants.axes["realization"]):
            self.sweep = self.sweep._with_patches(most)
        first = [point for point in missing if self._is_first(point)]
        self.is_on_first_patch = bool(first)
        return first or missing

    def _is_first(self, point: Point) -> bool:
        return dict(point.variant).get("realization", self._seeds[0]) == self._seeds[0]

    def _points(self, one: _Searched) -> list[Point]:
        """The points that a search has asked for, in their order."""
        search, has_seeds = one.search, "realization" in self.sweep.variants.axes
        return [
            Point(
                float(search.loads[load]),
                float(search.velocities[velocity]),
                one.name + ((("realization", self._seeds[patch]),) if has_seeds else ()),
            )
            for patch, load, velocity in one.batch
        ]

    def _is_missing(self, store: Store, point: Point) -> bool:
        seeds = store.axes.get("realization", self._seeds)
        is_there = dict(point.variant).get("realization", self._seeds[0]) in seeds
        return not is_there or store.flags[store.index(point)] in (PENDING, NOT_ASKED)

    def _tell(self, store: Store, one: _Searched) -> None:
        """Tell a search what the store has of the points that it has asked for."""
        points = np.array([store.index(point) for point in self._points(one)]).T
        begins = points.min(axis=1)
        box = tuple(map(slice, begins, points.max(axis=1) + 1))
        at = tuple(points - begins[:, None])
        columns = store.read_steps(box)
        conditions, search = one.case.conditions, one.search
        (along,) = store.group.variables["load"].dims
        place = store.dims.index(along)
        loads = [load_that_counts(one.case.scene, load) for load in store.axes["load"]]
        counted = np.array(loads)[box[place]].reshape(-1, *[1] * (len(store.dims) - place))
        rises = worst_rises(columns, counted, conditions)[at]
        rises = rises / conditions.friction_factor(
            search.velocities[[p.velocity for p in one.batch]]
        )
        own = {name: store.read(name, box) for name in ("rise_sampling", "mean_rise_sampling")}
        sampling = relative_sampling(columns | own, conditions)[at]
        flags, status = store.read("warning_flags", box)[at], store.flags[box][at]
        done = status == DONE
        search.tell(
            one.batch,
            np.where(done, rises, np.nan),
            np.where(done, sampling, np.nan),
            np.where(done, flags, 0),
            np.where(done, np.nan_to_num(columns["time"], nan=0.0).max(axis=-1)[at], 0.0),
        )

    def forecast(self) -> int | None:
        """About how many points are to come, once the first patch is done; None before and later.

        Raises an `InputError` if the goal is out of reach by what is known now.
        """
        searches = [one.search for one in self._all]
        if self._only_first or not all(one.is_first_patch_done for one in searches):
            return None
        for one in self._all:
            if one.batch:
                self._require_reach(one.search)
        if self._told:
            return None
        self._told = True
        return sum(round(_MORE * one.to_come()) for one in searches)

    def _require_reach(self, search: Search) -> None:
        best, worst = search.best()
        if best <= self._accuracy * (1 + _ROUNDING):
            return
        load, patches = f"{search.loads[worst]:g} N", search.goal.patches
        if math.isnan(best):
            raise InputError(
                f"accuracy is {percent(self._accuracy)}, and points at {load} have warnings whose "
                "error is not known (irg status): change what they name, or run without --accuracy"
            )
        by = f" by {patches} patches of the surface" if patches > 1 else ""
        raise InputError(
            f"accuracy is {percent(self._accuracy)}, which is out of reach: the least error at "
            f"{load} is {percent(best)}{by}; give more than that, or more sweep.velocities"
        )
