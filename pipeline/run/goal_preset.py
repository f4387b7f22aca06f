"""Begin a run with a goal: choose preset and heat model by a few points, or keep the store's."""

from __future__ import annotations

import time
from collections.abc import Callable, Iterable, Sequence
from dataclasses import replace

import numpy as np

from pipeline.analysis.preset_error import presets_for, velocity_error
from pipeline.analysis.reached import percent
from pipeline.progress import Progress, Report, silent
from pipeline.run.goal import Searches, require_boundary, why_fixed
from pipeline.run.search import Goal, Place, Search
from pipeline.sweep.plan import PointResult, choose_stations, run_point
from pipeline.sweep.sweep import Point, Sweep
from pipeline.units import share_of
from tribo import PRESETS, Fidelity, InputError, WarningKind
from tribo.simulation import forget_contacts
from tribo.simulation.severity import relative_sampling, worst_rises

_WORTH = 0.8  # costs below this share of those of a faster preset choose a slower one
_DEARER = 1.7  # least ratio of a point's times by a preset and a faster one; 1.7 to 7 as shipped
ROOM, ROOM_AT_ADDRESS = 4, 32
"""Patches of a new store in a folder, and on an object store, where it cannot get more."""
_NEAR = 0.1  # error of a crossing beside which heat is looked at


def begin_goal(
    sweep: Sweep, before: Sweep | None, accuracy: float | str, report: Report, room: int = ROOM
) -> Searches:
    """Searches that reach an accuracy of a sweep, with the preset that this takes.

    `before` is the sweep of the store, if there is one; its preset is kept where it suffices. A new
    store has room for at least as many patches as `room`.
    """
    accuracy = share_of(accuracy)
    if isinstance(accuracy, bool) or not 0 < accuracy < 1:
        raise InputError(
            f"accuracy is {accuracy!r}, the boundary's relative error; give a share between 0 and "
            '1, such as 0.02 or "2%"'
        )
    require_boundary(sweep)
    if any(one.key.startswith("fidelity.") for one in sweep.variants.columns):
        raise InputError("sweep.over varies [fidelity], which the accuracy chooses; leave it out")
    if before is None:
        chosen = choose_preset(goal_presets(sweep), accuracy, seconds_of_point)
    else:
        chosen = sweep.with_fidelity(before.scene.fidelity, before.preset)
        if (error := velocity_error(chosen)) is None or error >= accuracy:
            known = "is not known" if error is None else f"is up to {percent(error)}"
            raise InputError(
                f"accuracy is {percent(accuracy)}, and the error of the store's numerical choices "
                f"({before.preset or 'its own'}) {known}; give another store by -o OUT.zarr"
            )
    promised = percent(velocity_error(chosen) or 0.0)
    words = f"preset {chosen.preset} (up to {promised})"
    has_past = chosen.scene.remembers_heat and not sweep.scene.remembers_heat
    words += ', heat_model "history"' * has_past
    words += ", in place of the scene's own [fidelity]" * (sweep.preset is None)
    report(Progress(words))
    chosen = replace(chosen, text=f"# run with --accuracy: {words}\n{chosen.text}")
    has_room = [len(one.variants.axes.get("realization", ())) for one in (sweep, before) if one]
    return Searches(chosen, accuracy, patches=max(*has_room, room))


def goal_presets(sweep: Sweep) -> tuple[Sweep, ...]:
    """The sweep with each preset that a goal may take, the fastest first.

    Heat acts at its own time if points beside the boundary have the warning "present heat".
    """
    presets = presets_for(sweep.scene, [name for name in PRESETS if name != "reference"])
    if not sweep.scene.remembers_heat and _needs_history(_with(sweep, presets, "standard")):
        presets = {name: replace(one, heat_model="history") for name, one in presets.items()}
    return tuple(_with(sweep, presets, name) for name in presets)


def choose_preset(
    presets: Sequence[Sweep], accuracy: float, seconds: Callable[[Sweep], float]
) -> Sweep:
    """The sweep of `goal_presets` that is likely to cost least; `seconds` are those of a point."""
    errors = [velocity_error(one) or 0.0 for one in presets]
    able = [pair for pair in zip(presets, errors, strict=True) if pair[1] < accuracy]
    if not able:
        best, sweep = min(zip(errors, presets, strict=True), key=lambda pair: pair[0])
        raise InputError(
            f"accuracy is {percent(accuracy)}, and the preset {sweep.preset} errs by up to "
            f"{percent(best)}; give more than that"
        )
    # The number of patches goes with the square of the error that a preset leaves.
    fewer = (accuracy**2 - able[-1][1] ** 2) / (accuracy**2 - able[0][1] ** 2)
    if why_fixed(presets[0]) or _WORTH * fewer <= _DEARER:
        return able[0][0]
    costs = [seconds(one) / (accuracy**2 - error**2) for one, error in able]
    cheapest = int(np.argmin(costs))
    return able[cheapest if costs[cheapest] < _WORTH * costs[0] else 0][0]


def _with(sweep: Sweep, presets: dict[str, Fidelity], name: str) -> Sweep:
    return sweep.with_fidelity(presets[name], name)


def _slowest(sweep: Sweep) -> float:
    return min(velocity for velocity in sweep.velocities if velocity > 0)


def _simulate(sweep: Sweep, load: float, velocity: float) -> PointResult:
    """A point of the first scene of a sweep."""
    case = sweep._given[0]
    return run_point(case.scene, choose_stations(sweep), Point(load, velocity, case.name))


def seconds_of_point(sweep: Sweep) -> float:
    """Processor time of a point at the highest load, without making surfaces and kernels."""
    place = sweep.loads[-1], _slowest(sweep)
    _simulate(sweep, *place)
    forget_contacts()
    began = time.process_time()
    _simulate(sweep, *place)
    return time.process_time() - began


def simulate_search(
    sweep: Sweep, search: Search, report: Report = silent
) -> dict[Place, tuple[PointResult, float]]:
    """Simulate what a search on the first patch asks for; return points and processor times [s]."""
    conditions, found = search.conditions, dict[Place, tuple[PointResult, float]]()
    while batch := search.ask():
        for place in batch:
            began = time.process_time()
            load, velocity = search.loads[place.load], search.velocities[place.velocity]
            result = _simulate(sweep, float(load), float(velocity))
            found[place] = result, time.process_time() - began
            rise = worst_rises(result.columns, np.array([result.least_load]), conditions)
            factor = conditions.friction_factor(np.atleast_1d(velocity))
            own = {**result.columns, **result.sampling}
            search.tell(
                [place],
                np.atleast_1d(rise) / factor,
                np.atleast_1d(relative_sampling(own, conditions)),
                sum({int(one.kind) for one in result.warnings}),
                float(np.nan_to_num(result.columns["time"]).max()),
            )
        report(Progress(f"{len(found)} points"))
    return found


def _needs_history(sweep: Sweep) -> bool:
    """True if points beside the boundary have the warning "present heat"."""
    loads = sorted({sweep.loads[0], sweep.loads[-1]})
    # Present heat errs most where a pin is slow.
    if not _warned(_simulate(sweep, load, _slowest(sweep)) for load in loads):
        return False
    conditions = sweep._given[0].conditions
    velocities = np.array([one for one in sweep.velocities if one > 0])
    search = Search(np.array(loads), velocities, conditions, Goal(_NEAR, 0.0, 1, False))
    found = simulate_search(sweep, search)
    beside = list[PointResult]()
    for load in np.flatnonzero(np.isfinite(search.critical)).tolist():
        own = [place for place in found if place.load == load]
        nearest = min(own, key=lambda at: abs(velocities[at.velocity] - search.critical[load]))
        beside.append(found[nearest][0])
    return _warned(beside)


def _warned(results: Iterable[PointResult]) -> bool:
    return any(
        one.kind is WarningKind.PRESENT_HEAT for result in results for one in result.warnings
    )
