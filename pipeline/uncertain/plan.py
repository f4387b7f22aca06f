"""The next test: candidates, ranked by the spread of a target that each is expected to leave.

A candidate is tried on truths drawn from what is known today: each gives the result that the test
would have, scatter and measured friction included, all draws are weighed by it, and the spread that
is left is averaged. So what is promised is what is had where the samples are right.
"""

from __future__ import annotations

import itertools
import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass

import numpy as np
from scipy.special import log_ndtr, ndtr, softmax

from pipeline.scene.quantities import in_si
from pipeline.scene.units import UnitError, to_si
from pipeline.uncertain.answers import log_boundary
from pipeline.uncertain.evidence import distances_of
from pipeline.uncertain.fixed import BULK, CRITICAL, FRICTION
from pipeline.uncertain.weigh import Posterior
from tribo import InputError
from tribo.types import Array

_Measurement = tuple[str, Array, dict[str, float] | None]
"""Words, logarithm of the likelihood of results by truth and draw, and the `Candidate.test`."""
WIDTH_SCATTER = 0.03
"""Relative standard deviation of a measured width."""
_KNOWN = 0.1  # of an input's spread: what a good measurement of it leaves
_DRAWS, _TRUTHS = 1024, 96
_SCORES_APART = 2 * 1.645  # normal scores between 5 and 95 %
_VELOCITIES = 9  # of tests at a load and bulk temperature, where the transition is as likely
_WARMER = (1 / 3, 2 / 3)  # of the way from the bulk to the critical temperature


@dataclass(frozen=True, slots=True)
class Candidate:
    """A measurement that could be made next.

    Attributes
    ----------
    what : str
        Measurement, in words.
    spread : float
        Standard deviation of the target that is expected to be left by it, and by those before it
        in a batch. Of the boundary that of the logarithm of the critical velocity, root mean
        square over the loads.
    before : float
        Standard deviation today.
    test : dict or None
        Load [N], velocity [m/s] and bulk temperature [K] of a test; None for other measurements.

    Examples
    --------
    >>> Candidate("the friction", spread=0.03, before=0.05).narrows
    0.4
    """

    what: str
    spread: float
    before: float
    test: dict[str, float] | None = None

    @property
    def narrows(self) -> float:
        """Share of today's spread that the measurement takes away."""
        return round(1 - self.spread / self.before, 12)


def candidates(
    posterior: Posterior,
    target: str | None = None,
    bulk_temperatures: Sequence[float | str] = (),
) -> tuple[Candidate, ...]:
    """Rank measurements by the spread of a target that each is expected to leave, the best first.

    Parameters
    ----------
    posterior : Posterior
        State of knowledge today.
    target : str, optional
        Path of an unknown input, such as ``temperature.critical``, or a load, such as ``400 N``,
        for the critical velocity there; the whole boundary if not given.
    bulk_temperatures : sequence of float or str, optional
        Bulk temperatures of tests [K], or text with a unit; the scene's, and two above it, if not
        given.

    Raises
    ------
    InputError
        If the target is no unknown input and no load of the sweep.

    Examples
    --------
    >>> import pipeline
    >>> ensemble = pipeline.Ensemble.of(pipeline.open_sweep("results/unknown.zarr"))
    >>> best, *_ = pipeline.candidates(pipeline.posterior(ensemble), "temperature.critical")
    >>> best.spread < best.before
    True
    """
    plan = _Plan(posterior, target, bulk_temperatures)
    ranked = (plan.candidate(*measurement) for measurement in plan.measurements())
    return tuple(sorted(ranked, key=lambda candidate: candidate.spread))


def plan_tests(
    posterior: Posterior,
    count: int,
    target: str | None = None,
    bulk_temperatures: Sequence[float | str] = (),
) -> tuple[Candidate, ...]:
    """Plan several tests at once, each the best beside those before it.

    Parameters
    ----------
    posterior : Posterior
        Result of `pipeline.posterior`.
    count : int
        Number of tests, at least 1.
    target, bulk_temperatures : optional
        See `candidates`.

    Examples
    --------
    >>> import pipeline
    >>> ensemble = pipeline.Ensemble.of(pipeline.open_sweep("results/unknown.zarr"))
    >>> first, second = pipeline.plan_tests(pipeline.posterior(ensemble), 2, "temperature.critical")
    >>> second.spread < first.spread
    True
    """
    if count < 1:
        raise InputError(f"count is {count}; it must be at least 1")
    plan, planned = _Plan(posterior, target, bulk_temperatures), []
    so_far = np.zeros((_TRUTHS, len(plan.values)))
    for _ in range(count):
        ranked = [
            (plan.candidate(what, log_likelihood + so_far, test), log_likelihood)
            for what, log_likelihood, test in plan.measurements()
            if test
        ]
        best, log_likelihood = min(ranked, key=lambda pair: pair[0].spread)
        so_far += log_likelihood
        planned.append(best)
    return tuple(planned)


class _Plan:
    """Draws of today, those of them that are taken as truths, and the target."""

    def __init__(
        self, posterior: Posterior, target: str | None, bulks: Sequence[float | str]
    ) -> None:
        self._posterior, self._ensemble = posterior, posterior.ensemble
        # Of equal weight, so that truths are the first of them.
        self._chance = np.random.default_rng(self._ensemble.design.seed)
        draws = posterior.draws
        kept = self._chance.choice(len(draws.weights), _DRAWS, p=draws.weights)
        self._all = draws.inputs[kept]
        self._inputs = self._all[:, posterior.columns[0]]
        self._scatters = self._scatters_of_draws()
        self._bulks = [in_si("bulk_temperature", bulk, "60 degC") for bulk in bulks]
        self._boundary = log_boundary(
            self._ensemble, self._inputs, self._ensemble.loads, with_error=False
        )[0]
        self.values = self._target(target)
        self.before = math.sqrt(float(self.values.var(axis=0).mean()))

    def _target(self, target: str | None) -> Array:
        """Values of the target by draw, shape (n, n_target)."""
        if target is None:
            return self._boundary
        for quantity, column in zip(self._posterior.unknown, self._all.T, strict=True):
            if quantity.path == target and quantity.kind != "list":
                return np.asarray(np.log(column) if quantity.is_relative else column)[:, None]
        loads = self._ensemble.loads
        try:
            load = to_si(target, "400 N")
        except UnitError:
            load = math.nan
        if not loads[0] <= load <= loads[-1]:
            unknown = self._posterior.unknown
            paths = ", ".join(quantity.path for quantity in unknown if quantity.kind != "list")
            raise InputError(
                f'target is "{target}"; give one of {paths}, or a load from {loads[0]:g} to '
                f'{loads[-1]:g} N for the boundary there, such as "{loads[0]:g} N"'
            )
        return log_boundary(self._ensemble, self._inputs, [load], with_error=False)[0]

    def _scatters_of_draws(self) -> Array:
        """Scatter of each draw, which all its tests share, unless the log gives it, shape (n,)."""
        tests = [judged.test for judged in self._posterior.judged]
        said = [t["velocity_scatter"] / t["velocity"] for t in tests if "velocity_scatter" in t]
        if said:
            return np.full(_DRAWS, np.mean(said))
        low, middle, high = self._posterior.inferred_scatter
        scores = self._chance.standard_normal(_DRAWS) / _SCORES_APART
        return np.asarray(middle * (high / low) ** scores)

    def candidate(
        self, what: str, log_likelihood: Array, test: dict[str, float] | None
    ) -> Candidate:
        """A measurement with the spread that a likelihood of draws leaves, averaged over truths."""
        weights = softmax(log_likelihood, axis=1)
        mean = weights @ self.values
        variance = weights @ self.values**2 - mean**2
        spread = math.sqrt(max(float(variance.mean()), 0.0))
        return Candidate(what, spread, self.before, test)

    def measurements(self) -> Iterator[_Measurement]:
        """All that could be measured, each with results drawn anew."""
        yield from self._tests()
        for load, column in zip(self._ensemble.loads.tolist(), self._boundary.T, strict=True):
            middle = math.exp(float(np.median(column)))
            velocity = float(np.clip(middle, *self._ensemble.velocities))
            width = self._ensemble.width(self._inputs, load, velocity)
            error = math.hypot(WIDTH_SCATTER, float(np.mean(width.error)))
            what = f"the worn width at {load:g} N, {velocity:.3g} m/s"
            yield what, self._measured(width.values, np.full(_DRAWS, error)), None
        for quantity, column in zip(self._posterior.unknown, self._all.T, strict=True):
            if quantity.kind == "list":
                same = column[:_TRUTHS, None] == column
                yield f"{quantity.path} itself", np.where(same, 0.0, -np.inf), None
                continue
            values = np.log(column) if quantity.is_relative else column
            name = "friction" if quantity.path == FRICTION else quantity.path
            what = f"{name}, to a tenth of its spread today"
            error = max(_KNOWN * float(values.std()), 1e-300)
            yield what, self._measured(values, np.full(_DRAWS, error)), None

    def _tests(self) -> Iterator[_Measurement]:
        """Searches for a transition, and single tests, at each load and bulk temperature."""
        ensemble = self._ensemble
        bulks = self._bulks
        if not bulks:
            bulk = float(np.median(ensemble.values(BULK, self._inputs)))
            critical = float(np.median(ensemble.values(CRITICAL, self._inputs)))
            bulks = [bulk, *(bulk + share * (critical - bulk) for share in _WARMER)]
        about = self._friction_of_tests()
        low, high = ensemble.velocities
        middle = math.sqrt(low * high)
        for load, bulk in itertools.product(ensemble.loads.tolist(), bulks):
            test = {"normal_load": load, "velocity": middle, "bulk_temperature": bulk}
            judged = test | about
            if bulk == ensemble.conditions.bulk_temperature:
                del judged["bulk_temperature"]  # which may be unknown
            distances = distances_of(ensemble, [judged], self._inputs)
            log_velocity = math.log(middle) - distances.values[0]
            deviation = np.hypot(np.sqrt(distances.variance[0]), self._scatters)
            where = f"{load:g} N, bulk {bulk - 273.15:.3g} °C"
            likely = math.exp(float(np.median(log_velocity)))
            if low <= likely <= high:
                what = f"the transition at {where}, about {likely:.3g} m/s"
                likelihood = self._measured(log_velocity, deviation, *np.log([low, high]))
                yield what, likelihood, test | {"velocity": likely}
            shares = (np.arange(_VELOCITIES) + 0.5) / _VELOCITIES
            velocities = np.exp(np.quantile(log_velocity, shares)).clip(low, high)
            for velocity in np.unique(velocities).tolist():
                what = f"a test at {where}, {velocity:.3g} m/s"
                likelihood = self._outcome((math.log(velocity) - log_velocity) / deviation)
                yield what, likelihood, test | {"velocity": velocity}

    def _friction_of_tests(self) -> dict[str, float]:
        """Friction of the next test and its scatter, by the log; neither if that has no friction.

        Before the first test friction is taken to be measured, only as well as it is known today.
        """
        values = self._ensemble.values(FRICTION, self._inputs)
        tests = [judged.test for judged in self._posterior.judged]
        measured = [test for test in tests if test.get("friction") is not None]
        if tests and not measured:
            return {}
        scatters = [test.get("friction_scatter", 0.0) for test in measured] or [np.std(values)]
        frictions = [test["friction"] for test in measured] or values
        return {
            "friction": float(np.median(frictions)),
            "friction_scatter": float(np.mean(scatters)),
        }

    def _measured(
        self, values: Array, deviation: Array, low: float = -math.inf, high: float = math.inf
    ) -> Array:
        """Likelihood of a number that is measured with an error, and may lie beyond two ends."""
        chance = self._chance.standard_normal(_TRUTHS)
        results = values[:_TRUTHS] + deviation[:_TRUTHS] * chance
        log: Array = -0.5 * ((results[:, None] - values) / deviation) ** 2 - np.log(deviation)
        log[results < low] = log_ndtr((low - values) / deviation)
        log[results > high] = log_ndtr((values - high) / deviation)
        return log

    def _outcome(self, z: Array) -> Array:
        """Likelihood of a test that turns severe with the probability Φ(z).

        As many truths turn severe as are expected to, or chance would rank tests.
        """
        severe = np.clip(ndtr(z), 1e-12, 1 - 1e-12)
        count = np.cumsum(np.append(self._chance.random(), severe[:_TRUTHS]))
        is_severe = np.diff(np.floor(count)) > 0
        log: Array = np.where(is_severe[:, None], np.log(severe), np.log1p(-severe))
        return log
