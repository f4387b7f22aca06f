"""The value of an input that makes severe wear unlikely enough: an inverse question on samples."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from scipy.optimize import brentq

from pipeline.analysis.field import LEAST_SLOPE
from pipeline.analysis.model_error import ModelError, Scatter
from pipeline.scene.along import Place
from pipeline.sweep.unknown import OF_90, Unknown
from pipeline.uncertain.answers import draws_of, probability_of, run_probability
from pipeline.uncertain.direct import SceneWith, log_rise, scene_values
from pipeline.uncertain.ensemble import Ensemble, Excess
from pipeline.uncertain.inputs import Draws, prior
from tribo import InputError
from tribo.types import Array, Mask

RISK = 0.01
"""Probability of severe wear that a design may have, if none is given."""
RISK_OF_MARGIN = 0.05
"""Probability that the distance to the critical temperature is less than the margin."""
_VALUES = 17  # of the input, among which a limit is sought
_DRAWS, _FRESH = 2**13, 2**11  # of the inputs; of those that are drawn anew for a direct check
_LEAST = 1e-9  # probability
_NEAR = 4.0  # errors of the emulator from the limit, within which draws are simulated
_FEWEST, _MOST = 64, 400  # that are simulated, also where it is sure
_AGREES = 2.0  # standard errors of the direct check


@dataclass(frozen=True, slots=True)
class Goal:
    """What a design is to reach.

    Examples
    --------
    >>> Goal([(300.0, 1.74)], risk=0.01).margin
    0.0
    """

    #: Loads [N] and velocities [m/s] of operating points, at each of which it is to be reached.
    places: Sequence[tuple[float, float]]
    #: Highest probability that the next run is severe, or closer to it than the margin.
    risk: float
    margin: float = 0.0  #: Distance below the critical temperature [K].


@dataclass(frozen=True, slots=True, eq=False)
class Limit:
    """Values of an input with which a goal is reached."""

    entry: Unknown  #: The input.
    goal: Goal  #: What is to be reached.
    #: Values that reach it: ``"at most"`` or ``"at least"`` the limit, ``"between"`` two of them,
    #: ``"any"`` or ``"none"``.
    side: str
    value: float | None  #: The limit [SI]; the upper one of two.
    #: Ends between which it lies with 90 % probability, as far as samples and draws tell [SI].
    interval: tuple[float, float] | None
    safe: tuple[float, float] | None  #: Lowest and highest value that reach the goal [SI].
    best: tuple[float, float]  #: Value of the lowest probability, and that probability.
    binding: Place  #: Operating point that decides.
    values: tuple[float, ...]  #: Values of the input [SI].
    probabilities: tuple[float, ...]  #: Highest probability over the operating points at each.

    def as_dict(self) -> dict[str, Any]:
        """Return all results as plain data, in SI."""
        limit = None
        if self.value is not None:
            limit = {"value": self.value, "unit": self.entry.unit, "interval": self.interval}
        return {
            "entry": self.entry.path,
            "risk": self.goal.risk,
            "margin": self.goal.margin or None,
            "side": self.side,
            "limit": limit,
            "safe": self.safe,
            "best": dict(zip(("value", "probability"), self.best, strict=True)),
            "binding": self.binding._asdict(),
            "values": list(self.values),
            "probabilities": list(self.probabilities),
        }


def design(
    ensemble: Ensemble,
    goal: Goal,
    over: str,
    draws: Draws | None = None,
    at: Mapping[str, float] | None = None,
    shift: float = 0.0,
    scatter: Scatter | None = None,
    friction_scatter: Array | float = 0.0,
) -> Limit:
    """Values of an unknown input, uniform between two, with which a goal is reached.

    Parameters
    ----------
    ensemble : Ensemble
        Samples of a sweep.
    goal : Goal
        What is to be reached.
    over : str
        Path of the input.
    draws : Draws, optional
        Draws of the inputs that tests have weighed; see `pipeline.risk`.
    at : mapping of str to float, optional
        Values of other inputs by their paths [SI].
    shift : float
        Logarithm of the ratio of rises near the limit to those that the samples tell, as direct
        simulations find it.
    scatter : Scatter, optional
        The model's own error, by which ln(velocity) of the next run is off; a `ModelError` of 10 %
        if not given.
    friction_scatter : float or ndarray, shape (n,)
        Standard deviation of ln(friction) between runs, of each draw.

    Raises
    ------
    InputError
        If the input is not one of the samples, or not uniform, or a point lies outside the sweep.

    Examples
    --------
    >>> import pipeline
    >>> ensemble = pipeline.Ensemble.of(pipeline.open_sweep("results/unknown.zarr"))
    >>> from dataclasses import replace
    >>> critical = Unknown("temperature.critical", "uniform", (398.15, 438.15), "K")
    >>> ensemble = replace(ensemble, unknown=(ensemble.unknown[0], critical))
    >>> goal = pipeline.Goal([(400.0, 2.2)], risk=0.05)
    >>> limit = pipeline.design(ensemble, goal, "temperature.critical")
    >>> limit.side, 418 < limit.value < 438
    ('at least', True)
    """
    entry, scatter = designed(ensemble, over), scatter or ModelError()
    places = [Place(*place) for place in goal.places]
    draws = draws_of(ensemble, draws or prior(ensemble.unknown, ensemble.design.seed + 1, _DRAWS))
    low, high = entry.parameters

    def worst(value: float) -> tuple[float, float, int]:
        """Highest probability over the places, its error, and the number of the place."""
        inputs = fix_values(ensemble, draws.inputs, {**(at or {}), over: value})
        told = goal.margin, shift, friction_scatter
        lines = [_excess(ensemble, inputs, place, *told) for place in places]
        found = [probability_of(excess, draws, scatter, slope) for excess, slope in lines]
        number = int(np.argmax([probability for probability, _ in found]))
        return *found[number], number

    def off(value: float) -> float:
        return math.log(max(worst(value)[0], _LEAST) / goal.risk)

    values = np.linspace(low, high, _VALUES)
    found = [worst(value) for value in values.tolist()]
    chances = np.array([one[0] for one in found])
    best = int(np.argmin(chances))
    if chances[best] > goal.risk or (chances <= goal.risk).all():
        side, ends = ("none", None) if chances[best] > goal.risk else ("any", (low, high))
        binding = places[found[best if ends is None else int(np.argmax(chances))][2]]
        value = interval = None
    else:
        first, last = _run(chances <= goal.risk, best)
        below = low if first == 0 else brentq(off, values[first - 1], values[first], rtol=1e-4)
        above = high if last == _VALUES - 1 else brentq(off, values[last], values[last + 1])
        ends = float(below), float(above)
        side = "at least" if last == _VALUES - 1 else "at most" if first == 0 else "between"
        value = ends[0] if side == "at least" else ends[1]
        chance, error, number = worst(value)
        binding = places[number]
        step = (high - low) / (8 * _VALUES)
        slope = (off(min(value + step, high)) - off(max(value - step, low))) / (2 * step)
        apart = OF_90 * error / max(chance, _LEAST) / max(abs(slope), 1e-300)
        interval = max(value - apart, low), min(value + apart, high)
    return Limit(
        entry, goal, side, value, interval, ends, (float(values[best]), float(chances[best])),
        binding, tuple(values.tolist()), tuple(chances.tolist()),
    )  # fmt: skip


def designed(ensemble: Ensemble, path: str) -> Unknown:
    """The input of a design; raises if it is not uniform between two values."""
    by_path = {one.path: one for one in ensemble.unknown}
    for fixed in ensemble.fixed:
        if fixed.unknown.path == path:
            raise InputError(f"{fixed}; leave that out to seek its value")
    entry = by_path.get(path)
    if entry is None or entry.kind != "uniform":
        said = str(entry).replace(":", " is", 1)
        if entry is None:
            said = f"{path} is not an unknown input of these samples"
        ranges = ", ".join(one.path for one in by_path.values() if one.kind == "uniform")
        raise InputError(
            f"{said}; a design needs a range, which {ranges or 'none'} has: give one of these, or "
            "run the scene with it as { from, to } in [unknown]"
        )
    return entry


def fix_values(ensemble: Ensemble, inputs: Array, values: Mapping[str, float]) -> Array:
    """Inputs with some of them at one value."""
    numbers = {one.path: number for number, one in enumerate(ensemble.unknown)}
    other = inputs.copy()
    for path, value in values.items():
        other[:, numbers[path]] = value
    return other


_APART = 0.05  # of ln(velocity), over which the slope of ln(rise) is taken


def _excess(
    ensemble: Ensemble,
    inputs: Array,
    place: Place,
    margin: float,
    shift: float,
    friction_scatter: Array | float,
) -> tuple[Excess, Array]:
    """Logarithm of the rise, with a shift, over the one that leaves a margin; and its slope.

    The slope is that over ln(velocity), by draw. Friction between runs adds to the error.
    """
    (low, high), velocity = ensemble.velocities, place.velocity
    ends = max(velocity * math.exp(-_APART), low), min(velocity * math.exp(_APART), high)
    excess = ensemble.excess(inputs, place.load, [ends[0], velocity, ends[1]])
    rises, apart = excess.values[:, 2] - excess.values[:, 0], math.log(ends[1] / ends[0])
    slope = np.maximum(rises / apart, LEAST_SLOPE) if apart > 0 else np.ones(len(inputs))
    limits = ensemble.log_limit(inputs), ensemble.log_limit(inputs, margin=margin)
    here = Excess(*(part[:, 1] for part in excess))
    values = here.values + shift + limits[0] - limits[1]
    return here._replace(values=values, error=np.hypot(here.error, friction_scatter)), slope


def _run(fits: Mask, place: int) -> tuple[int, int]:
    """First and last number of the run of true values that a place is in."""
    (wrong,) = np.nonzero(~fits)
    before, after = wrong[wrong < place], wrong[wrong > place]
    return (
        int(before[-1]) + 1 if before.size else 0,
        int(after[0]) - 1 if after.size else len(fits) - 1,
    )


@dataclass(frozen=True, slots=True)
class Direct:
    """Probability of new draws, of which the 64 to 400 nearest to the limit were simulated."""

    probability: float
    error: float
    draws: int
    simulated: int
    shift: float  # mean logarithm of the simulated rises over those that the samples tell

    def agrees_with(self, risk: float) -> bool:
        """True if it is no higher than a probability, within its error."""
        return self.probability <= risk + _AGREES * self.error


def directly(
    ensemble: Ensemble,
    goal: Goal,
    place: Place,
    values: Mapping[str, float],
    scene_with: SceneWith,
    draws: Draws | None = None,
    progress: Callable[[int, int], None] | None = None,
    *,
    shift: float = 0.0,
    seed: int = 0,
    scatter: Scatter | None = None,
    friction_scatter: Array | float = 0.0,
) -> Direct:
    """Find the probability at ``values`` [SI] by simulations where the emulator is not sure."""
    scatter, between = scatter or ModelError(), friction_scatter
    if draws is None:
        inputs = prior(ensemble.unknown, ensemble.design.seed + 2718 + seed, _FRESH).inputs
    else:
        rng = np.random.default_rng([ensemble.design.seed, 2718, seed])
        weighed = draws_of(ensemble, draws)
        chosen = rng.choice(len(weighed.weights), _FRESH, p=weighed.weights)
        inputs = weighed.inputs[chosen]
        between = between[chosen] if isinstance(between, np.ndarray) else between
    inputs = fix_values(ensemble, inputs, values)
    excess, slope = _excess(ensemble, inputs, place, goal.margin, shift, 0.0)
    scores = np.abs(excess.values / excess.error)
    near = np.argsort(scores)[: np.clip(np.sum(scores < _NEAR), _FEWEST, _MOST)]
    limits = ensemble.log_limit(inputs, margin=goal.margin)
    found = excess.values.copy()
    for number, row in enumerate(near.tolist()):
        if progress:
            progress(number, len(near))
        sweep = scene_with(scene_values(ensemble, inputs[row]))
        found[row] = log_rise(sweep, *place) - limits[row]
    chances = np.full(len(found), between) + _LEAST
    by_draw, _ = run_probability(Excess(found, chances, chances), scatter, slope)
    chance = float(np.mean(by_draw))
    error = math.sqrt(max(float(np.var(by_draw)), 1 / _FRESH) / _FRESH)
    missed = float(np.mean((found - excess.values)[near]))
    return Direct(chance, error, _FRESH, len(near), shift + missed)
