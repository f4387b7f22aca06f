"""The cheapest fidelity that keeps the error of a scene's boundary within a bound."""

from __future__ import annotations

import math
import statistics
import time
from collections.abc import Sequence
from dataclasses import replace
from typing import Any

import numpy as np

from pipeline.scene.scenefile import SceneLike, sweep_of
from pipeline.scene.units import share_of
from pipeline.store.place import PathLike, StoreMismatchError, require_writable
from pipeline.store.root import find_sweep
from pipeline.sweep.model import Point, Sweep
from pipeline.sweep.plan import step_count
from pipeline.sweep.selection import Selection, Trial
from pipeline.sweep.severity import rise_limit
from pipeline.sweep.stages import Progress, Report, duration, silent
from pipeline.tradeoff.probe import (
    YARDSTICK,
    OwnError,
    Target,
    Yardstick,
    dividing_pixels,
    measured,
    near_the_boundary,
    own_error,
    probe,
    some_places,
)
from tribo import PRESETS, ConvergenceError, Fidelity, InputError
from tribo.simulation import Trunks, contacts
from tribo.simulation.point_warnings import FEW_NODES

# `make promises` judges these together: change one, and judge all again.
_MARGIN, _DEVIATIONS = 1.3, 2.5
"""Error at loads that were not probed, where each touches other summits: the larger of two.

So much more than the largest that was found, or the mean with so many standard deviations.
Judged by `make promises`.
"""
_BETWEEN, _BETWEEN_FEW = 1.1, 1.5
"""Factors between velocities; the second where few touch, and a quantile is a staircase.

Judged by `make promises`.
"""
_ONE = 0.1
"""How much more the staircase moves the yardstick itself, where but one touches.

Judged by `make promises`.
"""
_SAME = 1.05  # factor of the finest error up to which a cheaper choice is no worse
_OF_HEAT = 0.7
"""Share of the accuracy that the present heat alone may err.

Judged by `make promises`.
"""
# What a probe costs, which decides no error.
_LOADS, _PLACES = 4, 6  # to look at, and with several surfaces
_APART = 0.05  # distance of ln(velocity) at a load, either way, from that of the boundary
_PASSES = 5.0  # times the yardstick's steps at each load that a probe takes, trials included
_OWN_PASSES = 2.5  # likewise at each point, without trials
_LONG = 5.0  # [s] of a probe from which on its duration is said before
_TIMED = 0.3  # [s] of contacts that are timed for it
_WORTH = 0.5  # share of the reference's steps in the whole sweep that a thorough probe may take
_FEWEST_STEPS = 50  # to know the heat of all the past
_OWN = "the scene's own fidelity"
_ONE_GRID = {"history_coarsening": 1, "contact_tolerance": 1e-2, "increments": 50, "imprint": 0.0}
_RUNGS: tuple[tuple[str, str, dict[str, Any]], ...] = (
    ("draft", "draft", {}),
    ("standard", "standard", {}),
    ("fine", "fine", {}),
    ("fine, one grid, solved more tightly", "fine", _ONE_GRID),
)


def choose_accuracy(
    sweep: SceneLike,
    accuracy: float | str,
    points: Sequence[Point] | None = None,
    store: PathLike | None = None,
    progress: Report | None = None,
) -> Sweep:
    """Give a sweep the cheapest fidelity within an accuracy, or keep that of its store."""
    sweep, accuracy = sweep_of(sweep), share_of(accuracy)
    stored = _find_stored(store)
    selection = stored and stored.about.selection
    if stored and not selection:
        raise StoreMismatchError(
            f"{store} was computed with the scene's own fidelity, not one picked for its "
            "accuracy; leave out --accuracy to go on with it, or write to another store with -o"
        )
    if not selection:
        selection = choose_fidelity(sweep, accuracy, points, progress)
    elif selection.error > accuracy:
        raise StoreMismatchError(
            f"{store} was computed with {selection.name}, whose boundary errs by "
            f"{100 * selection.error:.2g} %; write to another store for {100 * accuracy:g} %"
        )
    is_preset = selection.fidelity == PRESETS.get(selection.name)
    preset = selection.name if is_preset else None
    return sweep.changed(fidelity=selection.fidelity, preset=preset, selection=selection)


def measure_error(sweep: Sweep, store: PathLike, progress: Report) -> Sweep:
    """Give a sweep the error of its own fidelity, which its store has or a probe measures."""
    stored = _find_stored(store)
    selection = stored and stored.about.selection
    return sweep.changed(selection=selection or choose_fidelity(sweep, None, progress=progress))


def _find_stored(store: PathLike | None) -> Sweep | None:
    """Sweep of a store that a run goes on with; None for a new store, which must be writable."""
    stored = None if store is None else find_sweep(store)
    if store is not None and stored is None:
        require_writable(store)  # before the probe takes its time
    return stored


@np.errstate(under="ignore")
def choose_fidelity(
    sweep: SceneLike,
    accuracy: float | str | None,
    points: Sequence[Point] | None = None,
    progress: Report | None = None,
) -> Selection:
    """Find the cheapest numerical choice whose measured error is within a bound.

    Choices are tried near the boundary, the cheapest first, and compared with nearly exact steps
    until one is good enough. They are compared at two velocities for some of the loads, or at one
    if two would take about as long as the sweep at the reference. The choice does not depend on
    timings, so it is the same on every machine.

    Parameters
    ----------
    sweep : Sweep, str or path
        Scene to choose for, or its path or name; of its fidelity, only
        `pipeline.sweep.selection.KEPT_FIELDS` are kept.
    accuracy : float or str or None
        Pick the cheapest fidelity whose boundary errs by this at most, such as 0.02 or ``"2%"``.
        None keeps the scene's own choice, and measures its error.
    points : sequence of Point, optional
        Points to be accurate at; if not given, the boundary, which is looked at for four loads
        from the lowest to the highest.
    progress : callable, optional
        Called with a `Progress`, whose words say what is tried next.

    Raises
    ------
    InputError
        If the accuracy is not between 0 and 1, or there is no friction heat.

    Examples
    --------
    >>> import pipeline
    >>> selection = pipeline.choose_fidelity("first_try", accuracy="5%")  # doctest: +SKIP
    >>> print(selection)  # doctest: +SKIP
    """
    sweep = sweep_of(sweep)
    accuracy = None if accuracy is None else share_of(accuracy)
    if accuracy is not None and not 0 < accuracy < 1:
        raise InputError(f"accuracy is {accuracy!r}; it must be between 0 and 1, such as 0.02")
    if not math.isfinite(rise_limit(sweep.conditions)):
        raise InputError("friction is 0, so there is no boundary; give one above 0")
    if points and not all(point.velocity for point in points):
        raise InputError("velocity is 0, so there is no heat; an accuracy needs one above 0")
    began = time.perf_counter()
    told = progress or silent
    if (takes := probing_time(sweep, accuracy is not None)) > _LONG:
        told(Progress(f"takes roughly {duration(takes)}"))
    places = _probed_places(sweep)
    thorough = not points and _is_worth_it(sweep)
    if points:
        places = tuple(dict.fromkeys(Target(place.load, place.variant) for place in points))
    told(Progress("the boundary by the preset standard"))
    near, exponents = near_the_boundary(sweep, places)
    if points:
        by_place = dict(zip(places, exponents, strict=True))
        exponents = tuple(by_place[Target(place.load, place.variant)] for place in points)
    elif thorough:
        near, exponents = _both_sides(near), tuple(np.repeat(exponents, 2).tolist())
    exact = measured(sweep, points or near, exponents, told)
    told(Progress("the error of these steps themselves"))
    every = 2 if thorough else 1  # both points of each place, or one
    yardstick_error = own_error(
        sweep, exact.points[::every], exact.exponents[::every], exact.readings[::every]
    )
    everywhere = bool(points) or (
        thorough and len(places) == len(sweep.plane.loads) * len(sweep.variants.names)
    )
    selection = _first_within(sweep, accuracy, exact, yardstick_error, everywhere, told)
    return replace(selection, seconds=time.perf_counter() - began)


def _first_within(
    sweep: Sweep,
    accuracy: float | None,
    exact: Yardstick,
    yardstick_error: OwnError,
    everywhere: bool,
    progress: Report,
) -> Selection:
    """Take the cheapest choice whose error against the yardstick is within the accuracy.

    Without an accuracy that is the sweep's own choice.
    """
    rungs, past = [(_OWN, sweep.scene.fidelity)], sweep.scene.remembers_heat
    if accuracy is not None:
        past |= yardstick_error.heat_model > _OF_HEAT * accuracy
        rungs = _ladder(sweep, past)
    trials = []
    for number, (name, fidelity) in enumerate(rungs, 1):
        words = f"choice {number} of at most {len(rungs)}: {name}"
        progress(Progress(words, number - 1, len(rungs)))
        try:
            elapsed = probe(sweep, replace(fidelity, heat_model="elapsed"), exact.points)
        except ConvergenceError:
            if accuracy is None:
                raise
            continue
        against, nodes = replace(YARDSTICK, heat_model=fidelity.heat_model), exact.fewest_nodes
        error = _bound(exact.errors(elapsed), everywhere, nodes) + yardstick_error.of(against)
        error += _ONE / nodes
        trials.append(Trial(name, fidelity, error, elapsed.seconds))
        if accuracy is None or error <= accuracy:
            break
    else:
        if accuracy is not None:
            trials += _finest(sweep, accuracy, yardstick_error, past, exact.seconds)
            if trials[-1].error > accuracy:  # the cheapest that errs no more than the finest
                enough = [trial for trial in trials if trial.error <= _SAME * trials[-1].error]
                trials = trials[: trials.index(enough[0]) + 1]
    picked = trials[-1]
    return Selection(
        accuracy=accuracy,
        name=picked.name,
        fidelity=picked.fidelity,
        error=picked.error,
        coarser=exact.coarser,
        trials=tuple(trials),
        points=tuple((point.load, point.velocity) for point in exact.points),
        exact_seconds=exact.seconds,
        seconds=0.0,
    )


def _both_sides(points: Sequence[Point]) -> tuple[Point, ...]:
    """Points at velocities a little below and above those of each given point."""
    apart = math.exp(_APART)
    pairs = ((point, (point.velocity / apart, point.velocity * apart)) for point in points)
    return tuple(point._replace(velocity=v) for point, either in pairs for v in either)


def _probed_places(sweep: Sweep) -> tuple[Target, ...]:
    """Places of the boundary that a probe looks at."""
    return some_places(sweep, _PLACES if len(sweep.variants.names) > 1 else _LOADS)


def probing_time(sweep: Sweep, tries: bool = False) -> float:
    """Time to measure the error of a sweep's own fidelity, or to try others, by contacts now [s].

    Contacts are those of the yardstick while its load is low.
    """
    exact = sweep.changed(fidelity=dividing_pixels(sweep, YARDSTICK)).variant()
    velocity = max(map(abs, sweep.plane.velocities))
    times = list[float]()  # [s]; the first contact makes surface and kernels, too
    for _ in contacts(exact.scene, max(sweep.plane.loads), velocity, Trunks()):
        times.append(time.process_time())
        if len(times) > 1 and times[-1] - times[0] > _TIMED:
            break
    contact_time = (times[-1] - times[0]) / max(len(times) - 1, 1)
    sides = 2 if _is_worth_it(sweep) else 1
    passes = _PASSES if tries else _OWN_PASSES
    return passes * sides * _yardstick_steps(sweep) * contact_time


def _yardstick_steps(sweep: Sweep) -> int:
    """Steps of the yardstick to one point at each place that a probe looks at."""
    scene = sweep.changed(fidelity=dividing_pixels(sweep, YARDSTICK)).scene
    return sum(step_count(scene, place.load) for place in _probed_places(sweep))


def _is_worth_it(sweep: Sweep) -> bool:
    """True if a thorough probe takes few steps beside the whole sweep at the reference."""
    scene = sweep.changed(fidelity=dividing_pixels(sweep, PRESETS["reference"])).scene
    ends = [step_count(scene, load) for load in sweep.plane.loads]
    steps = sum(ends) if ends[0] == ends[-1] else ends[-1] + len(ends)
    return _PASSES * _yardstick_steps(sweep) <= _WORTH * steps * sweep.ramps


def _finest(
    sweep: Sweep, accuracy: float, yardstick_error: OwnError, past: bool, seconds: float
) -> list[Trial]:
    """The reference, and ever more steps of it until they are enough."""
    trials: list[Trial] = []
    for times in (1, 2, 4):
        finer = replace(PRESETS["reference"], increments=PRESETS["reference"].increments * times)
        name = "reference" if times == 1 else f"reference, {times} times the steps"
        name += ", with all heat so far" if past else ""
        fidelity = _chosen_fidelity(sweep, finer, past)
        more = finer.increments / YARDSTICK.increments
        trials.append(Trial(name, fidelity, yardstick_error.of(fidelity), seconds * more))
        if trials[-1].error <= accuracy or not yardstick_error.steps or yardstick_error.scatters:
            break
    return trials


def _bound(errors: Sequence[float], of_all_loads: bool, nodes: int) -> float:
    """Largest error to expect at any load."""
    largest = max(map(abs, errors))
    if of_all_loads:
        return (_BETWEEN if nodes >= FEW_NODES else _BETWEEN_FEW) * largest
    spread = statistics.stdev(errors) if len(errors) > 2 else 0.0
    return max(_MARGIN * largest, abs(statistics.mean(errors)) + _DEVIATIONS * spread)


def _ladder(sweep: Sweep, past: bool) -> list[tuple[str, Fidelity]]:
    """Fidelities from cheap to dear, each once."""
    ladder: dict[Fidelity, str] = {}
    for name, preset, changes in _RUNGS:
        fidelity = _chosen_fidelity(sweep, replace(PRESETS[preset], **changes), past)
        name += ", with all heat so far" if past else ""
        ladder.setdefault(fidelity, name)
    return [(name, fidelity) for fidelity, name in ladder.items()]


def _chosen_fidelity(sweep: Sweep, fidelity: Fidelity, past: bool) -> Fidelity:
    """A fidelity with the scene's own heat, or with that of all the past."""
    if past:  # which needs every step on one grid
        steps = max(fidelity.increments, _FEWEST_STEPS)
        fidelity = replace(fidelity, history_coarsening=1, heat_model="history", increments=steps)
    return dividing_pixels(sweep, fidelity)
