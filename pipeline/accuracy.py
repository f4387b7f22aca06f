"""The cheapest fidelity that keeps a scene's boundary within an asked accuracy."""

from __future__ import annotations

import math
import statistics
import time
from collections.abc import Callable, Iterator, Sequence
from dataclasses import asdict, dataclass, replace
from typing import Any, NamedTuple

from pipeline.plan import Point
from pipeline.probe import (
    Probe,
    fitted,
    near_the_boundary,
    probe,
    rise_limit_of,
    some_loads,
)
from pipeline.sweep import Sweep
from tribo import PRESETS, ConvergenceError, Fidelity, InputError

__all__ = ["Selection", "Trial", "at_accuracy", "choose_fidelity"]

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


@dataclass(frozen=True, slots=True)
class Trial:
    """A fidelity that was tried, and by how much it moves the boundary velocity at most."""

    name: str
    fidelity: Fidelity
    error: float
    work: float


@dataclass(frozen=True, slots=True)
class Selection:
    """The fidelity that was picked, and why.

    Attributes
    ----------
    accuracy : float
        That was asked for, relative, of the boundary velocity.
    name : str
    fidelity : Fidelity
    error : float
        To expect at most, from those measured and what the yardstick itself may err; 0 for the
        reference.
    yardstick : str
        What the error was measured against.
    trials : tuple of Trial
        What was tried, from cheap to dear; the last one was picked.
    points : tuple of Point
        Where.
    saving : float
        How many times less work than the yardstick takes.
    seconds : float
        That the probe took.
    """

    accuracy: float
    name: str
    fidelity: Fidelity
    error: float
    yardstick: str
    trials: tuple[Trial, ...]
    points: tuple[Point, ...]
    saving: float
    seconds: float

    def as_dict(self) -> dict[str, Any]:
        """Return all of it as plain data."""
        points = [{"load": at.load, "velocity": at.velocity} for at in self.points]
        return asdict(self) | {"points": points}

    def __str__(self) -> str:
        dropped = [f"{trial.name} errs by {100 * trial.error:.2g} %" for trial in self.trials[:-1]]
        why = f" ({', '.join(dropped)})" if dropped else ""
        return (
            f"accuracy {100 * self.accuracy:g} %: picked {self.name}, whose boundary errs by "
            f"{100 * self.error:.2g} % against {self.yardstick} with {self.saving:.2g} times less "
            f"work{why}; the probe took {self.seconds:.1f} s"
        )


def at_accuracy(
    sweep: Sweep, accuracy: float, points: Sequence[Point] | None = None
) -> tuple[Sweep, Selection]:
    """Give a sweep the cheapest fidelity within an accuracy; see `choose_fidelity`."""
    selection = choose_fidelity(sweep, accuracy, points)
    named = selection.fidelity == PRESETS.get(selection.name)
    changed = replace(sweep, fidelity=selection.fidelity, preset=selection.name if named else None)
    return changed, selection


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
        Of its fidelity only ``temperature_interval`` and ``heat_model`` are kept.
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
    if not math.isfinite(rise_limit_of(sweep)):
        raise InputError("without friction there is no heat, and no boundary to be accurate about")
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
    trials = []
    for name, fidelity in _ladder(sweep):
        tell(name)
        try:
            found = truth if fidelity == truth.fidelity else probe(sweep, fidelity, places)
        except ConvergenceError:
            continue
        error = yardstick.error
        if found is not truth:
            error += _bound(found, truth, exponents, of_all_loads=is_small)
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
        points=tuple(places),
        saving=truth.work / picked.work,
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
        math.log(one.rise / true.rise) / exponent
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
