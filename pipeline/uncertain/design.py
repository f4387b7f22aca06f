"""The value of an entry that makes severe wear unlikely enough: an inverse question on samples.

The entry is an unknown input with a range; or the load or the velocity, within the samples'; or a
condition that acts after the simulation, which needs no range.
"""

from __future__ import annotations

import functools
import itertools
import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any, ClassVar

import numpy as np
from scipy.optimize import brentq

from pipeline.analysis.at import COLDEST_OIL, HOTTEST_OIL
from pipeline.analysis.margin import NOT_DECIDED
from pipeline.analysis.model_error import ModelError, Scatter
from pipeline.analysis.rise_error import error_of_point
from pipeline.analysis.transition import LEAST_SLOPE
from pipeline.quantities import si_of
from pipeline.scene.along import Place
from pipeline.sweep.shown import shown
from pipeline.sweep.stages import Progress, Report, silent
from pipeline.sweep.unknown import OF_90, Fixed, Unit, Unknown
from pipeline.uncertain.answers import draws_of, probability_of, run_probability
from pipeline.uncertain.direct import SceneWith, log_rise, scene_values
from pipeline.uncertain.ensemble import Ensemble, Excess
from pipeline.uncertain.inputs import BULK, CRITICAL, FRICTION, SHARE, Draws, prior
from tribo import InputError
from tribo.types import Array

RISK = 0.01
"""Probability of severe wear that a design may have, if none is given."""
RISK_OF_MARGIN = 0.05
"""Probability that the distance to the critical temperature is less than the margin."""
LOAD, VELOCITY = Place._fields
_CELSIUS = Unit("°C", 1.0, si_of(0.0, "°C"))
CONDITIONS = {CRITICAL: ("K", _CELSIUS), BULK: ("K", _CELSIUS), FRICTION: ("1", None)}
"""Entries that act after the simulation, and need no range; their unit, and that to show."""
SIMULATED = 90
"""Draws near the limit that are simulated directly."""
_VALUES = 17  # values of the entry among which a limit is sought
_DRAWS = 2**13  # draws of the inputs
_LEAST = 1e-9  # probability
_BEYOND = 0.7  # ln(rise) beyond all draws that the range of a condition reaches
_APART = 0.05  # step of ln(velocity) over which the slope of ln(rise) is taken
_ANYWHERE = 0.1  # share of the simulated draws that lie anywhere, also where the emulator is sure
_TO_EITHER_SIDE = 2.0  # errors of the emulator, over which a probability changes
_LEAST_EITHER = 0.04  # least error of ln(rise), where the emulator takes itself to be surer
_MOST_KEPT = 128  # rises of all draws, of 0.5 MB each
_Rise = tuple[Excess, Array]  # or an excess; with its slope over ln(velocity)


@dataclass(frozen=True, slots=True)
class Goal:
    """The goal of a design: operating points, and the highest probability of severe wear there.

    Examples
    --------
    >>> Goal([(300.0, 1.74)], risk=0.01).margin
    0.0
    """

    #: Loads [N] and velocities [m/s] of operating points, at each of which it is to be reached. A
    #: load or velocity that is sought takes the place of theirs.
    places: Sequence[tuple[float, float]]
    #: Highest probability that the next run is severe, or closer to it than the margin.
    risk: float
    margin: float = 0.0  #: Distance below the critical temperature [K].


@shown
@dataclass(frozen=True, slots=True, eq=False)
class Limit:
    """Values of an entry with which a goal is reached, at the worst numerical error."""

    drawn_by: ClassVar = "pipeline.uncertain.figures:draw_design"
    entry: Unknown  #: The entry, with its range.
    goal: Goal  #: What is to be reached.
    #: Values that reach it: ``"at most"`` or ``"at least"`` the limit, ``"between"`` two of them,
    #: ``"any"`` or ``"none"``; not decided where the tests contradict the model.
    side: str
    value: float | None  #: The limit [SI]; the upper one of two.
    #: Ends between which it lies with 90 % probability, as far as samples and draws tell [SI].
    interval: tuple[float, float] | None
    safe: tuple[float, float] | None  #: Lowest and highest value that reach the goal [SI].
    best: tuple[float, float]  #: Value of the lowest probability, and that probability.
    binding: Place  #: Operating point that decides.
    values: tuple[float, ...]  #: Values of the entry [SI].
    probabilities: tuple[float, ...]  #: Highest probability over the operating points at each.
    at: tuple[Fixed, ...] = ()  #: Values of other entries.

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
    scatter: Scatter | None = None,
    friction_scatter: Array | float = 0.0,
) -> Limit:
    """Values of an entry with which a goal is reached.

    Parameters
    ----------
    ensemble : Ensemble
        Samples of a sweep.
    goal : Goal
        What is to be reached.
    over : str
        Path of an unknown input, uniform between two values; or of a condition, such as
        ``temperature.critical``; or ``load`` or ``velocity``.
    draws : Draws, optional
        Draws of the inputs that tests have weighed; those of a `Posterior`.
    at : mapping of str to float, optional
        Values of other such entries by their paths [SI].
    scatter : Scatter, optional
        The model's own error, by which ln(velocity) of the next run is off; a `ModelError` of 10 %
        if not given.
    friction_scatter : float or ndarray, shape (n,)
        Standard deviation of ln(friction) between runs, of each draw.

    Raises
    ------
    InputError
        If the entry is none of these, or a point lies outside the sweep.

    Examples
    --------
    >>> import pipeline
    >>> ensemble = pipeline.Ensemble.of(pipeline.open_sweep("results/unknown.zarr"))
    >>> goal = pipeline.Goal([(400.0, 2.2)], risk=0.05)
    >>> limit = pipeline.design(ensemble, goal, "temperature.critical")
    >>> limit.side, 418 < limit.value < 448
    ('at least', True)
    """
    return Chances(ensemble, goal, draws, scatter, friction_scatter).limit(over, at)


@dataclass(eq=False)
class Chances:
    """Probabilities of a severe next run over values of entries, at the worst numerical error."""

    ensemble: Ensemble
    goal: Goal
    draws: Draws | None = None
    scatter: Scatter | None = None
    friction_scatter: Array | float = 0.0
    #: Logarithm of the ratio of rises near the limit to those that the samples tell, as direct
    #: simulations find it.
    shift: float = 0.0
    #: Probability that the limit stays below the risk, so that a check can confirm it.
    spare: float = 0.0

    def __post_init__(self) -> None:
        ensemble, self.scatter = self.ensemble, self.scatter or ModelError()
        drawn = self.draws or prior(ensemble.unknown, ensemble.design.seed + 1, _DRAWS)
        self._weighed = draws_of(ensemble, drawn)
        emulate = functools.partial(_emulate, ensemble, self._weighed.inputs)
        self._kept = functools.lru_cache(_MOST_KEPT)(emulate)

    @property
    def numerical(self) -> float:
        """What the error of the fidelity adds to ln(rise) at most, as far as it is known."""
        return math.log1p(error_of_point(0, 1.0, self.ensemble.velocity_error).preset or 0.0)

    def entry(self, path: str) -> Unknown:
        """An entry that may be sought, as an input that is uniform over its range.

        That of a condition reaches from where wear is surely severe to where it surely is not.
        """
        ensemble = self.ensemble
        known = {one.path: one for one in (*ensemble.unknown, *(f.unknown for f in ensemble.fixed))}
        if path == LOAD:
            return Unknown(path, "uniform", tuple(ensemble.loads[[0, -1]].tolist()), "N")
        if path == VELOCITY:
            return Unknown(path, "uniform", ensemble.velocities, "m/s")
        if path not in CONDITIONS:
            return _ranged_input(ensemble, path)
        unit, written = CONDITIONS[path]
        written = known[path].written if path in known else written
        return Unknown(path, "uniform", self._reach(path), unit, written)

    def _reach(self, path: str) -> tuple[float, float]:
        """Ends of the range of a condition."""
        inputs, ends = self._weighed.inputs, []
        loads, velocities = self.ensemble.loads[[0, -1]].tolist(), self.ensemble.velocities
        for place in {Place(*place) for place in self.goal.places}:
            here = itertools.product(
                loads if math.isnan(place.load) else [place.load],
                velocities if math.isnan(place.velocity) else [place.velocity],
            )
            for corner in here:
                rise, _ = self._rise(Place(*corner), {})
                ends += [rise.values.min() - _BEYOND, rise.values.max() + _BEYOND]
        rises = np.exp([[min(ends)], [max(ends)]])
        known = {one: self.ensemble.values(one, inputs) for one in CONDITIONS if one != path}
        margin = self.goal.margin
        if path == FRICTION:
            values = (known[CRITICAL] - margin - known[BULK]) / rises
            values = values[values > 0] if (values > 0).any() else np.array([0.01, 1.0])
            return float(values.min()), float(values.max())
        heat = known[FRICTION] * rises
        values = (
            known[BULK] + margin + heat if path == CRITICAL else known[CRITICAL] - margin - heat
        )
        highest = HOTTEST_OIL if path == BULK else math.inf
        low, high = np.clip([values.min(), values.max()], COLDEST_OIL, highest).tolist()
        return low, high

    def limit(self, over: str, at: Mapping[str, float] | None = None) -> Limit:
        """Values of an entry that reach the goal, with other entries at some values."""
        at = at or {}
        entry, places = self.entry(over), [Place(*place) for place in self.goal.places]
        low, high = entry.parameters
        risk = self.goal.risk

        def highest_probability(value: float) -> tuple[float, float, int]:
            """Highest probability over the places, its error, and the number of the place."""
            found = [self.probability(place, {**at, over: value}) for place in places]
            number = int(np.argmax([probability for probability, _ in found]))
            return *found[number], number

        values = np.linspace(low, high, _VALUES)
        found = [highest_probability(value) for value in values.tolist()]
        chances = np.array([one[0] for one in found])
        best = int(np.argmin(chances))
        if chances[best] <= risk:  # a check of the best value may still confirm it
            risk = max(risk - self.spare, float(chances[best]))

        def off(value: float) -> float:
            return math.log(max(highest_probability(value)[0], _LEAST) / max(risk, _LEAST))

        if chances[best] > risk or (chances <= risk).all():
            side, ends = ("none", None) if chances[best] > risk else ("any", (low, high))
            decisive = best if ends is None else int(np.argmax(chances))
            number, at_place = found[decisive][2], values[decisive]
            value = interval = None
        else:
            fits = chances <= risk
            runs = np.cumsum(~fits)  # a number for each run of values that fit
            inside = np.flatnonzero(fits & (runs == runs[best]))
            first, last = inside[0], inside[-1]
            below = low if first == 0 else brentq(off, values[first - 1], values[first], rtol=1e-4)
            above = high
            if last < _VALUES - 1:
                above = brentq(off, values[last], values[last + 1], rtol=1e-4)
            ends = float(below), float(above)
            side = "at least" if last == _VALUES - 1 else "at most" if first == 0 else "between"
            value = at_place = ends[0] if side == "at least" else ends[1]
            chance, error, number = highest_probability(value)
            step = (high - low) / (8 * _VALUES)
            slope = (off(min(value + step, high)) - off(max(value - step, low))) / (2 * step)
            apart = OF_90 * error / max(chance, _LEAST) / max(abs(slope), 1e-300)
            interval = max(value - apart, low), min(value + apart, high)
        if self._weighed.misfit:
            side, value, interval, ends = NOT_DECIDED, None, None, None
        return Limit(
            entry, self.goal, side, value, interval, ends, (float(values[best]), chances.min()),
            _moved(places[number], {**at, over: float(at_place)}),
            tuple(values.tolist()), tuple(chances.tolist()),
            tuple(Fixed(self.entry(path), one) for path, one in at.items()),
        )  # fmt: skip

    def probability(self, place: Place, values: Mapping[str, float]) -> tuple[float, float]:
        """Probability at a place and values of entries [SI], and its standard error."""
        inputs = self._weighed.inputs
        excess, slope = self._excess(inputs, self._rise(place, values), values)
        excess = excess._replace(error=np.hypot(excess.error, self.friction_scatter))
        return probability_of(excess, self._weighed, self.scatter, slope)

    def _excess(self, inputs: Array, rise: _Rise, values: Mapping[str, float]) -> _Rise:
        """Logarithm of the rise, hotter by the shift and the numerical error, over its limit."""
        emulated, slope = rise
        hotter = emulated.values + self.shift + self.numerical
        return emulated._replace(values=hotter - self._log_rise_limit(inputs, values)), slope

    def _log_rise_limit(self, inputs: Array, values: Mapping[str, float]) -> Array:
        """Logarithm of the rise at friction 1 that leaves the margin, of each draw."""
        friction, bulk, critical = (values.get(path) for path in (FRICTION, BULK, CRITICAL))
        return self.ensemble.log_limit(inputs, friction, bulk, self.goal.margin, critical)

    def _rise(self, place: Place, values: Mapping[str, float]) -> _Rise:
        """Rise of the draws; the last ones are kept, as no condition changes them."""
        return self._kept(place, *(one for one in values.items() if one[0] not in CONDITIONS))

    def simulated(
        self, limit: Limit, scene_with: SceneWith, seed: int = 0, progress: Report = silent
    ) -> Direct:
        """Find the probability at a limit by simulations of draws near it.

        With P(x) of a draw at its excess x the probability is E[P(x)] of emulated excesses, of many
        draws, and E[P(x) − P(x emulated)] of the few that are simulated: a control variate. These
        are drawn by how much the emulator's error changes P (importance sampling), some anywhere.
        """
        assert limit.value is not None  # for the type checker
        ensemble, between = self.ensemble, self.friction_scatter
        values = {one.unknown.path: one.value for one in limit.at} | {limit.entry.path: limit.value}
        if self.draws is None:
            draws = prior(ensemble.unknown, ensemble.design.seed + 2718 + seed, _DRAWS)
        else:
            draws = self._weighed
        place, inputs = limit.binding, draws.inputs
        rise = _emulate(ensemble, inputs, place, *values.items())
        excess, slope = self._excess(inputs, rise, values)
        scatter = self.scatter

        def chances(x: Array, error: Array | float, rows: Any = slice(None)) -> Array:
            beside = between[rows] if isinstance(between, np.ndarray) else between
            errors = np.hypot(error, beside) + _LEAST * np.ones(len(x))
            return run_probability(Excess(x, errors, errors), scatter, slope[rows])[0]

        emulated = chances(excess.values, excess.error)
        either = np.hypot(_TO_EITHER_SIDE * excess.error, _LEAST_EITHER)
        told = chances(excess.values + either, 0.0) - chances(excess.values - either, 0.0) + _LEAST
        mass = float(draws.weights @ told)
        drawn = draws.weights * told / mass
        drawn = (1 - _ANYWHERE) * drawn + _ANYWHERE * draws.weights
        rng = np.random.default_rng([ensemble.design.seed, 2718, seed])
        rows = rng.choice(len(drawn), SIMULATED, p=drawn / drawn.sum())
        worth = draws.weights[rows] / drawn[rows]
        limits, found = self._log_rise_limit(inputs, values), np.empty(SIMULATED)
        fixed, known = fix_values(ensemble, inputs, values), dict[int, float]()
        shares = ensemble.values(SHARE, fixed).tolist()
        for number, row in enumerate(rows.tolist()):
            progress(Progress(done=number, total=SIMULATED))
            if row not in known:
                judged = replace(ensemble.conditions, failing_share=shares[row])
                scene = scene_with(scene_values(ensemble, fixed[row]))
                known[row] = log_rise(scene, *place, judged)
            found[number] = known[row]
        found += self.numerical - limits[rows]
        missed = found - (excess.values[rows] - self.shift)
        off = worth * (chances(found, 0.0, rows) - emulated[rows])
        middle = float(draws.mean(emulated))
        by_draws = float(np.sum((draws.weights * (emulated - middle)) ** 2))
        by_runs = float(np.var(off, ddof=1)) / SIMULATED + (mass / SIMULATED) ** 2  # one unseen
        error = math.sqrt(by_draws + by_runs)
        probability = max(middle + float(np.mean(off)), 0.0)
        shift = float(np.average(missed, weights=worth * told[rows]))
        return Direct(probability, error, len(emulated), len(known), shift)


def _emulate(ensemble: Ensemble, inputs: Array, place: Place, *entries: tuple[str, float]) -> _Rise:
    """Logarithm of the rise at friction 1, and its slope over ln(velocity), of each draw."""
    values = dict(entries)
    load, velocity = _moved(place, values)
    low, high = ensemble.velocities
    ends = max(velocity * math.exp(-_APART), low), min(velocity * math.exp(_APART), high)
    three = [ends[0], velocity, ends[1]]
    rise = ensemble.rise(fix_values(ensemble, inputs, values), load, three)
    grows, apart = rise.values[:, 2] - rise.values[:, 0], math.log(ends[1] / ends[0])
    slope = np.maximum(grows / apart, LEAST_SLOPE) if apart > 0 else np.ones(len(inputs))
    return Excess(*(part[:, 1] for part in rise)), slope


def _ranged_input(ensemble: Ensemble, path: str) -> Unknown:
    """An unknown input; raises if it is not uniform between two values."""
    by_path = {one.path: one for one in ensemble.unknown}
    for fixed in ensemble.fixed:
        if fixed.unknown.path == path:
            raise InputError(f"{fixed}; leave that out to seek its value")
    entry = by_path.get(path)
    if entry is None or entry.kind != "uniform":
        said = str(entry).replace(":", " is", 1)
        if entry is None:
            said = f"{path} is not an unknown input of these samples"
        ranges = [one.path for one in by_path.values() if one.kind == "uniform"]
        free = dict.fromkeys([*ranges, LOAD, VELOCITY, *CONDITIONS])
        raise InputError(
            f"{said}; a design needs a range: give one of {', '.join(free)}, or run the scene with "
            "it as { from, to } in [unknown]"
        )
    return entry


def fix_values(ensemble: Ensemble, inputs: Array, values: Mapping[str, float]) -> Array:
    """Inputs with some of them at one value."""
    other = inputs.copy()
    for number, one in enumerate(ensemble.unknown):
        if one.path in values:
            other[:, number] = values[one.path]
    return other


def _moved(place: Place, values: Mapping[str, float]) -> Place:
    """A place with a load or a velocity that is sought."""
    return place._replace(**{name: values[name] for name in Place._fields if name in values})


@dataclass(frozen=True, slots=True)
class Direct:
    """Probability at the worst numerical error, by many draws, of which some were simulated."""

    probability: float
    error: float  # standard error
    draws: int
    simulated: int
    shift: float  # mean logarithm of the simulated rises over those that the samples tell

    @property
    def highest(self) -> float:
        """Value that the probability stays below with 95 %."""
        return self.probability + OF_90 * self.error

    @property
    def spare(self) -> float:
        """Probability below the risk at which nine of ten further checks confirm a limit."""
        return (OF_90 + _NINE_OF_TEN) * self.error

    def confirms(self, risk: float) -> bool:
        """True if the risk is kept with 95 %."""
        return self.highest <= risk


_NINE_OF_TEN = 1.282  # normal score
