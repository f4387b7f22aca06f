"""A goal of a run: which points of its store the boundary of each scene still needs."""

from __future__ import annotations

import math
from collections.abc import Iterable, Iterator
from dataclasses import replace
from typing import NamedTuple

import numpy as np
import xarray as xr

from pipeline.answers.discretization_error import presets_for, velocity_error
from pipeline.answers.error import PARTS, SURFACE, total
from pipeline.answers.results import CaseResults, ascending, cases_of
from pipeline.answers.verdict import JudgedCase, VerdictModel
from pipeline.progress import Progress, Report
from pipeline.run.search import MOST_REALIZATIONS, Goal, Search
from pipeline.scene.entries import entry_at
from pipeline.store.read import store_dataset
from pipeline.store.schema import DONE, FAILED
from pipeline.store.store import Store
from pipeline.sweep.conditions import allowable_rise
from pipeline.sweep.sweep import Point, Sweep
from pipeline.units import share_of
from tribo import InputError, SelfAffineRoughness

_ROOM = 0.8  # largest share of an accuracy that a preset may take
_LEAST_REALIZATIONS = 4  # of a new store: to make room for more takes as long as some points
_ADVICE = {
    "interpolation": "give more sweep.velocities",
    "discretization": "run it into another store, which may take a finer preset",
    "warnings": "change what the warnings name: irg status",
    "surface": "there are too few surface realizations: set a larger --accuracy",
}
"""What reduces the largest part of an error that is too large."""


def percent(share: float) -> str:
    """A share as text, such as "1.5 %"."""
    return "unknown" if np.isnan(share) else f"{100 * share:.3g} %"


def require_boundary(sweep: Sweep) -> None:
    """Raise an `InputError` unless a sweep has a boundary, whose error can be a goal."""
    why = ""
    if any({"load", "velocity"} & row.keys() for row in sweep.case_table.rows):
        why = "each row of the sweep has its own load and velocity"
    elif not any(velocity > 0 for velocity in sweep.velocities):
        why = "sweep.velocities has none above 0"
    elif any(case.critical_from_tests for case in sweep.cases):
        why = "temperature.critical is from tests, whose points come first; run without an accuracy"
    elif not np.isfinite([allowable_rise(case.conditions) for case in sweep.cases]).all():
        why = "friction.coefficient is 0"
    if why:
        raise InputError(f"there is no boundary whose error can be a goal: {why}")


def why_fixed(sweep: Sweep) -> str:
    """Why there are no further realizations of a sweep's surface, in words; empty if there are."""
    if sweep.scene.roughness is None:
        return "smooth, not reduced by computing"
    if not isinstance(sweep.scene.roughness, SelfAffineRoughness):
        areas = len(sweep.case_table.column("realization") or (0,))
        return f"{areas} area{'s' * (areas > 1)} of a scan, not reduced by computing"
    seeds = entry_at(sweep.source.entries, "sweep.realizations") if sweep.source else None
    return f"{len(seeds)} listed seeds, not reduced by computing" if isinstance(seeds, list) else ""


def with_preset_for(sweep: Sweep, before: Sweep | None, accuracy: float) -> Sweep:
    """The sweep with the coarsest preset whose error leaves room for others in an accuracy.

    `before` is the sweep of the store, if there is one, whose preset is kept.
    """
    if any(one.key.startswith("fidelity.") for one in sweep.case_table.columns):
        raise InputError("sweep.over varies [fidelity], which the accuracy chooses; leave it out")
    if before is not None:
        able = [sweep.with_fidelity(before.scene.fidelity, before.preset)]
    else:
        presets = presets_for(sweep.scene, ["standard", "fine"])
        able = [sweep.with_fidelity(one, name) for name, one in presets.items()]
    errors = [math.inf if (x := velocity_error(one)) is None else x for one in able]
    room = [one for one, error in zip(able, errors, strict=True) if error <= _ROOM * accuracy]
    if room or errors[-1] < accuracy:
        return room[0] if room else able[-1]
    which = "the preset of the store" if before else "the preset fine"
    known = f"errs by up to {percent(errors[-1])}" if errors[-1] < 1 else "has no known error"
    raise InputError(
        f"accuracy is {percent(accuracy)}, and {which} {known}; set a larger --accuracy"
        + (", or give another store by -o OUT.zarr" if before else "")
    )


class GoalRun:
    """A run whose goal is the relative error `accuracy` of the boundary of each scene of a sweep.

    `sweep` has the preset and the realizations that this takes. `before` is the sweep of the store,
    if there is one. `is_fixed` is True if no further realizations can be simulated.
    """

    def __init__(
        self,
        sweep: Sweep,
        before: Sweep | None,
        accuracy: float | str,
        report: Report,
    ) -> None:
        self.accuracy = share_of(accuracy)
        if isinstance(accuracy, bool) or not 0 < self.accuracy < 1:
            raise InputError(
                f"accuracy is {accuracy!r}, the boundary's relative error; give a share between 0 "
                'and 1, such as 0.02 or "2%"'
            )
        require_boundary(sweep)
        if before is None and sweep.steps is None:
            sweep = replace(sweep, steps="end")  # no earlier step decides
        chosen = with_preset_for(sweep, before, self.accuracy)
        own = ", in place of the scene's own [fidelity]" * (sweep.preset is None)
        error = percent(velocity_error(chosen) or 0.0)
        report(Progress(f"preset {chosen.preset} (up to {error}){own}"))
        self.is_fixed, self._report = bool(why_fixed(chosen)), report
        realizations = [len(x.case_table.axes.get("realization", ())) for x in (sweep, before) if x]
        self.sweep = chosen
        if not self.is_fixed:
            self.sweep = chosen._with_realizations(max(*realizations, _LEAST_REALIZATIONS))
        self.is_on_first_realization = True

    @property
    def _seeds(self) -> tuple[int, ...]:
        return tuple(map(int, self.sweep.case_table.axes.get("realization", (0,))))

    def next_points(self, store: Store) -> list[Point]:
        """Points to compute next, all on the first realization or all on others; empty at the end.

        `sweep` then has as many realizations as these points need. It may also have further
        velocities, where the search needs these before it can name points.
        """
        cases = cases_of(ascending(store_dataset(store)))
        found, to_come, most, between = list[tuple[Point, int]](), 0, 0, set[float]()
        has_seeds, axes = "realization" in self.sweep.case_table.axes, self._seeds
        seeds = axes if self.is_fixed else range(axes[0], axes[0] + MOST_REALIZATIONS)
        for case, search in searches(cases, self.accuracy, self.is_fixed, len(seeds)):
            places = search.next_places()
            between |= {*search.next_velocities()}
            most = max(most, *(place.realization + 1 for place in places)) if places else most
            to_come += search.to_come()
            for realization, load, velocity in places:
                at = float(search.loads[load]), float(search.velocities[velocity])
                seed = (("realization", seeds[realization]),) if has_seeds else ()
                found.append((Point(*at, (*case.name, *seed)), realization))
        if most > len(axes) and not self.is_fixed:
            # Those to come, too: to grow the store takes as long as some points.
            self.sweep = self.sweep._with_realizations(min(MOST_REALIZATIONS, most + most // 2))
        if between and not found:
            velocities = tuple(sorted({*self.sweep.velocities, *between}))
            self.sweep = replace(self.sweep, velocities=velocities)
        first = [point for point, realization in found if not realization]
        if found and not first and self.is_on_first_realization:
            self._report(Progress(f"first realization done; about {to_come} points to come"))
        self.is_on_first_realization = bool(first)
        return first or [point for point, _ in found]


def searches(
    cases: Iterable[CaseResults],
    accuracy: float,
    is_fixed: bool,
    realizations: int = MOST_REALIZATIONS,
) -> Iterator[tuple[CaseResults, Search]]:
    """The search of each case of a store, in the present state."""
    for case in cases:
        model = JudgedCase(case).under(case.sweep.conditions)
        yield case, search_of(model, Goal(accuracy, realizations, not is_fixed))


def search_of(model: VerdictModel, goal: Goal) -> Search:
    """The search of one case by what answers know of it."""
    case, specimen = model.case, model.specimen
    first = case.log_rises(model.conditions)[0] + specimen.mean.offset - model.limit
    tried = np.isin(case.status, (DONE, FAILED))
    return Search(specimen, model.limit, model.promised, first, tried, goal)


class Reached(NamedTuple):
    """Largest numerical error of the critical velocities of one scene, relative, at 95 %."""

    case: str  # values of varied entries that tell the scene from others
    preset: str | None
    load: float  # where the error is largest [N]; NaN if no load has a critical velocity
    total: float  # without the part by the surface, unless it counts
    parts: dict[str, float]  # at this load, by cause
    surface: float  # largest part by the surface at any load
    without: tuple[float, ...]  # loads without a critical velocity in the plane [N]

    def is_below(self, accuracy: float) -> bool:
        """True unless the error of a critical velocity is above `accuracy`, or unknown."""
        return not np.isfinite(self.load) or self.total < accuracy

    def lines(self, accuracy: float, surface: str) -> Iterator[str]:
        """Lines in words; `surface` says why its part does not count, or is empty."""
        case = f"{self.case}: " if self.case else ""
        if np.isfinite(self.load):
            counted = {k: x for k, x in self.parts.items() if x and (k != "surface" or not surface)}
            largest = max(counted, key=lambda name: np.nan_to_num(counted[name], nan=np.inf))
            is_below = self.is_below(accuracy)
            parts = ", ".join(f"{name} {percent(part)}" for name, part in counted.items())
            yield (
                f"{case}accuracy {percent(accuracy)} {'' if is_below else 'not '}reached: at most "
                f"± {percent(self.total)}, at {self.load:g} N ({parts})"
            )
            if not is_below:
                yield f"to reach it: {_ADVICE[largest]}"
            if surface and self.surface:
                yield f"surface up to ± {percent(self.surface)}: {surface}"
        if self.without:
            loads = ", ".join(f"{load:g}" for load in self.without)
            yield f"{case}no critical velocity in the plane at {loads} N"


def reached(ds: xr.Dataset, accuracy: float, is_fixed: bool) -> list[Reached]:
    """What was reached for each case of a dataset."""
    found = list[Reached]()
    for case, search in searches(cases_of(ds), accuracy, is_fixed):
        loads, crosses = search.loads, np.isfinite(search.critical)
        whole = total(np.delete(search.errors, SURFACE, axis=0) if is_fixed else search.errors)
        worst = int(np.argmax(np.where(crosses, np.nan_to_num(whole, nan=np.inf), -np.inf)))
        own = case.sweep.case_table.to_text(case.name) if case.name else {}
        found.append(
            Reached(
                case=", ".join(f"{key} {value}" for key, value in own.items()),
                preset=case.sweep.preset,
                load=float(loads[worst]) if crosses.any() else np.nan,
                total=float(whole[worst]),
                parts=dict(zip(PARTS, search.errors[:, worst].tolist(), strict=True)),
                surface=float(search.errors[SURFACE].max(where=crosses, initial=0.0)),
                without=tuple(loads[~crosses].tolist()),
            )
        )
    return found
