"""`SampleField`: temperatures and probabilities by load and velocity, from draws of the inputs."""

from __future__ import annotations

import functools
import math
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace

import numpy as np
import xarray as xr
from scipy.special import ndtr

from pipeline.analysis.curve import LEAST_SLOPE
from pipeline.analysis.field import Here, Places, places_of
from pipeline.analysis.model_error import Scatter
from pipeline.analysis.results import Results, results
from pipeline.analysis.rise_error import counted_error, preset_error
from pipeline.analysis.transition import CROSSES, MILD, SEVERAL, SEVERE, Transitions
from pipeline.cli.output import counted
from pipeline.sweep.conditions import Conditions
from pipeline.sweep.remarks import remarks
from pipeline.uncertain.answers import STEPS, draws_of, line_turns
from pipeline.uncertain.ensemble import Axis, Ensemble
from pipeline.uncertain.ensemble import keep_fits as keep_fits
from pipeline.uncertain.inputs import BULK, CRITICAL, FRICTION, LEAST_FRICTION, Draws
from pipeline.uncertain.posterior import Posterior
from pipeline.uncertain.samples import JUDGED
from pipeline.uncertain.weigh import posterior_at
from tribo import InputError
from tribo.types import Array

_FAR = 3.0  # ln(velocity) by which the excess is extrapolated beyond the samples' velocities


@dataclass(frozen=True, slots=True, eq=False)
class InferredScatter:
    """Distribution of how far laboratory runs deviate from the model, inferred from tests.

    The deviation is ln(critical velocity of the model / critical velocity of the run). Its standard
    deviation is not known: `scatters` are possible values. `by_draw` is the probability of each
    value for each draw of the unknown inputs, since the tests inform about both.
    """

    scatters: Array  # standard deviations of ln(velocity), (n_scatter,)
    by_draw: Array  # probability of each scatter by draw, (n, n_scatter)
    weights: Array  # weights of the draws, (n,)
    text: str

    def below(self, distances: Array) -> Array:
        """Probability that a run's deviation ε in ln(velocity) is below each of `distances`.

        A run at velocity V behaves like the model at V·exp(ε). The probability is the weighted mean
        over all draws, in the shape of `distances`.
        """
        odds = self.weights @ self.by_draw
        return np.asarray(
            sum(p * ndtr(distances / s) for p, s in zip(odds, self.scatters, strict=True))
        )


@dataclass(frozen=True, eq=False)
class SampleField:
    """Contact temperatures and the probability of severe wear, at any load and velocity.

    The samples of a sweep were fitted by an emulator (`ensemble`). The field evaluates it for
    weighted draws of the unknown inputs, and has a temperature for each draw. It has the interface
    `Field` of `pipeline.analysis.field`.
    """

    ensemble: Ensemble
    draws: Draws
    source: Results
    posterior: Posterior | None = None
    _cached: dict[float, tuple[Array, Array]] = field(default_factory=dict, init=False)
    counts_inputs = True
    at_once = 50

    @property
    def weights(self) -> Array:
        """Weight of each draw (n,); their sum is 1."""
        return self.draws.weights

    @property
    def conditions(self) -> Conditions:
        """Friction, temperatures and criterion by which wear is judged."""
        return self.ensemble.conditions

    @property
    def misfit(self) -> str:
        """Why the tests contradict the model; empty if they do not."""
        return self.draws.misfit

    @property
    def ends(self) -> Mapping[str, tuple[float, float]]:
        """Lowest and highest load [N] and velocity [m/s] of the samples."""
        loads = self.ensemble.loads
        return {"load": (float(loads[0]), float(loads[-1])), "velocity": self.ensemble.velocities}

    @property
    def scatter(self) -> Scatter | None:
        """Scatter of runs around the model, inferred from the tests; None without tests."""
        if self.posterior is None or self.draws.scatters is None or self.draws.by_scatter is None:
            return None
        low, middle, high = (100 * one for one in self.posterior.inferred_scatter)
        text = f"± {middle:.2g} % in velocity ({low:.2g} to {high:.2g} %), inferred from the tests"
        return InferredScatter(self.draws.scatters, self.draws.by_scatter, self.weights, text)

    @property
    def given_draws(self) -> Draws | None:
        """Draws of the posterior; None if the scene's own distributions are used."""
        return self.posterior.draws if self.posterior else None

    @property
    def rig_scatter(self) -> Array | float:
        """Standard deviation of ln(friction) between tests of the rig, for each draw (n,).

        It is 0 if it was not inferred from tests.
        """
        return self.posterior.rig_scatter if self.posterior else 0.0

    @property
    def basis(self) -> list[str]:
        """Lines of text on what answers are based on: inputs, tests, cross-validation."""
        return [*self._notes()]

    def _notes(self) -> Iterator[str]:
        ensemble, weighed = self.ensemble, self.posterior
        yield from remarks("warning", self.misfit)
        basis = "as the scene assumes them"
        if weighed:
            basis = f"given {weighed.evidence}, {weighed.scatter_words}"
        yield f"  {counted(len(ensemble.unknown), 'unknown input', 'unknown inputs')}, {basis}"
        yield from (f"  {one}" for one in ensemble.fixed)
        if weighed:
            yield weighed.draws_words
        if ensemble.missing:
            yield f"  {ensemble.missing} samples are left out: not done at every load"
        yield f"  {_describe_left_out(ensemble)}"

    def judged_by(self, own: Mapping[str, float]) -> SampleField:
        """Return the field with conditions of an operating point in place of the scene's.

        `own` has some of ``friction``, ``bulk_temperature`` [K] and ``critical_temperature`` [K].
        Raises an `InputError` if the draws have weights from tests.
        """
        if not own:
            return self
        if self.posterior:
            raise InputError(
                f"leave out {', '.join(own)}: tests weigh samples under the scene's own conditions"
            )
        ensemble = self.ensemble.judged_by(own)
        return replace(self, ensemble=ensemble, draws=draws_of(ensemble, None))

    def temperatures(self, loads: Places, velocities: Places) -> Here:
        """Contact temperatures [K] that the criterion compares with the critical temperature.

        They are (n, k), for n draws and k pairs of load [N] and velocity [m/s], and include a
        random emulator error. The result also has the critical temperatures, whether wear is
        severe, and for each pair without temperatures the reason.
        """
        places = [*zip(*places_of(loads, velocities), strict=True)]
        inputs, reasons = self.draws.inputs, [""] * len(places)
        friction, bulk, critical = (
            self.ensemble.values(path, inputs)[:, None] for path in (FRICTION, BULK, CRITICAL)
        )
        excess = np.full((len(inputs), len(places)), np.nan)
        for number, place in enumerate(places):
            try:
                here = self.ensemble.excess(inputs, *map(float, place))
                excess[:, number] = here.draw_error(self.ensemble.design.seed)
            except InputError as error:
                reasons[number] = str(error)
        law = replace(self.conditions.friction_law, coefficient=1.0)
        rise = friction * np.exp(excess + self.ensemble.log_limit(inputs)[:, None])
        temperatures = bulk + rise
        if law.by_temperature:
            temperatures = np.vectorize(law.temperature, otypes=[float])(rise, bulk)
        nowhere = np.zeros(len(places), bool)
        critical = np.broadcast_to(critical, excess.shape)
        return Here(temperatures, excess > 0, critical, nowhere, nowhere, reasons)

    def errors(self, loads: Places, velocities: Places) -> Array:
        """Relative numerical errors of temperature rises at k pairs of load and velocity, (4, k).

        The first axis has the causes: interpolation, preset, warnings, and corrections for oil film
        and temperature-dependent friction. An error is NaN if unknown. Those of interpolation and
        warnings are 0 here.
        """
        preset, counted = preset_error(self.ensemble.velocity_error), counted_error(self.conditions)
        parts = np.array([0.0, preset, 0.0, counted.item()])
        return np.tile(parts[:, None], len(places_of(loads, velocities)[0]))

    def transitions(self, axis: str, loads: Places, velocities: Places) -> Transitions:
        """Find on a line through each of k operating points whether, and where, wear turns severe.

        An operating point is a load [N] and a velocity [m/s]. For `axis` "velocity" the lines are
        at constant load, for "load" at constant velocity. The arrays of the result are (n, k), for
        n draws.
        """
        places = zip(*places_of(loads, velocities), strict=True)
        outcome, first = zip(*(self._outcomes_along(axis, *place) for place in places), strict=True)
        low, high = (np.full(len(first), end) for end in self.ends[axis])
        return Transitions(np.column_stack(outcome), np.column_stack(first), (low, high))

    def _outcomes_along(self, axis: str, load: float, velocity: float) -> tuple[Array, Array]:
        """Judge n draws on a line: code of the outcome, and where wear turns severe, each (n,).

        For `axis` "velocity" the line is at constant `load` [N], for "load" at constant `velocity`
        [m/s]. `outcomes` in `pipeline.analysis.transition` has the codes. The second array has the
        lowest velocity [m/s] or load [N] at which wear turns severe. Its values are −infinite if
        wear is severe from the beginning of the line, and infinite if wear never turns severe.
        """
        ends = self.ends[axis]
        if axis == "velocity":
            x, lines = self._lines(load)
        else:
            x = np.log(np.geomspace(*ends, STEPS))
            lines = self._random_excess(np.exp(x), velocity)
        turns, places = line_turns(x, lines)
        count = (turns != 0).sum(axis=1)
        is_severe = lines[:, 0] > 0
        outcome = np.where(count == 0, np.where(is_severe, SEVERE, MILD), CROSSES)
        outcome = np.where((count > 1) | ((count == 1) & is_severe), SEVERAL, outcome)
        first = np.exp(np.where(turns > 0, places, math.inf).min(axis=1))
        return outcome, np.where(is_severe, -math.inf, first)

    def probability(
        self, loads: Places, velocities: Places, scatter: Scatter, shift: Array | float = 0.0
    ) -> Array:
        """Probability (k,) that wear is severe in a further laboratory run at k operating points.

        It is computed from the velocities at which wear changes in each draw. `scatter` is the
        distribution of a run about the model, in ln(velocity). `shift`, one value or (k,), is added
        to ln(rise).
        """
        loads, velocities, shifts = np.broadcast_arrays(loads, velocities, shift)
        self._cache_lines([load for load in np.unique(loads).tolist() if load not in self._cached])
        result = np.empty(loads.shape)
        for load, by in {*zip(loads.ravel().tolist(), shifts.ravel().tolist(), strict=True)}:
            here = (loads == load) & (shifts == by)
            result[here] = self._probability(load, velocities[here], scatter, by)
        return result

    def _probability(self, load: float, velocities: Array, scatter: Scatter, shift: float) -> Array:
        """Probability (n_velocity,) that a further run at a load and `velocities` is severe.

        `scatter` is the distribution of a run about the model, and `shift` is added to ln(rise).
        """
        x, lines = self._lines(load, _FAR)
        turns, places = line_turns(x, lines + shift)
        rows, columns = np.nonzero(turns)
        begins = float(self.weights @ (lines[:, 0] + shift > 0))
        signs, at = turns[rows, columns], places[rows, columns]
        result = np.full(len(velocities), begins)
        for below, weights in self._mixture(scatter):
            weight = weights[rows] * signs
            # Turns of the many draws are collected on a grid of ln(velocity), for speed.
            grid = np.linspace(x[0], x[-1], _GRID)
            step = grid[1] - grid[0]
            k = np.clip(((at - grid[0]) / step).astype(int), 0, _GRID - 2)
            share = (at - grid[k]) / step
            binned = np.bincount(k, weight * (1 - share), _GRID)
            binned += np.bincount(k + 1, weight * share, _GRID)
            (some,) = np.nonzero(binned)
            if not some.size:  # wear changes in no draw that has this scatter
                continue
            apart = grid[some] - np.log(velocities)[:, None]
            far = max(-apart.min(), apart.max(), step)
            table = np.linspace(-far, far, _GRID)
            result += (1 - np.interp(apart, table, below(table))) @ binned[some]
        return np.asarray(np.clip(result, 0.0, 1.0))

    def _mixture(self, scatter: Scatter) -> Iterator[tuple[Callable[[Array], Array], Array]]:
        """Yield pairs (distribution function of a run's deviation, weights of the draws).

        The deviation is in ln(velocity). There is one pair for a given `scatter`, and a pair for
        each possible value of a scatter that was inferred with the inputs.
        """
        if not isinstance(scatter, InferredScatter):
            yield scatter.below, self.weights
            return
        for sd, odds in zip(scatter.scatters.tolist(), scatter.by_draw.T, strict=True):
            yield functools.partial(_normal_below, sd), self.weights * odds

    def _lines(self, load: float, beyond: float = 0.0) -> tuple[Array, Array]:
        """Values of ln(velocity) (m,), and ln(rise/limit) there at a load [N], by draw (n, m).

        ln(rise/limit) includes a random emulator error and the scatter of friction between tests.
        `beyond` extends the range of ln(velocity) by this much at each end. There the rise at
        constant friction is extrapolated as a power law of the velocity.
        """
        if load not in self._cached:
            self._cache_lines([load])
        x, lines = self._cached[load]
        if beyond:
            ends = slice(2), slice(-2, None)
            slopes = (np.diff(lines[:, end])[:, 0] / np.diff(x[end]) for end in ends)
            low, high = (np.maximum(slope, LEAST_SLOPE) * beyond for slope in slopes)
            lines = np.column_stack([lines[:, 0] - low, lines, lines[:, -1] + high])
            x = np.array([x[0] - beyond, *x, x[-1] + beyond])
        if not self.conditions.has_friction_curve:
            return x, lines
        nodes = np.union1d(x, _friction_nodes(self.conditions, x))
        above = np.clip(np.searchsorted(x, nodes), 1, len(x) - 1)
        share = (nodes - x[above - 1]) / (x[above] - x[above - 1])
        heat = lines[:, above - 1] * (1 - share) + lines[:, above] * share
        return nodes, heat + self._log_factor(nodes)

    def _log_factor(self, x: Array) -> Array:
        """Logarithm of the factor by which velocity changes friction, at ln(velocity) `x`."""
        factor = self.conditions.friction_factor(np.exp(x))
        return np.asarray(np.log(np.maximum(factor, LEAST_FRICTION)))

    def _cache_lines(self, loads: Sequence[float]) -> None:
        """Compute ln(rise/limit) along velocity at several loads [N] at once, and cache it.

        This is hardly slower than for one load. The cached values leave out how friction depends on
        velocity, because this may be far from linear between the cached velocities.
        """
        if not loads:
            return
        velocities = np.geomspace(*self.ensemble.velocities, STEPS)
        lines = self._random_excess(loads, velocities)
        if self.conditions.has_friction_curve:
            lines -= self._log_factor(np.log(velocities))
        if len(self._cached) + len(loads) > _MOST_CACHED:
            self._cached.clear()
        for number, load in enumerate(loads):
            self._cached[load] = np.log(velocities), lines[:, number]

    def _random_excess(self, loads: Axis, velocities: Axis | float) -> Array:
        """ln(rise/limit) by draw, load and velocity, with random emulator error and friction.

        A single velocity has no axis. The random friction is the scatter between tests of the rig.
        """
        seed = self.ensemble.design.seed
        lines = self.ensemble.excess(self.draws.inputs, loads, velocities).draw_error(seed)
        chance = np.random.default_rng(seed + 1).standard_normal(len(lines))
        return (lines.T + self.rig_scatter * chance).T


def _friction_nodes(conditions: Conditions, x: Array) -> Array:
    """Values of ln(velocity) in the range of `x`, between which ln(friction) is about linear."""
    nodes = np.log([velocity for velocity, _ in conditions.friction_law.by_velocity])
    nodes = np.array([nodes[0] - math.log(2), *nodes, nodes[-1] + math.log(2)])
    parts = max(1, round(_FINE / len(nodes)))
    steps = np.arange((len(nodes) - 1) * parts + 1) / parts
    places = np.interp(steps, np.arange(len(nodes)), nodes)
    return np.asarray(places[(places > x[0]) & (places < x[-1])])


_FINE = 120  # nodes at which friction by velocity is evaluated
_GRID = 4001  # nodes of ln(velocity)
_MOST_CACHED = 64  # loads whose lines are kept, 1.3 MB each


def _normal_below(sd: float, distances: Array) -> Array:
    """Probability that a normal variable of mean 0 and this `sd` is below each of `distances`."""
    return np.asarray(ndtr(distances / sd))


def fields(data: Results) -> list[SampleField]:
    """`SampleField` of each scene in a sweep of samples."""
    return [single_field(scene) for scene in data.scenes]


def single_field(ds: xr.Dataset | Results) -> SampleField:
    """`SampleField` of a sweep of samples; raises an `InputError` if it has several scenes."""
    scene = results(ds)
    ensemble = Ensemble.of(scene)
    weighed = posterior_at(scene, ensemble)
    draws = draws_of(ensemble, weighed.draws if weighed else None)
    return SampleField(ensemble, draws, scene, weighed)


def _describe_left_out(ensemble: Ensemble) -> str:
    """Say how many samples lie in the 90 % bands of an emulator that was fitted without them."""
    left_out, count = ensemble.left_out, len(ensemble.inputs)
    inside = (
        f"{100 * left_out.held:.0f} ± {100 * left_out.error:.0f} % of samples left out are inside "
        "their 90 % bands"
    )
    if not left_out.is_known:
        takes = f"to tell takes {JUDGED} contacts, not {left_out.contacts}"
        return f"{count} samples may not suffice: {inside}; {takes}"
    if not left_out.is_right:
        return f"{count} samples may not suffice: {inside}; it should be 85 to 95 %"
    suffice = " suffice" if count == ensemble.design.sufficient else ""
    return f"{count} samples{suffice}: {inside}"
