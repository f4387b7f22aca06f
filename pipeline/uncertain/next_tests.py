"""The next run: candidates, ranked by what each run of them tells of a target.

A single test costs one run, a search for a transition as many as bisection takes. A test at each of
the truths that are drawn from the posterior updates a filter (`pipeline.uncertain.learning`); the
spread that is left is averaged over them. No truth is among the draws that it is compared with, so
the promise also holds for many tests.
"""

from __future__ import annotations

import itertools
import math
import shlex
from collections.abc import Iterable, Iterator, Mapping, Sequence
from contextlib import suppress
from dataclasses import dataclass
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np
from scipy.special import ndtri

from pipeline.scene.units import UnitError, in_si, to_si
from pipeline.sweep.unknown import OF_90
from pipeline.uncertain.answers import log_boundary
from pipeline.uncertain.evidence import Truths, distances_of
from pipeline.uncertain.inputs import BULK, CRITICAL, FRICTION, LEAST_FRICTION
from pipeline.uncertain.learning import Features, Knowledge, Observable
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
        return round(1 - self.spread / self.before, 12)

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
        is_like = more < _BETTER / (1 - _BETTER)
        return "do about as well" if is_like else f"leave {100 * more:.0f} % more"


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
    """Truths drawn from what is known today, what each has learnt so far, and the target."""

    def __init__(
        self, posterior: Posterior, target: str | None, bulks: Sequence[float | str]
    ) -> None:
        self._posterior, self._ensemble = posterior, posterior.ensemble
        self._chance = np.random.default_rng(self._ensemble.design.seed)
        draws = posterior.draws
        kept = self._chance.choice(len(draws.weights), _TRUTHS, p=draws.weights)
        # Boundaries are powers of the distance from the bulk to the critical temperature.
        bulk = self._ensemble.conditions.bulk_temperature
        origins = {one.path: bulk for one in posterior.unknown if one.path.startswith(CRITICAL)}
        self._features = Features(posterior.unknown, draws, draws.inputs[kept], origins)
        self._count = len(posterior.ensemble.unknown)
        self._scatters = self._scatters_of_truths()
        self._bulks = [in_si("bulk_temperature", bulk, "60 degC") for bulk in bulks]
        self._target = self._slopes_of_target(target)
        self._known = Knowledge.of(self._features)
        self._path = target
        self.before = self.spread
        self.tests, self.others = tuple(self._tests()), tuple(self._others())

    def _sweep_inputs(self, inputs: Array) -> Array:
        """Inputs of the sweep whose tests are planned, among all."""
        return np.asarray(inputs[:, : self._count])

    def _slopes_of_target(self, target: str | None) -> Array:
        """Slopes of the target by the features at each truth, shape (n_target, n, n_feature)."""
        loads = self._ensemble.loads
        for number, quantity in enumerate(self._posterior.unknown):
            if quantity.path == target and quantity.kind != "list":
                return self._features.input_slopes(number)[None]
        wanted = loads if target is None else np.array([load_of_target(self._posterior, target)])
        return self._features.slopes(
            lambda inputs: log_boundary(self._ensemble, self._sweep_inputs(inputs), wanted)[0].T
        )[1]

    def _scatters_of_truths(self) -> Array:
        """Scatter of each truth, which all its tests share, unless the log gives it, shape (n,)."""
        tests = [judged.test for judged in self._posterior.judged]
        said = [t["velocity_scatter"] / t["velocity"] for t in tests if "velocity_scatter" in t]
        if said:
            return np.full(_TRUTHS, np.mean(said))
        low, middle, high = self._posterior.inferred_scatter
        scores = ndtri((self._chance.permutation(_TRUTHS) + 0.5) / _TRUTHS) / _SCORES_APART
        return np.asarray(middle * (high / low) ** scores)

    @property
    def spread(self) -> float:
        """Spread of the target by what is known so far."""
        return self._known.spread(self._target)

    def _left(self, measurement: Observable) -> float:
        """Spread of the target that a measurement is expected to leave."""
        return self._known.expected(measurement, self._target)

    def best(self) -> Iterator[Candidate]:
        """Runs without end, each the best beside those before it, of which each truth learns."""
        runs = [test for test in self.tests if test.runs == 1]
        others = zip(self._in_turn(self._known), self._staircase(self._known), strict=True)
        while True:
            test = min(runs, key=self._left)
            self._known = self._known.after(test, self._chance)
            yield Candidate(test.what, self.spread, self.before, test.test, 1, *next(others))

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
        chance = np.random.default_rng(self._ensemble.design.seed + 1)
        for tests in itertools.cycle(self._single_tests()):
            known = known.after(tests[len(tests) // 2], chance)
            yield known.spread(self._target)

    def _staircase(self, known: Knowledge) -> Iterator[float]:
        """Spread after each run at the loads and bulk temperatures in turn, by a staircase at each.

        The velocity of each truth goes up after a mild test, and down after a severe one.
        """
        chance = np.random.default_rng(self._ensemble.design.seed + 2)
        low, high = np.log(self._ensemble.velocities)
        at = [np.full(_TRUTHS, (low + high) / 2) for _ in self._single_tests()]
        for number, (first, *_) in itertools.cycle(enumerate(self._single_tests())):
            test = first._replace(low=at[number], high=at[number])
            scores = chance.standard_normal(_TRUTHS)
            steps = np.where(test.values + test.deviation * scores < at[number], -_STEP, _STEP)
            known = known.after(test, chance, scores)
            at[number] = (at[number] + steps).clip(low, high)
            yield known.spread(self._target)

    def ranked(self, measurements: Iterable[Observable]) -> list[Candidate]:
        """Measurements, and values of lists that could be found out, the best first.

        Of single tests at a load and a bulk temperature it is the one at the best velocity.
        """
        ranked = [
            Candidate(m.what, self._left(m), self.before, m.test, m.runs) for m in measurements
        ]
        for number, quantity in enumerate(self._posterior.unknown):
            if quantity.kind == "list":
                known = self._known.knowing(self._features.numbers(number))
                left = known.spread(self._target)
                ranked.append(Candidate(f"{quantity.path} itself", left, self.before))
        best = dict[Any, Candidate]()
        for one in sorted(ranked, key=lambda candidate: -candidate.told):
            at = one.test and (one.test["normal_load"], one.test["bulk_temperature"])
            best.setdefault((at, one.runs) if at else one.what, one)
        return [*best.values()]

    def _others(self) -> Iterator[Observable]:
        """What could be measured beside tests: worn widths, and inputs."""
        truths, loads = self._sweep_inputs(self._features.truths), self._ensemble.loads
        boundary, _ = log_boundary(self._ensemble, truths, loads)
        for load, column in zip(loads.tolist(), boundary.T, strict=True):
            middle = math.exp(float(np.median(column)))
            velocity = float(np.clip(middle, *self._ensemble.velocities))
            error = self._ensemble.width(truths, load, velocity).error
            values, slopes = self._features.slopes(partial(self._log_width, load, velocity))
            what = f"the worn width at {load:g} N, {velocity:.3g} m/s"
            yield Observable(what, values[0], slopes[0], np.hypot(WIDTH_SCATTER, error))
        for number, quantity in enumerate(self._posterior.unknown):
            if quantity.kind == "list" or number >= self._count or quantity.path == self._path:
                continue  # what is sought is no measurement of itself
            name = "friction" if quantity.path == FRICTION else quantity.path
            place = self._features.numbers(number).start
            values, slopes = self._features.of_truths[:, place], np.zeros_like(self._known.mean)
            slopes[:, place] = 1.0
            what = f"{name}, to a tenth of its spread today"
            yield Observable(what, values, slopes, np.full(_TRUTHS, _KNOWN))

    def _log_width(self, load: float, velocity: float, inputs: Array) -> Array:
        """Logarithm of the contact's width at a point, shape (1, n)."""
        return self._ensemble.width(self._sweep_inputs(inputs), load, velocity).values[None]

    def _tests(self) -> Iterator[Observable]:
        """Searches for a transition, and single tests, at each load and bulk temperature."""
        ensemble, inputs = self._ensemble, self._sweep_inputs(self._features.truths)
        bulks = self._bulks
        if not bulks:
            bulk = float(np.median(ensemble.values(BULK, inputs)))
            critical = float(np.median(ensemble.values(CRITICAL, inputs)))
            bulks = [bulk, *(bulk + share * (critical - bulk) for share in _WARMER)]
        about = self._friction_of_tests(inputs)
        friction = self._friction_measured(about)
        low, high = ensemble.velocities
        middle = math.sqrt(low * high)
        for load, bulk in itertools.product(ensemble.loads.tolist(), bulks):
            test = {"normal_load": load, "velocity": middle, "bulk_temperature": bulk}
            judged = test | about
            if bulk == ensemble.conditions.bulk_temperature:
                del judged["bulk_temperature"]  # which may be unknown
            log_velocity, deviation, slopes = self._transition(judged)
            where = f"{load:g} N, bulk {bulk - 273.15:.3g} °C"
            likely = math.exp(float(np.median(log_velocity)))
            if low <= likely <= high:
                ends = math.log(low), math.log(high)
                halved = (ends[1] - ends[0]) / float(np.median(deviation))
                runs = 1 + math.ceil(math.log2(max(halved, 2.0)))
                what = f"the transition at {where}, about {likely:.3g} m/s, in {runs} runs"
                at_likely = test | {"velocity": likely}
                yield Observable(
                    what, log_velocity, slopes, deviation, *ends, at_likely, friction, runs
                )
            shares = (np.arange(_VELOCITIES) + 0.5) / _VELOCITIES
            velocities = np.exp(np.quantile(log_velocity, shares)).clip(low, high)
            for velocity in np.unique(velocities).tolist():
                what = f"a test at {where}, {velocity:.3g} m/s"
                ends, place = (math.log(velocity),) * 2, test | {"velocity": velocity}
                yield Observable(what, log_velocity, slopes, deviation, *ends, place, friction)

    def _transition(self, test: Mapping[str, Any]) -> tuple[Array, Array, Array]:
        """Logarithm of each truth's critical velocity, its deviation in a test, and its slopes."""
        place = math.log(test["velocity"])

        def critical(inputs: Array) -> Array:
            truths = Truths(self._sweep_inputs(inputs))
            distances = distances_of(self._ensemble, [test], truths)
            return np.stack([place - distances.values[0], distances.variance[0]])

        (log_velocity, variance), (slopes, _) = self._features.slopes(critical)
        return log_velocity, np.hypot(np.sqrt(variance), self._scatters), slopes

    def _friction_measured(self, about: Mapping[str, float]) -> Observable | None:
        """What the friction that a test measures tells of the rig's; None where it is known."""
        rig = self._posterior.rig
        if not rig or "friction" not in about:
            return None
        friction, scatter = rig

        def log_friction(inputs: Array) -> Array:
            return np.log(np.maximum(inputs[:, friction], LEAST_FRICTION))[None]

        values, slopes = self._features.slopes(log_friction)
        by_error = about["friction_scatter"] / about["friction"]
        deviation = np.hypot(self._features.truths[:, scatter], by_error)
        return Observable("friction", values[0], slopes[0], deviation)

    def _friction_of_tests(self, inputs: Array) -> dict[str, float]:
        """Friction of the next test and its scatter, by the log; neither if that has no friction.

        Before the first test friction is taken to be measured, only as well as it is known today.
        """
        values = self._ensemble.values(FRICTION, inputs)
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


def ranking_command(
    store: Path | str, scatter: float | None, at: Mapping[str, Any], target: str | None = None
) -> str:
    """Command that ranks tests, of samples weighed in the same way, with the same inputs fixed."""
    words = ["irg", "infer", str(store), "--next"]
    words += ["--for", target] if target else []
    words += [f"--at={path}={value}" for path, value in at.items()]
    return shlex.join(words if scatter is None else [*words, f"--scatter={scatter:g}"])
