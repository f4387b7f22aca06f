"""Likelihood of measured transitions, tests and runs in stages, for draws of the inputs.

Each draw has its own critical velocity V_c at the load, friction and bulk temperature of the test.
Let d = ln(V/V_c), with standard deviation σ. A transition measured at V has the likelihood
φ(d/σ)/σ, a test that turned severe Φ(d/σ), a mild test Φ(−d/σ). All tests of a run are of one
specimen and share its scatter: a run mild at d₁ and severe at d₂ has the likelihood Φ(d₂/σ) −
Φ(d₁/σ). Three parts add up to σ: the scatter of the velocity, that of load and friction divided by
the slope of the rise, and the emulator's error.
"""

from __future__ import annotations

import functools
import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any, NamedTuple

import numpy as np
from scipy.special import log_ndtr

from pipeline.analysis.curve import LEAST_SLOPE
from pipeline.uncertain.answers import line_turns, log_crossings
from pipeline.uncertain.ensemble import Ensemble
from pipeline.uncertain.inputs import CRITICAL, prior
from pipeline.uncertain.rig import acting_friction, join_oils, join_rig
from pipeline.uncertain.unknown import Unknown
from tribo import InputError
from tribo.types import Array

Test = Mapping[str, Any]
"""Entries of a test, as `Measurement.as_dict` gives them."""

SIGNS = {"severe": 1.0, "mild": -1.0}
"""Sign that `Distances.values` has if a draw agrees with the outcome of a test."""
_NODES, _FINE = 9, 65  # velocities at which rises are computed; more with a friction curve


class Distances(NamedTuple):
    """Distance in ln(velocity) of each test from the computed critical velocity of each draw.

    All arrays are (n_test, n). `signs` is 1 where wear turns severe with velocity at the critical
    velocity, −1 where it turns mild.
    """

    #: ln(V/V_c) of the test's velocity V and the nearest change V_c of wear, positive on its
    #: severe side.
    values: Array
    signs: Array  # 1 if wear turns severe with velocity at V_c, −1 if it turns mild
    variance: Array  # variance of `values`, without the scatter of the velocity
    by_rig: Array  # log likelihood of the measured friction if the rig's friction is inferred


def require_possible(ensemble: Ensemble) -> None:
    """Raise an `InputError` if a test has a load, velocity or duration that the samples lack."""
    for test in ensemble.tests:
        place = f"the test at {test['normal_load']:g} N and {test['velocity']:g} m/s"
        try:
            ensemble.require_within([test["normal_load"]], [test["velocity"]])
        except InputError as error:
            raise InputError(f"{place}: {error}") from error
        hold = test.get("hold", ensemble.hold)
        if hold not in ensemble.ensembles_by_hold:
            raise InputError(
                f"{place} held the load for {hold:g} s, the samples for {ensemble.hold:g} s: set "
                "loading.hold to that of the longest test, and run the samples again"
            )


class JointDraws(NamedTuple):
    """Draws of all unknown quantities that affect tests; arrays have a row for each draw."""

    inputs: Array  # unknown inputs of the scene [SI], (n, n_unknown)
    rig: Array | None = None  # friction coefficient of the rig, and its scatter, (n, 2)
    oils: Mapping[str, Array] = {}  # critical temperatures [K] of oils that have their own, (n,)


def _test_distances(ensemble: Ensemble, tests: Sequence[Test], truths: JointDraws) -> Distances:
    """Distance in ln(velocity) of each test from the critical velocity of each draw.

    The draws (`truths`) are of all unknown quantities. All `tests` must have held the full load for
    the same time as the samples of the ensemble.
    """
    inputs, rig, oils = truths
    count = _FINE if ensemble.conditions.has_friction_curve else _NODES
    nodes = np.geomspace(*ensemble.velocities, count)
    loads = sorted({test["normal_load"] for test in tests})
    excess = ensemble.excess(inputs, loads, nodes)
    rises = excess.values + ensemble.log_limit(inputs)[:, None, None]
    x = np.log(nodes)
    conditions = ensemble.conditions
    # A measured friction replaces the scene's friction by velocity.
    table = np.log([conditions.friction_at(v) / conditions.friction for v in nodes.tolist()])
    values, signs, variances, likelihoods = [], [], [], []
    for test in tests:
        number, friction = loads.index(test["normal_load"]), test.get("friction")
        critical = oils.get(test.get("oil", ""))
        is_given = friction is not None or rig is not None
        rise = rises[:, number] - table if is_given else rises[:, number]
        log_velocity = math.log(test["velocity"])
        by_rig = np.zeros(1)
        by_friction: Any = (test.get("friction_scatter", 0.0) / (friction or 1.0)) ** 2
        if rig is not None:
            limit = ensemble.values(CRITICAL, inputs) if critical is None else critical
            factor = np.interp(log_velocity, x, table) + ensemble.log_friction_factor(limit)
            acted, by_friction, by_rig = acting_friction(rig, test, factor)
            friction = np.exp(acted)
        place = int(np.clip(np.searchsorted(x, log_velocity) - 1, 0, count - 2))
        slope = (rise[:, place + 1] - rise[:, place]) / (x[place + 1] - x[place])
        variance = excess.error[:, number, place] ** 2 + by_friction
        limit = ensemble.log_limit(
            inputs, friction, test.get("bulk_temperature"), critical=critical,
            was_measured=friction is not None,
        )  # fmt: skip
        distance, sign = _turn_distance(nodes, rise - limit[:, None], test)
        values.append(distance)
        signs.append(sign)
        variances.append(variance / np.maximum(np.abs(slope), LEAST_SLOPE) ** 2)
        likelihoods.append(np.broadcast_to(by_rig, len(inputs)))
    return Distances(*map(np.array, (values, signs, variances, likelihoods)))


def _turn_distance(velocities: Array, excess: Array, test: Test) -> tuple[Array, Array]:
    """Distance in ln(velocity) of a test from the nearest change of wear, and the change's sign.

    Both are (n,), with a value for each draw. The distance is positive if the test is on the severe
    side. The sign is 1 if wear turns severe with velocity, −1 if it turns mild. `excess` (n, m) is
    ln(rise/limit) at `velocities` (m,) [m/s]. For a measured transition only changes to severe wear
    count.
    """
    log_velocity = math.log(test["velocity"])
    critical, *_ = log_crossings(velocities, excess)
    turns, places = line_turns(np.log(velocities), excess)
    distances = turns * (log_velocity - places)
    counts = turns != 0 if "outcome" in test else turns > 0
    apart = np.where(counts, np.abs(distances), math.inf)
    nearest = apart.argmin(axis=1)[:, None]
    # If wear does not change within the velocities, the excess is extrapolated beyond them.
    values, signs = (
        np.where(counts.any(axis=1), np.take_along_axis(own, nearest, axis=1)[:, 0], other)
        for own, other in ((distances, log_velocity - critical), (turns, 1))
    )
    return values, signs


def fix_varying(unknown: Sequence[Unknown], inputs: Array) -> Array:
    """In draws (n, n_unknown), replace inputs that vary between specimens by their median."""
    medians = [one.quantile(np.array([0.5]))[0] for one in unknown]
    return np.where([one.varies for one in unknown], medians, inputs)


class Runs(NamedTuple):
    """What the tests of each run show about its specimen, for n draws of the inputs.

    The arrays are (n_run, n, n_scatter); the last axis has possible values of the scatter between
    runs. `low` and `high` bound the deviation of the specimen's ln(critical velocity) from the
    model, in standard deviations; at a measured transition they are equal. `log_likelihoods` are
    ln(likelihood) of all that was measured in the run.
    """

    low: Array
    high: Array
    log_likelihoods: Array


def decisive_tests(tests: Sequence[Test], by_load: bool = False) -> list[Test]:
    """Tests whose outcome does not follow from other tests of the same run.

    They are the mild tests at the highest load and velocity of a run, and the severe tests at the
    lowest. With `by_load` only tests at the same velocity are compared, because wear may turn mild
    at a higher velocity.
    """
    places = ["normal_load"] if by_load else ["normal_load", "velocity"]
    seen = dict[Any, tuple[int, tuple[float, float]]]()
    kept = dict(enumerate(tests))
    for number, test in enumerate(tests):
        if "run" not in test:
            continue
        sign = SIGNS[test["outcome"]]
        at = -sign * test["normal_load"], -sign * test["velocity"]
        same = {k: v for k, v in test.items() if k not in (*places, "number")}
        key = tuple(same.items())
        before, there = seen.get(key, (number, at))
        if at[0] >= there[0] and at[1] >= there[1]:
            seen[key] = number, at
            if before != number:
                del kept[before]
        elif at[0] <= there[0] and at[1] <= there[1]:
            del kept[number]
    return list(kept.values())


def log_between(low: Array, high: Array) -> Array:
    """ln(Φ(high) − Φ(low)) with the normal distribution function Φ, accurate also in the tails.

    For an empty interval the result is a very low number.
    """
    is_above = low > 0  # Φ(−low) − Φ(−high) is the same without cancellation
    low, high = np.where(is_above, -high, low), np.where(is_above, -low, high)
    upper = log_ndtr(high)
    with np.errstate(invalid="ignore", divide="ignore"):
        share = -np.expm1(np.minimum(log_ndtr(low) - upper, 0.0))
        return np.asarray(
            np.where(high > low, upper + np.log(share), _IMPOSSIBLE).clip(_IMPOSSIBLE)
        )


_IMPOSSIBLE = -1e6


FACTOR = 3.0
"""Two thirds of true scatters are within this factor of the stated one: rigs differ that much."""
FACTORS = FACTOR ** np.linspace(-2.0, 2.2, 11)
"""Factors on the stated scatter between which the tests choose."""
_LOG_PRIOR = -0.5 * (np.log(FACTORS) / math.log(FACTOR)) ** 2  # log prior of each factor
_VARIED = 2**10  # draws to estimate the scatter between parts
_FAR = 2.0  # largest rms deviation of the tests from the best draw, in standard deviations


class JudgedTests(NamedTuple):
    """Tests compared with n draws of the inputs.

    A run is the tests of one specimen. `distances` has the distance of each test from the computed
    critical velocity in ln(velocity), (n_test, n). `runs` has bounds on the deviation of each run
    from the model, in standard deviations, (n_run, n, n_scatter). `joint` is ln(likelihood of all
    runs × prior of the scatter), (n, n_scatter). The axis n_scatter has possible values of the
    scatter between runs.
    """

    distances: Distances
    runs: Runs
    joint: Array


@dataclass(frozen=True, eq=False)
class Joint:
    """Unknown inputs and tests of a sweep; `judge_draws` compares draws of the inputs with tests.

    The inputs include the friction of the test rig and the critical temperatures of other oils.
    `rig` and `oils` are the columns of these inputs in draws, (n, n_unknown).
    """

    ensemble: Ensemble
    unknown: tuple[Unknown, ...]  # inputs of the sweep, then those of oils and rig
    rig: tuple[int, ...]  # columns of the rig's friction and its scatter; or empty
    oils: Mapping[str, int]  # column of the critical temperature of each other oil
    scatters: Array  # standard deviations of ln(velocity) to choose from, (n_scatter,)

    @classmethod
    def of(cls, ensemble: Ensemble, scatter: float) -> Joint:
        """Collect the unknown inputs and the tests of an ensemble.

        `scatter` is the assumed relative scatter of measured velocities. Raises an `InputError` if
        the ensemble's samples do not cover the load, velocity or duration of a test, or tests are
        of several oils but the critical temperature is known.
        """
        require_possible(ensemble)
        unknown, oils = join_oils(ensemble)
        unknown, rig = join_rig(ensemble, unknown)
        return cls(ensemble, unknown, rig, oils, scatter * FACTORS)

    @functools.cached_property
    def tests(self) -> list[Test]:
        """Tests whose outcome does not follow from other tests of the same run."""
        return decisive_tests(self.ensemble.tests, self.ensemble.conditions.has_friction_curve)

    @functools.cached_property
    def runs(self) -> list[list[int]]:
        """Indices in `tests` of the tests of each run; a test without a run counts as a run."""
        runs = dict[Any, list[int]]()
        for number, test in enumerate(self.tests):
            runs.setdefault(test.get("run", number), []).append(number)
        return list(runs.values())

    def judge_draws(self, inputs: Array) -> JudgedTests:
        """Compare draws (n, n_unknown) of all inputs [SI] with the tests, and find likelihoods."""
        shift, variance = self._specimen_scatter
        distances = self._distances(fix_varying(self.unknown, inputs))
        distances = distances._replace(
            values=distances.values + shift, variance=distances.variance + variance
        )
        runs = self._weigh_runs(distances)
        return JudgedTests(distances, runs, runs.log_likelihoods.sum(axis=0) + _LOG_PRIOR)

    def _weigh_runs(self, distances: Distances) -> Runs:
        """Find bounds on each run's deviation from the model, and each run's log likelihood.

        `distances` are those of the tests from the critical velocities of n draws.
        """
        shape = len(self.runs), distances.values.shape[1], len(self.scatters)
        low, high, likelihoods = np.full(shape, -np.inf), np.full(shape, np.inf), np.zeros(shape)
        for run, rows in enumerate(self.runs):
            for row in rows:
                test, by_run = self.tests[row], self.scatters
                if "velocity_scatter" in test:
                    by_run = np.full(len(by_run), test["velocity_scatter"] / test["velocity"])
                deviation = np.sqrt(distances.variance[row, :, None] + by_run**2)
                z = distances.values[row, :, None] / deviation
                if test.get("outcome") != "severe":
                    low[run] = np.maximum(low[run], z)
                if test.get("outcome") != "mild":
                    high[run] = np.minimum(high[run], z)
                if "outcome" not in test:
                    likelihoods[run] -= 0.5 * z**2 + np.log(deviation)
            if any("outcome" in self.tests[row] for row in rows):
                likelihoods[run] += log_between(low[run], high[run])
            # A specimen has one friction, however often measured: average the log likelihoods.
            measured = [row for row in rows if self.tests[row].get("friction") is not None]
            if measured:
                likelihoods[run] += distances.by_rig[measured].mean(axis=0)[:, None]
        return Runs(low, high, likelihoods)

    @functools.cached_property
    def _specimen_scatter(self) -> tuple[Array, Array]:
        """Mean and variance of each test's shift, which is due to differences between specimens.

        The shift is the change of a test's distance from the critical velocity, in ln(velocity), if
        inputs that vary between specimens depart from their medians. Both arrays are (n_test, 1),
        or (1, 1) if no input varies.
        """
        if not any(one.varies for one in self.unknown):
            return np.zeros((1, 1)), np.zeros((1, 1))
        inputs = prior(self.unknown, self.ensemble.design.seed, _VARIED).inputs
        fixed = fix_varying(self.unknown, inputs)
        apart = self._distances(inputs).values - self._distances(fixed).values
        return apart.mean(axis=1)[:, None], apart.var(axis=1)[:, None]

    def _distances(self, inputs: Array) -> Distances:
        """Distance in ln(velocity) of each test from the critical velocity of each draw.

        The arrays of the result are (n_test, n). `inputs` (n, n_all) has the unknown inputs of the
        scene [SI], then those of other oils and of the rig.
        """
        truths = JointDraws(
            inputs[:, : len(self.ensemble.unknown)],
            inputs[:, self.rig] if self.rig else None,
            {oil: inputs[:, column] for oil, column in self.oils.items()},
        )
        found = np.empty((4, len(self.tests), len(inputs)))
        for hold, held in self.ensemble.ensembles_by_hold.items():
            holds = [test.get("hold", self.ensemble.hold) for test in self.tests]
            numbers = [number for number, one in enumerate(holds) if one == hold]
            if numbers:
                tests = [self.tests[number] for number in numbers]
                found[:, numbers] = _test_distances(held, tests, truths)
        return Distances(*found)

    def require_near(self, distances: Distances) -> None:
        """Raise an `InputError` if even the best draw is far from the tests.

        `distances` are those of the tests from the critical velocity of each draw.
        """
        scatter = float(self.scatters[-1])
        z = distances.values / np.sqrt(distances.variance + scatter**2)
        for number, test in enumerate(self.tests):
            if "outcome" in test:
                z[number] = np.minimum(SIGNS[test["outcome"]] * z[number], 0.0)
        apart = float(np.sqrt(np.mean(z**2, axis=0).min()))
        if apart > _FAR:
            raise InputError(
                f"hardly any draw agrees with the tests; the best is within {apart * scatter:.0%} "
                "of their velocities; widen the ranges in [unknown], or check the tests"
            )
