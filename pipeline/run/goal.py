"""Goal of a run: which points the boundary of each scene still needs."""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import replace
from typing import NamedTuple

import numpy as np
import xarray as xr

from pipeline.answers.case_results import CaseResults
from pipeline.answers.error import (
    PARTS,
    SURFACE,
    position_limit,
    preset_error_of,
    presets_for,
    total,
)
from pipeline.answers.results import ascending, cases_of
from pipeline.answers.verdict_model import verdict_model
from pipeline.kinds import ACCURACY
from pipeline.progress import Progress, Report
from pipeline.run.search import MOST_REALIZATIONS, Goal, Search
from pipeline.scene.entries import entry_at
from pipeline.store.schema import DONE, FAILED
from pipeline.sweep.case import known_critical_temperature
from pipeline.sweep.sweep import Point, Sweep
from pipeline.sweep.user_laws import UserSurface
from tribo import InputError, SelfAffineRoughness

_MAX_PRESET_SHARE = 0.8  # of an accuracy, for the preset's error
_LEAST_REALIZATIONS = 4  # of a new store; extending it takes as long as some points
_ADVICE = {
    "interpolation": "give more sweep.velocities",
    "discretization": "run it into another store, which may have a finer preset",
    "warnings": "follow the warnings that irg status prints",
    "positions": "use more areas of the surface (sweep.realizations), or a larger --accuracy",
    "surface": "there are too few surface realizations: set a larger --accuracy",
}
"""How to reduce an error that is too large, by its largest part."""


def percent(share: float) -> str:
    """A share as text, such as "1.5 %"."""
    return "unknown" if np.isnan(share) else f"{100 * share:.3g} %"


def require_boundary(sweep: Sweep) -> None:
    """Raise an `InputError` unless a sweep has a boundary whose error can be a goal."""
    reason = ""
    if any({"load", "velocity"} & row.keys() for row in sweep.case_table.rows):
        reason = "each row of the sweep has its own load and velocity"
    elif not any(velocity > 0 for velocity in sweep.velocities):
        reason = "no velocity is above 0"
    elif not all(case.conditions.friction for case in sweep.cases):
        reason = "friction.coefficient is 0"
    else:
        for case in sweep.cases:
            if not case.critical_from_tests:
                known_critical_temperature(case.conditions)
    if reason:
        raise InputError(f"the sweep has no boundary whose error can be a goal: {reason}")


def reason_surface_is_fixed(sweep: Sweep) -> str:
    """Why a sweep's surface has no further realizations, in words; empty if it has."""
    if sweep.scene.roughness is None:
        return "the surface is smooth"
    if not isinstance(sweep.scene.roughness, SelfAffineRoughness):
        if isinstance(sweep.scene.roughness, UserSurface):
            return "the surface is of a user's class"
        areas = len(sweep.case_table.column("realization") or (0,))
        return "one area of a scan is used" if areas == 1 else f"{areas} areas of a scan are used"
    seeds = entry_at(sweep.source.entries, "sweep.realizations") if sweep.source else None
    return f"{len(seeds)} seeds are listed" if isinstance(seeds, list) else ""


def with_preset_for(sweep: Sweep, before: Sweep | None, accuracy: float) -> Sweep:
    """The sweep with the coarsest preset whose error is a small enough share of an accuracy.

    `before` is the sweep of the store, if there is one; its preset does not change.
    """
    if any(column.key.startswith("fidelity.") for column in sweep.case_table.columns):
        raise InputError("sweep.over varies [fidelity], which the accuracy chooses; leave it out")
    if before is not None:
        candidates = [sweep.with_fidelity(before.scene.fidelity, before.preset)]
    else:
        presets = presets_for(sweep.scene, ["standard", "fine"])
        candidates = [sweep.with_fidelity(fidelity, name) for name, fidelity in presets.items()]
    errors = [
        math.inf if (x := preset_error_of(candidate)) is None else x for candidate in candidates
    ]
    suitable = [
        candidate
        for candidate, error in zip(candidates, errors, strict=True)
        if error <= _MAX_PRESET_SHARE * accuracy
    ]
    if suitable or errors[-1] < accuracy:
        return suitable[0] if suitable else candidates[-1]
    subject = "the store's preset" if before else "the preset fine"
    statement = (
        f"may err by {percent(errors[-1])}" if errors[-1] < 1 else "has no known error bound"
    )
    advice = "set a larger --accuracy"
    if before:
        advice = "set a larger --accuracy, or write to another store with -o OUT.zarr"
    raise InputError(f"accuracy is {percent(accuracy)}, and {subject} {statement}; {advice}")


class GoalPlan:
    """Chooses points until the boundary of each scene of a sweep has at most an error.

    `accuracy` is this error, relative, and `before` the sweep of the store, if there is one. The
    attribute `sweep` has the preset, velocities and realizations needed; `is_fixed` is True if no
    further realizations can be simulated.
    """

    def __init__(
        self,
        sweep: Sweep,
        before: Sweep | None,
        accuracy: float | str,
        report: Report,
    ) -> None:
        self.accuracy: float = ACCURACY.argument("accuracy", accuracy)
        require_boundary(sweep)
        if before is None and sweep.steps is None:
            sweep = replace(sweep, steps="end")  # no earlier step governs
        chosen = with_preset_for(sweep, before, self.accuracy)
        error = percent(preset_error_of(chosen) or 0.0)
        if limit := position_limit(chosen):
            error = f"{error}; by positions of the disk, {percent(limit)} of the rise"
        choice = f"preset {chosen.preset} (error at most {error})"
        if sweep.preset is None:
            choice = f"{choice} replaces [fidelity] of the scene"
        report(Progress(choice))
        self.is_fixed = bool(reason_surface_is_fixed(chosen))
        realizations = [len(x.case_table.axes.get("realization", ())) for x in (sweep, before) if x]
        self.sweep = chosen
        if not self.is_fixed:
            self.sweep = chosen.with_realizations(max(*realizations, _LEAST_REALIZATIONS))

    def ask(self, ds: xr.Dataset) -> list[Point]:
        """Points to compute next, of the first realization if it needs any; empty at the end.

        `ds` is the store's present state. `sweep` gets the realizations that these points need, or
        further velocities if the search needs these first.
        """
        points, count, new_velocities = list[tuple[Point, int]](), 0, set[float]()
        seeds = self.sweep.case_table.axes.get("realization", ())
        available = [*map(int, seeds or (0,))]
        if not self.is_fixed:
            available = [available[0] + number for number in range(MOST_REALIZATIONS)]
        for case in cases_of(ascending(ds)):
            search = search_of(case, self.accuracy, self.is_fixed, len(available))
            indices, velocities = search.ask()
            new_velocities |= {*velocities}
            count = max([count, *(index.realization + 1 for index in indices)])
            for realization, load, velocity in indices:
                coordinates = float(search.loads[load]), float(search.velocities[velocity])
                seed = (("realization", available[realization]),) if seeds else ()
                points.append((Point(*coordinates, (*case.name, *seed)), realization))
        if count > len(seeds or (0,)) and not self.is_fixed:
            # More than needed now, because extending the store takes as long as some points.
            self.sweep = self.sweep.with_realizations(min(MOST_REALIZATIONS, count + count // 2))
        if new_velocities and not points:
            all_velocities = tuple(sorted({*self.sweep.velocities, *new_velocities}))
            self.sweep = replace(self.sweep, velocities=all_velocities)
        first_points = [point for point, realization in points if not realization]
        return first_points or [point for point, _ in points]


def search_of(
    case: CaseResults, accuracy: float, is_fixed: bool, realizations: int = MOST_REALIZATIONS
) -> Search:
    """The search of one case of a store in its present state."""
    model, goal = verdict_model(case, case.conditions), Goal(accuracy, realizations, not is_fixed)
    first = case.log_rises(model.conditions)[0] + model.specimen.mean.offset - model.limit
    tried = np.isin(case.status, (DONE, FAILED))
    return Search(model.specimen, model.limit, model.preset_error, first, tried, goal)


class GoalOutcome(NamedTuple):
    """Largest numerical error of the critical velocities of one scene, relative, at 95 %."""

    case: str  # values of the varied entries of the scene
    preset: str | None
    load: float  # load with the largest error [N]; NaN if none has a critical velocity
    total: float  # error at this load, without surface sampling unless that counts
    parts: dict[str, float]  # parts of the error at this load
    surface: float  # largest error by surface sampling at any load
    loads_without_transition: tuple[float, ...]  # in the velocities of the plane [N]

    def is_below(self, accuracy: float) -> bool:
        """True unless the error of a critical velocity is above `accuracy`, or unknown."""
        return not np.isfinite(self.load) or self.total < accuracy

    def lines(self, accuracy: float, surface: str) -> Iterator[str]:
        """Lines of text; `surface` is the reason why its part does not count, or empty."""
        case = f"{self.case}: " if self.case else ""
        if np.isfinite(self.load):
            counted = {k: x for k, x in self.parts.items() if x and (k != "surface" or not surface)}
            largest = max(counted, key=lambda name: np.nan_to_num(counted[name], nan=np.inf))
            outcome = "reached" if self.is_below(accuracy) else "not reached"
            parts = ", ".join(f"{name} {percent(part)}" for name, part in counted.items())
            yield (
                f"{case}accuracy {percent(accuracy)} {outcome}: at most "
                f"± {percent(self.total)}, at {self.load:g} N ({parts})"
            )
            if not self.is_below(accuracy):
                yield f"to reach it: {_ADVICE[largest]}"
            if surface and self.surface:
                yield (
                    f"surface sampling: up to ± {percent(self.surface)}, which the goal does not "
                    f"count, because {surface}"
                )
        if self.loads_without_transition:
            loads = ", ".join(f"{load:g}" for load in self.loads_without_transition)
            yield f"{case}no critical velocity in the plane at {loads} N"


def goal_outcomes(ds: xr.Dataset, accuracy: float, is_fixed: bool) -> list[GoalOutcome]:
    """Largest error of each case of a dataset."""
    outcomes = list[GoalOutcome]()
    for case in cases_of(ds):
        search = search_of(case, accuracy, is_fixed)
        loads, crosses = search.loads, np.isfinite(search.critical)
        totals = total(np.delete(search.errors, SURFACE, axis=0) if is_fixed else search.errors)
        worst = int(np.argmax(np.where(crosses, np.nan_to_num(totals, nan=np.inf), -np.inf)))
        labels = case.sweep.case_table.to_text(case.name) if case.name else {}
        outcomes.append(
            GoalOutcome(
                case=", ".join(f"{key} {value}" for key, value in labels.items()),
                preset=case.sweep.preset,
                load=float(loads[worst]) if crosses.any() else np.nan,
                total=float(totals[worst]),
                parts=dict(zip(PARTS, search.errors[:, worst].tolist(), strict=True)),
                surface=float(search.errors[SURFACE].max(where=crosses, initial=0.0)),
                loads_without_transition=tuple(loads[~crosses].tolist()),
            )
        )
    return outcomes
