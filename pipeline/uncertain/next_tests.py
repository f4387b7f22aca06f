"""The next run: candidates, ranked by what each run of them tells of a target.

A single test costs one run, a search for a transition as many as bisection takes. A test at each of
the truths that are drawn from the posterior weighs all its draws (`pipeline.uncertain.learning`);
the spread that is left is averaged over the truths.
"""

from __future__ import annotations

import functools
import itertools
import math
import shlex
from collections.abc import Iterable, Iterator, Mapping, Sequence
from contextlib import suppress
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from scipy.special import ndtri

from pipeline.analysis.at import oil_temperature
from pipeline.quantities import display
from pipeline.scene.units import UnitError, to_si
from pipeline.sweep.unknown import OF_90, Unknown
from pipeline.uncertain.answers import log_boundary
from pipeline.uncertain.evidence import (
    Distances,
    Truths,
    distances_of,
    fix_varying,
    part_scatter,
)
from pipeline.uncertain.inputs import BULK, CRITICAL, FRICTION, LEAST_FRICTION
from pipeline.uncertain.learning import Knowledge, Observable
from pipeline.uncertain.posterior import Posterior
from tribo import InputError
from tribo.types import Array

WIDTH_SCATTER = 0.03
"""Relative standard deviation of a measured width."""
_KNOWN = 0.1  # share of an input's spread that a good measurement of it leaves
_TRUTHS = 256
_SCORES_APART = 2 * OF_90  # normal scores between 5 and 95 %
_VELOCITIES = 9  # velocities of tests at a load and bulk temperature, even in probability
_BETTER = 0.2  # share of a spread by which a plan is to be better than runs in turn
_STEP = math.log(1.2)  # of a staircase, in ln(velocity)
_LEAST = 1e-12  # share of a spread
_FRICTIONS = 4  # runs whose friction is learnt: that of more tells little, and uses up the draws
_WARMER = (1 / 3, 2 / 3)  # shares of the way from the bulk to the critical temperature


@dataclass(frozen=True, slots=True)
class Candidate:
    """A measurement that could be made next."""

    what: str  #: Measurement, in words.
    #: Expected standard deviation of the target after it, and after those before it in a batch. For
    #: the boundary, that of the logarithm of the critical velocity, root mean square over the
    #: loads.
    spread: float
    before: float  #: Standard deviation today.
    #: Load [N], velocity [m/s] and bulk temperature [K] of a test; None for other measurements.
    test: dict[str, float] | None = None
    runs: int = 1  #: Runs that it costs.
    #: Of a plan: the spread after as many runs at each load and bulk temperature in turn, and by a
    #: staircase there.
    in_turn: float | None = None
    staircase: float | None = None

    @property
    def narrows(self) -> float:
        """Share of today's spread that the measurement takes away."""
        return round(max(1 - self.spread / self.before, 0.0), 12)

    @property
    def told(self) -> float:
        """What each of its runs tells: −ln(spread/before) over their number."""
        return -math.log(max(self.spread, _LEAST) / self.before) / self.runs

    @property
    def comparison(self) -> str:
        """Other rules beside the runs planned, in a sentence; empty beside no plan."""
        if self.in_turn is None or self.staircase is None:
            return ""
        in_turn, staircase = map(self._compare, (self.in_turn, self.staircase))
        return (
            f"as many runs at each load and bulk temperature in turn {in_turn}, by a staircase "
            f"there they {staircase}"
        )

    def _compare(self, other: float) -> str:
        """What as many runs by another rule do, given the spread that they leave."""
        more = other / self.spread - 1
        if 1 - _BETTER < 1 + more < 1 / (1 - _BETTER):
            return "do about as well"
        return f"leave {100 * abs(more):.0f} % {'more' if more > 0 else 'less'}"


def load_of_target(posterior: Posterior, target: str) -> float:
    """Load of the boundary that is a target [N]; raises if it is no load of the sweep."""
    loads = posterior.ensemble.loads
    with suppress(UnitError):
        if loads[0] <= (load := to_si(target, "400 N")) <= loads[-1]:
            return load
    paths = ", ".join(one.path for one in posterior.unknown if one.kind != "list")
    raise InputError(
        f'target is "{target}"; give one of {paths}, or a load from {loads[0]:g} to '
        f'{loads[-1]:g} N for the boundary there, such as "{loads[0]:g} N"'
    )


def candidates(
    posterior: Posterior, target: str | None = None, bulk_temperatures: Sequence[float | str] = ()
) -> tuple[Candidate, ...]:
    """Rank measurements by what each of their runs tells of a target, the best first.

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
    return tuple(plan.ranked([*plan.tests, *plan.others]))


def plan_tests(
    posterior: Posterior,
    count: int,
    target: str | None = None,
    bulk_temperatures: Sequence[float | str] = (),
) -> tuple[Candidate, ...]:
    """Plan several runs at once: each is the single test that tells most after those before it.

    Parameters
    ----------
    posterior : Posterior
        Result of `pipeline.posterior`.
    count : int
        Number of runs, at least 1.
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
    return tuple(itertools.islice(_Plan(posterior, target, bulk_temperatures).best(), count))


class _Plan:
    """Truths and draws of what is known today, and what each truth has learnt so far."""

    def __init__(
        self, posterior: Posterior, target: str | None, bulks: Sequence[float | str]
    ) -> None:
        self._posterior, self._ensemble = posterior, posterior.ensemble
        self._seed = self._ensemble.design.seed
        self._chance = np.random.default_rng(self._seed)
        draws = posterior.draws
        kept = self._chance.choice(len(draws.weights), _TRUTHS, p=draws.weights)
        truths = draws.inputs[kept]
        self._inputs = np.concatenate([truths, draws.inputs])
        self._sweep_inputs = self._inputs[:, : len(self._ensemble.unknown)]
        self._scatters = self._scatters_of_all()
        self._bulks = [oil_temperature("bulk_temperature", bulk) for bulk in bulks]
        self._path = target
        values = self._values_of_target()
        self._target = values - draws.mean(values.T)[:, None]
        self._known = Knowledge.of(truths, draws.inputs, draws.weights)
        self.before = math.sqrt(float(draws.mean(self._target.T**2).mean()))
        self.tests, self.others = tuple(self._tests()), tuple(self._others())

    def _values_of_target(self) -> Array:
        """Values of the target by draw, logarithms if relative, shape (n_target, n_draw)."""
        for number, quantity in enumerate(self._posterior.unknown):
            if quantity.path == self._path and quantity.kind != "list":
                return _coordinate(quantity, self._inputs[_TRUTHS:, number])[None]
        loads = self._ensemble.loads
        if self._path is not None:
            loads = np.array([load_of_target(self._posterior, self._path)])
        return log_boundary(self._ensemble, self._sweep_inputs[_TRUTHS:], loads)[0].T

    def _scatters_of_all(self) -> Array:
        """Scatter of each truth and draw, which all its tests share, unless the log gives it."""
        tests = [judged.test for judged in self._posterior.judged]
        said = [t["velocity_scatter"] / t["velocity"] for t in tests if "velocity_scatter" in t]
        if said:
            return np.full(len(self._inputs), np.mean(said))
        low, middle, high = self._posterior.inferred_scatter
        scores = np.concatenate(
            [
                ndtri((self._chance.permutation(count) + 0.5) / count) / _SCORES_APART
                for count in (_TRUTHS, len(self._inputs) - _TRUTHS)
            ]
        )
        return np.asarray(middle * (high / low) ** scores)

    def _learn_friction(self, known: Knowledge, run: int = 0) -> Knowledge:
        """What is known once a run has told its friction."""
        if self._friction is None or run >= _FRICTIONS:
            return known
        return known.after(self._friction, np.random.default_rng((self._seed, run)))

    def best(self) -> Iterator[Candidate]:
        """Runs without end, each the best beside those before it, of which each truth learns."""
        tests = [*itertools.chain(*self._single_tests())]
        others = zip(self._in_turn(self._known), self._staircase(self._known), strict=True)
        for run in itertools.count():
            known = self._learn_friction(self._known, run)
            left = known.expected(tests, self._target)
            test = tests[best := int(left.argmin())]
            self._known = known.after(test, self._chance)
            spread = float(left[best])
            yield Candidate(test.what, spread, self.before, test.test, 1, *next(others))

    def _single_tests(self) -> list[list[Observable]]:
        """Single tests at each load and bulk temperature, by velocity."""
        places = dict[tuple[float, float], list[Observable]]()
        for test in self.tests:
            if test.runs == 1 and test.test:
                place = test.test["normal_load"], test.test["bulk_temperature"]
                places.setdefault(place, []).append(test)
        return [*places.values()]

    def _in_turn(self, known: Knowledge) -> Iterator[float]:
        """Spread after each run at the loads and bulk temperatures in turn, where it may be both.

        At each the velocity is the one at which the transition is as likely above as below.
        """
        chance = np.random.default_rng(self._seed + 1)
        for run, tests in enumerate(itertools.cycle(self._single_tests())):
            known = self._learn_friction(known, run).after(tests[len(tests) // 2], chance)
            yield known.spread(self._target)

    def _staircase(self, known: Knowledge) -> Iterator[float]:
        """Spread after each run at the loads and bulk temperatures in turn, by a staircase at each.

        The velocity of each truth goes up after a mild test, and down after a severe one.
        """
        chance = np.random.default_rng(self._seed + 2)
        low, high = np.log(self._ensemble.velocities)
        at = [np.full(_TRUTHS, (low + high) / 2) for _ in self._single_tests()]
        places = itertools.cycle(enumerate(self._single_tests()))
        for run, (number, (first, *_)) in enumerate(places):
            test = first._replace(low=at[number], high=at[number])
            scores = chance.standard_normal(_TRUTHS)
            result = test.values[:_TRUTHS] + test.deviation[:_TRUTHS] * scores
            is_mild = result >= at[number]
            known = self._learn_friction(known, run).after(test, chance, scores)
            at[number] = (at[number] + np.where(is_mild, _STEP, -_STEP)).clip(low, high)
            yield known.spread(self._target)

    def ranked(self, measurements: Iterable[Observable]) -> list[Candidate]:
        """Measurements, and values of lists that could be found out, the best first.

        Of single tests at a load and a bulk temperature it is the one at the best velocity.
        """
        after, ranked = self._learn_friction(self._known), list[Candidate]()
        for m in measurements:
            known = after if m.test else self._known
            if m.test and m.runs == 1:
                left = float(known.expected([m], self._target)[0])
            else:  # with the same errors, so that measurements compare
                left = known.after(m, np.random.default_rng(self._seed)).spread(self._target)
            ranked.append(Candidate(m.what, left, self.before, m.test, m.runs))
        for number, quantity in enumerate(self._posterior.unknown):
            if quantity.kind == "list" and not quantity.varies:
                left = self._known.spread_given(self._inputs[_TRUTHS:, number], self._target)
                ranked.append(Candidate(f"{quantity.path} itself", left, self.before))
        best = dict[Any, Candidate]()
        for one in sorted(ranked, key=lambda candidate: -candidate.told):
            at = one.test and (one.test["normal_load"], one.test["bulk_temperature"])
            best.setdefault((at, one.runs) if at else one.what, one)
        return [*best.values()]

    def _others(self) -> Iterator[Observable]:
        """What could be measured beside tests: worn widths, and inputs."""
        ensemble, draws = self._ensemble, self._posterior.draws
        boundary, _ = log_boundary(ensemble, self._sweep_inputs[:_TRUTHS], ensemble.loads)
        for load, column in zip(ensemble.loads.tolist(), boundary.T, strict=True):
            middle = math.exp(float(np.median(column)))
            velocity = float(np.clip(middle, *ensemble.velocities))
            width = ensemble.width(self._sweep_inputs, load, velocity)
            what = f"the worn width at {load:g} N, {velocity:.3g} m/s"
            yield Observable(what, width.values, np.hypot(WIDTH_SCATTER, width.error))
        for number, quantity in enumerate(ensemble.unknown):
            if quantity.kind == "list" or quantity.varies or quantity.path == self._path:
                continue  # what is sought is no measurement of itself, nor a part of the next one
            name = "friction" if quantity.path == FRICTION else quantity.path
            values = _coordinate(quantity, self._inputs[:, number])
            what = f"{name}, to a tenth of its spread today"
            deviation = np.full(len(values), _KNOWN * draws.spread(values[_TRUTHS:]))
            yield Observable(what, values, deviation)

    def _tests(self) -> Iterator[Observable]:
        """Searches for a transition, and single tests, at each load and bulk temperature."""
        ensemble, bulks = self._ensemble, self._bulks
        if not bulks:
            truths = self._sweep_inputs[:_TRUTHS]
            bulk = float(np.median(ensemble.values(BULK, truths)))
            critical = float(np.median(ensemble.values(CRITICAL, truths)))
            bulks = [bulk, *(bulk + share * (critical - bulk) for share in _WARMER)]
        low, high = ensemble.velocities
        middle = math.sqrt(low * high)
        for load, bulk in itertools.product(ensemble.loads.tolist(), bulks):
            test = {"normal_load": load, "velocity": middle, "bulk_temperature": bulk}
            judged = test | self._logged_friction
            if bulk == ensemble.conditions.bulk_temperature:
                del judged["bulk_temperature"]  # which may be unknown
            log_velocity, deviation = self._transition(judged)
            where = f"{load:g} N, bulk {display(bulk, '°C', 3)}"
            likely = math.exp(float(np.median(log_velocity[:_TRUTHS])))
            if low <= likely <= high:
                ends = math.log(low), math.log(high)
                halved = (ends[1] - ends[0]) / float(np.median(deviation[:_TRUTHS]))
                runs = 1 + math.ceil(math.log2(max(halved, 2.0)))
                what = f"the transition at {where}, about {likely:.3g} m/s, in {runs} runs"
                at_likely = test | {"velocity": likely}
                yield Observable(what, log_velocity, deviation, *ends, at_likely, runs)
            shares = (np.arange(_VELOCITIES) + 0.5) / _VELOCITIES
            velocities = np.exp(np.quantile(log_velocity[:_TRUTHS], shares)).clip(low, high)
            for velocity in np.unique(velocities).tolist():
                what = f"a test at {where}, {velocity:.3g} m/s"
                end, place = math.log(velocity), test | {"velocity": velocity}
                yield Observable(what, log_velocity, deviation, end, end, place)

    def _transition(self, test: Mapping[str, Any]) -> tuple[Array, Array]:
        """Logarithm of each one's critical velocity, and its deviation in a test."""
        unknown = self._ensemble.unknown

        def distances(inputs: Array) -> Distances:
            return distances_of(self._ensemble, [test], Truths(inputs))

        found = distances(fix_varying(unknown, self._sweep_inputs))
        (shift,), (variance,) = part_scatter(unknown, distances, self._seed)
        log_velocity = math.log(test["velocity"]) - found.values[0] - shift
        return log_velocity, np.sqrt(found.variance[0] + variance + self._scatters**2)

    @functools.cached_property
    def _friction(self) -> Observable | None:
        """What the friction that a test measures tells of the rig's; None where it is known."""
        if not self._posterior.rig or "friction" not in self._logged_friction:
            return None
        friction, scatter = self._inputs[:, self._posterior.rig].T
        by_error = self._logged_friction["friction_scatter"] / self._logged_friction["friction"]
        log_friction = np.log(np.maximum(friction, LEAST_FRICTION))
        return Observable("friction", log_friction, np.hypot(scatter, by_error))

    @functools.cached_property
    def _logged_friction(self) -> dict[str, float]:
        """Friction of the next test and its scatter, by the log; neither if that has no friction.

        Before the first test friction is taken to be measured, only as well as it is known today.
        """
        values = self._ensemble.values(FRICTION, self._sweep_inputs[:_TRUTHS])
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


def _coordinate(quantity: Unknown, values: Array) -> Array:
    """Values of an input, or their logarithms if it is relative."""
    return np.log(values) if quantity.is_relative else values


def ranking_command(
    store: Path | str, judged: Sequence[str] = (), target: str | None = None
) -> str:
    """Command that ranks tests, of samples judged and weighed by the same options."""
    wanted = ["--for", target] if target else []
    return shlex.join(["irg", "infer", str(store), "--next", *wanted, *judged])
