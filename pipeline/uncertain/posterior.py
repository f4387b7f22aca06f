"""The posterior of the unknown inputs, each run judged by all other runs, and oils compared."""

from __future__ import annotations

import itertools
import math
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any, ClassVar, NamedTuple

import numpy as np
from scipy.special import ndtr

from pipeline.quantities import display, shown_in
from pipeline.sweep.measurement import oils_of
from pipeline.sweep.shown import shown
from pipeline.uncertain.answers import draws_of, log_boundary
from pipeline.uncertain.ensemble import Ensemble
from pipeline.uncertain.evidence import Test
from pipeline.uncertain.inputs import CRITICAL, Draws
from pipeline.uncertain.unknown import Unknown, correlations
from tribo.types import Array

_HIDDEN = 0.5  # correlation above which tests cannot tell two inputs apart


def shown_test(tests: Sequence[Test]) -> int:
    """Index of the test that represents a run of tests.

    It is the severe test, or measured transition, with the least load × velocity. If all tests are
    mild, it is the one with the greatest load × velocity.
    """

    def severity(number: int) -> tuple[bool, float]:
        is_mild = tests[number].get("outcome") == "mild"
        power = tests[number]["normal_load"] * tests[number]["velocity"]
        return is_mild, -power if is_mild else power

    return min(range(len(tests)), key=severity)


class Judged(NamedTuple):
    """A run of tests, compared with predictions from all other runs, and from all runs.

    `critical_velocity` has the 5, 50 and 95 % quantiles given all tests [m/s]. `probability` is
    that of the outcome given all other runs.
    """

    tests: tuple[Test, ...]
    #: 5, 50 and 95 % quantiles of the critical velocity at the run's test, given all tests [m/s].
    critical_velocity: tuple[float, float, float]
    #: Probability of this outcome, or of a transition at least as far off, given all other runs.
    probability: float
    limit: float  #: Probability below which the run contradicts the other runs.
    is_blamed: bool = True  #: True if the model fits the other runs, so that this run is wrong.

    @property
    def test(self) -> Test:
        """Test that stands for the run: severe test or transition of least load × velocity, if any.

        In a run of mild tests only, it is the mild test of greatest load × velocity.
        """
        return self.tests[shown_test(self.tests)]

    @property
    def last_mild(self) -> Test | None:
        """Mild test of greatest load × velocity in a run that turned severe; None without one."""
        mild = [test for test in self.tests if test.get("outcome") == "mild"]
        return mild[shown_test(mild)] if mild and self.test["outcome"] == "severe" else None

    @property
    def outcome(self) -> str:
        """Outcome of the run in words, such as "severe, mild up to 400 N"."""
        found = str(self.test.get("outcome", "transition"))
        if self.last_mild is None:
            return found
        load, velocity = self.last_mild["normal_load"], self.last_mild["velocity"]
        is_load = velocity == self.test["velocity"]
        return f"{found}, mild up to {f'{load:g} N' if is_load else f'{velocity:g} m/s'}"

    @property
    def contradicts(self) -> bool:
        """True if the model fits the other runs, but makes the outcome of this run improbable."""
        return self.is_blamed and self.probability < self.limit


@shown
@dataclass(frozen=True, eq=False)
class Posterior:
    """Joint distribution of the unknown inputs, given the tests."""

    drawn_by: ClassVar = "pipeline.uncertain.figures:draw_posterior"
    ensemble: Ensemble  #: Samples of the sweep, with their emulator.
    #: Inputs of the sweep, then the critical temperatures of other oils, then inputs of the rig.
    unknown: tuple[Unknown, ...]
    prior: Draws  #: Draws before the tests.
    draws: Draws  #: Draws given the tests.
    judged: tuple[Judged, ...]  #: Runs, each compared with all other runs.
    scatter: float  #: Relative standard deviation of measured velocities, as stated.
    #: 5, 50 and 95 % quantiles of the scatter, given the tests.
    inferred_scatter: tuple[float, float, float]
    #: Columns of the rig's friction and of its scatter between tests; empty if not inferred.
    rig: tuple[int, ...] = ()
    #: Columns of the critical temperatures of oils other than the first, by the oil's label.
    oils: Mapping[str, int] = field(default_factory=dict)

    @property
    def fits(self) -> bool:
        """True if the tests as a whole agree with the model; if not, `draws.faults` says why."""
        return not self.draws.faults

    @property
    def rig_scatter(self) -> Array | float:
        """Standard deviation of ln(friction) between tests of the rig, for each draw (n,).

        It is 0 if it was not inferred from the tests.
        """
        return self.draws.inputs[:, self.rig[1]] if self.rig else 0.0

    @property
    def evidence(self) -> str:
        """Counts of measured transitions, runs and tests in words, such as "3 runs and 1 test"."""
        tests = sum("outcome" in judged.test for judged in self.judged)
        runs = sum("run" in judged.test for judged in self.judged)
        numbers = {
            "measured transition": len(self.judged) - tests, "run": runs, "test": tests - runs,
        }  # fmt: skip
        words = [f"{n} {name}{'' if n == 1 else 's'}" for name, n in numbers.items() if n]
        return " and ".join(words) or "0 measured transitions"

    def summary(self) -> Iterator[dict[str, Any]]:
        """Yield mean, standard deviation and 90 % interval of inputs [SI], before and after tests.

        For an input with a list of values, the probability of each value is yielded instead.
        """
        for number, quantity in enumerate(self.unknown):
            row: dict[str, Any] = {"path": quantity.path, "unit": quantity.unit}
            for name, draws in (("prior", self.prior), ("posterior", self.draws)):
                column = draws.inputs[:, number]
                if quantity.kind == "list":
                    odds = {f"{v:g}": float(draws.mean(column == v)) for v in quantity.parameters}
                    row[name] = {"probability": odds}
                    continue
                low, _, high = draws.interval(column)
                mean, sd = float(draws.mean(column)), draws.spread(column)
                row[name] = {"mean": mean, "sd": sd, "interval": [low, high]}
            yield row

    @property
    def draws_words(self) -> str:
        """Effective sample size and number of draws, in words."""
        return f"  effective sample size {self.draws.effective:.0f} of {len(self.draws.weights)}"

    @property
    def scatter_words(self) -> str:
        """Scatter of measured velocities in words, as stated and as inferred."""
        low, middle, high = (100 * value for value in self.inferred_scatter)
        said = f"scatter of the velocities as stated: {100 * self.scatter:g} %"
        if not self.judged:
            return said
        return f"{said}, by the tests: {middle:.2g} % ({low:.2g} to {high:.2g})"

    def in_words(self) -> Iterator[tuple[str, ...]]:
        """Yield a table row for each input: path, mean ± sd before and after tests, 90 % interval.

        For an input with a list of values, the likeliest value is shown instead.
        """
        for row, unknown in zip(self.summary(), self.unknown, strict=True):
            after, spread = row["posterior"], unknown.spread
            if unknown.kind == "list":
                odds = after["probability"]
                best = max(odds, key=odds.__getitem__)
                said = f"{unknown.text(float(best))} likeliest, {odds[best]:.2f}"
                yield unknown.path, f"one of {len(odds)}", said, ""
                continue
            moments = [
                f"{unknown.text(of['mean'], 4)} ± {display(of['sd'], spread, 3).rstrip()}"
                for of in (row["prior"], after)
            ]
            low, high = after["interval"]
            within = f"{shown_in(low, unknown.shown):.4g} to {unknown.text(high, 4)}"
            yield unknown.path, *moments, within

    @property
    def correlations(self) -> Array:
        """Correlations of the inputs given the tests, shape (n_unknown, n_unknown).

        Logarithms are correlated for inputs whose ratios matter, such as log-normal ones.
        """
        columns = zip(self.unknown, self.draws.inputs.T, strict=True)
        values = np.stack([np.log(c) if u.is_relative else c for u, c in columns], axis=1)
        covariance = np.cov(values, rowvar=False, aweights=self.draws.weights, ddof=0)
        covariance = np.atleast_2d(covariance)
        spread = np.sqrt(np.diag(covariance))
        correlation: Array = covariance / np.maximum(np.outer(spread, spread), 1e-300)
        return correlation

    def hidden(self) -> Iterator[tuple[str, str, float]]:
        """Yield pairs of inputs of which the tests show only a combination, and their correlation.

        Pairs that the scene itself correlates are left out.
        """
        correlation, assumed = self.correlations, correlations(self.unknown)
        paths = [quantity.path for quantity in self.unknown]
        for i, j in zip(*np.triu_indices(len(paths), 1), strict=True):
            if abs(correlation[i, j]) >= _HIDDEN and assumed[i, j] == 0:
                yield paths[i], paths[j], float(correlation[i, j])

    def as_dict(self) -> dict[str, Any]:
        """Return all results as plain data."""
        return {
            "inputs": list(self.summary()),
            "correlations": self.correlations.tolist(),
            "hidden": [{"inputs": [a, b], "correlation": c} for a, b, c in self.hidden()],
            "tests": [
                dict(judged.test)
                | {
                    "mild_before": judged.last_mild and dict(judged.last_mild),
                    "critical_velocity": _share_values(judged.critical_velocity),
                    "probability_by_others": judged.probability,
                    "contradicts_others": judged.contradicts,
                }
                for judged in self.judged
            ],
            "fixed": {one.unknown.path: one.value for one in self.ensemble.fixed},
            "scatter": self.scatter,
            "inferred_scatter": _share_values(self.inferred_scatter),
            "fits": self.fits,
            "faults": list(self.draws.faults),
            "samples": len(self.ensemble.inputs),
            "draws": len(self.draws.weights),
            "effective_draws": self.draws.effective,
        }


def _share_values(values: tuple[float, float, float]) -> dict[str, float]:
    return dict(zip(("5 %", "50 %", "95 %"), values, strict=True))


_OUTER, _MUCH = 0.03, 0.15  # share of the range at each end; tolerated probability there
_RANGE = 3.0  # half range of a normal input, in standard deviations
_EXPLAINED = 1.25  # if leaving out a run lowers the scatter to this × stated, the run is to blame


def faults(
    unknown: Sequence[Unknown], draws: Draws, scatter: float, inferred: Sequence[float]
) -> tuple[str, ...]:
    """Reasons in words why the model does not fit the tests; empty if the model fits.

    `draws` are those of the posterior, `scatter` is the assumed relative scatter of velocities, and
    `inferred` has the 5, 50 and 95 % quantiles of the scatter.
    """
    words = []
    if inferred[0] > scatter:
        words.append(
            f"the tests scatter by at least {100 * inferred[0]:.3g} %, and "
            f"{100 * scatter:g} % is stated"
        )
    for one, column in zip(unknown, draws.inputs.T, strict=False):  # the rig's columns come last
        if (share := float(draws.mean(_is_near_ends(one, column)))) > _MUCH:
            words.append(f"{one.path} has {share:.2f} of its probability at the ends of its range")
    return tuple(words)


def explains(
    unknown: Sequence[Unknown], draws: Draws, scatter: float, inferred: Sequence[float]
) -> bool:
    """True if the model fits the tests without one run, so that this run is to blame for a misfit.

    `draws` are those of the posterior without that run. `scatter` is the assumed relative scatter
    of velocities, and `inferred` has the 5, 50 and 95 % quantiles of the scatter without that run.
    """
    at_ends = faults(unknown, draws, scatter, (0.0, *inferred[1:]))
    return inferred[1] <= _EXPLAINED * scatter and not at_ends


def _is_near_ends(unknown: Unknown, column: Array) -> Array:
    """1 for each value of `column` near or beyond the ends of the input's range, else 0 (n,)."""
    if unknown.kind == "list":
        return np.zeros(len(column))
    if unknown.kind == "uniform":
        low, high = unknown.parameters
    else:
        low, high = unknown.quantile(ndtr(np.array([-_RANGE, _RANGE])))
    if unknown.is_relative:
        column, low, high = np.log(column), np.log(low), np.log(high)
    part = _OUTER * (high - low)
    return np.where((column < low + part) | (column > high - part), 1.0, 0.0)


class Contrast(NamedTuple):
    """Difference of a quantity between two oils: the second minus the first."""

    oils: tuple[str, str]
    what: str  # name of the quantity
    unit: str  # K; or 1 for the difference of ln(velocity)
    mean: float  # of the difference
    sd: float  # its standard deviation
    interval: tuple[float, float, float]  # 5, 50 and 95 % quantiles
    probability: float  # probability that the second oil has the larger value


def contrasts(posterior: Posterior) -> Iterator[Contrast]:
    """Yield two differences for each pair of oils in the tests.

    The first is the difference in critical temperature [K], the second that in ln(critical
    velocity) at the geometric mean of the sweep's lowest and highest load. Nothing is yielded if
    the tests are of one oil.
    """
    ensemble, draws = posterior.ensemble, posterior.draws
    inputs = draws_of(ensemble, draws).inputs
    own = oils_of(test.get("oil") for test in ensemble.tests)[:1]
    if not posterior.oils:
        return
    column = [one.path for one in ensemble.unknown].index(CRITICAL)
    load = math.sqrt(float(ensemble.loads[0] * ensemble.loads[-1]))
    by_oil = dict[str, tuple[Array, Array]]()
    for oil, place in {own[0] or "the scene's oil": column, **posterior.oils}.items():
        of_oil = inputs.copy()
        of_oil[:, column] = draws.inputs[:, place]
        by_oil[oil] = of_oil[:, column], log_boundary(ensemble, of_oil, [load])[0][:, 0]
    for first, second in itertools.combinations(by_oil, 2):
        parts = (("critical temperature", "K"), (f"critical velocity at {load:.3g} N", "1"))
        for k, (what, unit) in enumerate(parts):
            values = by_oil[second][k] - by_oil[first][k]
            more = float(draws.mean(np.where(values > 0, 1.0, 0.0)))
            moments = float(draws.mean(values)), draws.spread(values)
            yield Contrast((first, second), what, unit, *moments, draws.interval(values), more)
