"""The cheapest fidelity that keeps a scene's boundary within an asked accuracy."""

from __future__ import annotations

import math
import statistics
import time
from collections.abc import Callable, Iterator, Sequence
from dataclasses import replace
from typing import NamedTuple

from pipeline.store.folder import ROOT, PathLike, StoreMismatchError, folder_of, read_metadata
from pipeline.sweep.criterion import boundary_velocity_error, rise_limit
from pipeline.sweep.model import Sweep
from pipeline.sweep.plan import Point
from pipeline.sweep.selection import Selection, Trial
from pipeline.tradeoff.probe import (
    Probe,
    fitted,
    near_the_boundary,
    probe,
    some_loads,
)
from tribo import PRESETS, ConvergenceError, Fidelity, InputError

__all__ = ["at_accuracy", "choose_fidelity", "stored_selection"]

_LOADS = 4
# Elements times convolutions, some seconds, that may be spent on the reference at every load; and
# about how many convolutions that takes at each.
_AFFORDABLE, _CONVOLUTIONS = 3e8, 2400
# Errors scatter from load to load, since each one touches other summits. What holds for all loads
# is taken as the larger of these: so much more than the largest that was found, and the mean with
# so many standard deviations.
_MARGIN, _DEVIATIONS = 1.3, 2.5
_ONE_GRID = replace(PRESETS["fine"], history_coarsening=1)


class _Yardstick(NamedTuple):
    """What to measure by: the accuracies for which it will do, and by how much it may err."""

    finest_accuracy: float
    error: float
    name: str
    fidelity: Fidelity


# The reference, or what is nearly as good for a third of its work; its error is the largest one
# seen on the scenes of the tests. Neither a looser contact nor a history on a coarser grid would
# do: how far these err depends on how many nodes and summits touch, and two coarse grids may agree
# on what is wrong.
_YARDSTICKS = (
    _Yardstick(0.01, 0.005, "one grid throughout", _ONE_GRID),
    _Yardstick(0.0, 0.0, "the reference", PRESETS["reference"]),
)


def at_accuracy(
    sweep: Sweep,
    accuracy: float,
    points: Sequence[Point] | None = None,
    store: PathLike | None = None,
    progress: Callable[[str], None] | None = None,
) -> Sweep:
    """Give a sweep the cheapest fidelity within an accuracy, and the reasons for it.

    Parameters
    ----------
    sweep, accuracy, points, progress
        See `choose_fidelity`.
    store : str or path, optional
        That the sweep goes on with. If its fidelity was picked for its accuracy, that one is
        taken again, without another probe.

    Raises
    ------
    StoreMismatchError
        If the fidelity of the store was picked for a lower accuracy, and does not keep this one.
    InputError
        See `choose_fidelity`.
    """
    selection = None if store is None else stored_selection(store)
    if selection is None:
        selection = choose_fidelity(sweep, accuracy, points, progress)
    elif selection.error > accuracy:
        raise StoreMismatchError(
            f"{store} was computed with {selection.name}, whose boundary errs by "
            f"{100 * selection.error:.2g} %; write to another store for {100 * accuracy:g} %"
        )
    fidelity = _of(sweep, selection.fidelity)
    named = fidelity == PRESETS.get(selection.name)
    return replace(
        sweep,
        fidelity=fidelity,
        preset=selection.name if named else None,
        selection=selection,
    )


def stored_selection(path: PathLike) -> Selection | None:
    """Why a store has the fidelity that it has; None if it was not picked, or is not there.

    Raises
    ------
    StoreError
        If there is something else in its place.
    """
    folder = folder_of(path)
    if not (folder / ROOT).exists():
        return None
    attributes, _ = read_metadata(folder)
    known = attributes.get("selection")
    return None if known is None else Selection.from_dict(known)


def choose_fidelity(
    sweep: Sweep,
    accuracy: float,
    points: Sequence[Point] | None = None,
    progress: Callable[[str], None] | None = None,
) -> Selection:
    """Find the cheapest numerical choice whose measured error is within a bound.

    Ever dearer ones are tried at a few points on the boundary and compared with a yardstick, until
    one is good enough. No time enters the choice, so that it is the same on every machine.

    Parameters
    ----------
    sweep : Sweep
        Of its fidelity only `pipeline.sweep.selection.KEPT_FIELDS` are kept.
    accuracy : float
        Largest relative error of the boundary velocity, such as 0.02.
    points : sequence of Point, optional
        Where to try; if not given, on the boundary at four loads, from the lowest to the highest,
        or at all of them where that takes but seconds.
    progress : callable, optional
        Called with the name of each fidelity before it is tried.

    Raises
    ------
    InputError
        If the accuracy is not between 0 and 1, or there is no friction heat.
    """
    if not 0 < accuracy < 1:
        raise InputError(f"accuracy is {accuracy!r}; it must be between 0 and 1, such as 0.02")
    if not math.isfinite(rise_limit(sweep.conditions)):
        raise InputError("without friction there is no heat, and no boundary to be accurate about")
    if points and not all(point.velocity for point in points):
        raise InputError("at velocity 0 there is no heat, and nothing to be accurate about")
    began = time.perf_counter()
    tell = progress or (lambda name: None)
    is_small = _is_small(sweep)
    loads = sorted({p.load for p in points}) if points else some_loads(sweep, _LOADS)
    if is_small and not points:
        loads = sweep.loads
    places, exponents = near_the_boundary(sweep, loads)
    if points:
        by_load = dict(zip(loads, exponents, strict=True))
        places, exponents = tuple(points), tuple(by_load[point.load] for point in points)

    finest = 0.0 if is_small else accuracy
    yardstick = next(entry for entry in _YARDSTICKS if finest >= entry.finest_accuracy)
    tell(yardstick.name)
    truth = probe(sweep, _of(sweep, yardstick.fidelity), places)
    trials, spent = [], truth.work
    for name, fidelity in _ladder(sweep):
        tell(name)
        try:
            found = truth if fidelity == truth.fidelity else probe(sweep, fidelity, places)
        except ConvergenceError:
            continue
        error = yardstick.error
        if found is not truth:
            error += _bound(found, truth, exponents, of_all_loads=is_small)
            spent += found.work
        trials.append(Trial(name, fidelity, error, found.work))
        if error <= accuracy:
            break
    picked = trials[-1]
    return Selection(
        accuracy=accuracy,
        name=picked.name,
        fidelity=picked.fidelity,
        error=picked.error,
        yardstick=yardstick.name,
        trials=tuple(trials),
        points=tuple((point.load, point.velocity) for point in places),
        saving=truth.work / picked.work,
        work=spent,
        seconds=time.perf_counter() - began,
    )


def _is_small(sweep: Sweep) -> bool:
    """Whether it takes but seconds to know the reference at every load."""
    reference = replace(sweep, fidelity=_of(sweep, PRESETS["reference"]))
    work = _CONVOLUTIONS * math.prod(reference.grid.shape) * len(sweep.loads)
    return work <= _AFFORDABLE


def _bound(found: Probe, truth: Probe, exponents: Sequence[float], of_all_loads: bool) -> float:
    """Largest error to expect at any load."""
    errors = _velocity_errors(found, truth, exponents)
    if of_all_loads:
        return max(map(abs, errors))
    largest = _MARGIN * max(map(abs, errors))
    if len(errors) < 3:
        return largest
    return max(largest, abs(statistics.mean(errors)) + _DEVIATIONS * statistics.stdev(errors))


def _velocity_errors(found: Probe, truth: Probe, exponents: Sequence[float]) -> list[float]:
    return [
        boundary_velocity_error(one.rise, true.rise, exponent)
        for one, true, exponent in zip(found.readings, truth.readings, exponents, strict=True)
    ]


def _ladder(sweep: Sweep) -> Iterator[tuple[str, Fidelity]]:
    """Fidelities from cheap to dear, each once."""
    seen = set()
    for name, preset, changes in (
        ("draft", "draft", {}),
        ("draft, finer elements", "draft", {"pixels_per_element": 3}),
        ("standard", "standard", {}),
        ("standard, one grid", "standard", {"history_coarsening": 1}),
        ("fine, coarser history", "fine", {"history_coarsening": 8, "contact_tolerance": 0.1}),
        ("fine, coarse history", "fine", {"history_coarsening": 4, "contact_tolerance": 0.1}),
        ("fine", "fine", {}),
        ("fine, one grid", "fine", {"history_coarsening": 1, "contact_tolerance": 0.03}),
        ("fine, one grid, solved more tightly", "fine", {"history_coarsening": 1}),
        ("reference", "reference", {}),
    ):
        fidelity = _of(sweep, replace(PRESETS[preset], **changes))
        if fidelity not in seen:
            seen.add(fidelity)
            yield name, fidelity


def _of(sweep: Sweep, fidelity: Fidelity) -> Fidelity:
    """A fidelity with what the scene keeps of its own."""
    own = sweep.fidelity
    kept = replace(fidelity, temperature_interval=own.temperature_interval)
    if own.heat_model == "history":  # which needs every step on one grid
        kept = replace(kept, history_coarsening=1, heat_model="history")
    return fitted(sweep, kept)
