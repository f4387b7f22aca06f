"""Unknown inputs, weighed by tests of one sweep or of several that share inputs.

The scatter of measured velocities is inferred with the inputs: one factor, log-normal about 1, on
that which is said. Each test is also judged by all others, so that one that contradicts them is
named.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from typing import Any, NamedTuple

import numpy as np
from scipy.special import logsumexp, ndtr, softmax

from pipeline.sweep.unknown import Unknown, correlations
from pipeline.uncertain.criticism import cut_off, explains, faults
from pipeline.uncertain.ensemble import Ensemble
from pipeline.uncertain.evidence import (
    SIGNS,
    Distances,
    Test,
    distances_of,
    log_likelihoods,
    require_possible,
)
from pipeline.uncertain.inputs import Draws, prior
from pipeline.uncertain.rig import Places, with_rigs
from pipeline.uncertain.tempering import tempered
from tribo import InputError
from tribo.types import Array

SCATTER = 0.05
"""Relative standard deviation of measured velocities, where a scene does not give it."""
OF_LUBRICANT = ("temperature.", "wear.", "friction.", "oil.")
"""Beginnings of the paths of inputs that each sweep has of its own; others are shared."""
_ENOUGH = 400  # draws of equal weight, that tell either end of 90 % to 6 % of the half-width
_FIRST, _TEMPERED = 2**13, 2**11
_HIDDEN = 0.5  # correlation from which two inputs cannot be told apart
_FACTORS = np.exp(np.log(2.0) * np.linspace(-2.0, 2.5, 10))  # on the scatter that is said
_LOG_PRIOR = -0.5 * (np.log(_FACTORS) / math.log(2.0)) ** 2  # of the factors
_CONTRADICTS = 0.02  # probability, by all others, below which a test contradicts them
_FAR = 2.0  # largest standard deviations of a test from the best draw, root mean square


class Judged(NamedTuple):
    """A test, beside what all others and all together say.

    Attributes
    ----------
    test : mapping
        Entries of the test.
    sweep : int
        Number of the sweep that it belongs to.
    critical_velocity : tuple of float
        Critical velocity there that 5, 50 and 95 % stay below, given all tests [m/s].
    probability : float
        Probability of its outcome, or of a transition as far off, given all others.
    is_blamed : bool
        False if the model does not fit the others, either, so that it may be wrong instead.

    Examples
    --------
    >>> test = {"normal_load": 750.0, "velocity": 2.5}
    >>> Judged(test, 0, (1.06, 1.14, 1.22), probability=0.003).contradicts
    True
    """

    test: Test
    sweep: int
    critical_velocity: tuple[float, float, float]
    probability: float
    is_blamed: bool = True

    @property
    def contradicts(self) -> bool:
        """True if the others hardly allow it, and the model fits them."""
        return self.is_blamed and self.probability < _CONTRADICTS


@dataclass(frozen=True, slots=True, eq=False)
class Posterior:
    """Joint distribution of the unknown inputs, given tests.

    Attributes
    ----------
    ensembles : tuple of Ensemble
        Sweeps whose samples it rests on.
    unknown : tuple of Unknown
        Inputs; those that each of several sweeps has of its own have its name before their path.
    columns : tuple of ndarray of int
        Inputs of each sweep, among all.
    prior, draws : Draws
        Values before and after they were weighed.
    judged : tuple of Judged
        Tests, beside what the others say.
    scatter : float
        Relative standard deviation that velocities are said to have.
    inferred_scatter : tuple of float
        That which 5, 50 and 95 % stay below, given the tests.
    faults : tuple of str
        Reasons why the model does not fit the tests, in words.
    cut_off : {"", "above", "below"}
        End at which the inferred scatter is cut off, since no larger or smaller one is considered.
    rigs : tuple of Places or None
        Inputs that are the friction of each sweep's rig, and its scatter between tests.

    Examples
    --------
    >>> import pipeline
    >>> ensemble = pipeline.Ensemble.of(pipeline.open_sweep("results/unknown.zarr"))
    >>> weighed = pipeline.posterior(ensemble)
    >>> len(weighed.judged), any(judged.contradicts for judged in weighed.judged)
    (4, False)
    """

    ensembles: tuple[Ensemble, ...]
    unknown: tuple[Unknown, ...]
    columns: tuple[Any, ...]
    prior: Draws
    draws: Draws
    judged: tuple[Judged, ...]
    scatter: float
    inferred_scatter: tuple[float, float, float]
    faults: tuple[str, ...] = ()
    cut_off: str = ""
    rigs: tuple[Places | None, ...] = ()

    @property
    def fits(self) -> bool:
        """True if nothing speaks against the model; else no test is said to contradict others."""
        return not self.faults

    @property
    def ensemble(self) -> Ensemble:
        """The first sweep."""
        return self.ensembles[0]

    @property
    def evidence(self) -> str:
        """Numbers of measured transitions and of tests, in words."""
        tests = sum("outcome" in judged.test for judged in self.judged)
        transitions = len(self.judged) - tests
        words = [
            f"{number} {name}{'' if number == 1 else 's'}"
            for number, name in ((transitions, "measured transition"), (tests, "test"))
            if number
        ]
        return " and ".join(words) or "0 measured transitions"

    def of_sweep(self, number: int) -> Draws:
        """Draws of the inputs of one sweep."""
        return Draws(self.draws.inputs[:, self.columns[number]], self.draws.weights)

    def summary(self) -> Iterator[dict[str, Any]]:
        """Mean, spread and 90 % interval of each input, before and after [SI].

        Of an input that is one of a list, the probability of each of its values instead.
        """
        for number, quantity in enumerate(self.unknown):
            row: dict[str, Any] = {"path": quantity.path, "unit": quantity.unit}
            for name, draws in (("prior", self.prior), ("posterior", self.draws)):
                column = draws.inputs[:, number]
                if quantity.kind == "list":
                    odds = {f"{v:g}": float(draws.mean(column == v)) for v in quantity.parameters}
                    row[name] = {"probability": odds}
                    continue
                mean = float(draws.mean(column))
                low, _, high = draws.interval(column)
                row[name] = {
                    "mean": mean,
                    "sd": math.sqrt(float(draws.mean((column - mean) ** 2))),
                    "interval": [low, high],
                }
            yield row

    @property
    def correlations(self) -> Array:
        """Correlation of each two inputs, shape (n_unknown, n_unknown)."""
        columns = zip(self.unknown, self.draws.inputs.T, strict=True)
        values = np.stack([np.log(c) if u.is_relative else c for u, c in columns], axis=1)
        covariance = np.cov(values, rowvar=False, aweights=self.draws.weights, ddof=0)
        covariance = np.atleast_2d(covariance)
        spread = np.sqrt(np.diag(covariance))
        correlation: Array = covariance / np.maximum(np.outer(spread, spread), 1e-300)
        return correlation

    def hidden(self) -> Iterator[tuple[str, str, float]]:
        """Pairs of inputs that the tests cannot tell apart, and their correlation.

        Those that the scene correlates itself are not among them.
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
                    "sweep": self.ensembles[judged.sweep].title,
                    "critical_velocity": _by_share(judged.critical_velocity),
                    "probability_by_others": judged.probability,
                    "contradicts_others": judged.contradicts,
                }
                for judged in self.judged
            ],
            "fixed": {one.unknown.path: one.value for sw in self.ensembles for one in sw.fixed},
            "scatter": self.scatter,
            "inferred_scatter": _by_share(self.inferred_scatter),
            "inferred_scatter_cut_off": self.cut_off or None,
            "fits": self.fits,
            "faults": list(self.faults),
            "samples": [len(ensemble.inputs) for ensemble in self.ensembles],
            "draws": len(self.draws.weights),
            "effective_draws": self.draws.effective,
        }


def _by_share(values: tuple[float, float, float]) -> dict[str, float]:
    return dict(zip(("5 %", "50 %", "95 %"), values, strict=True))


def posterior(ensemble: Ensemble | Sequence[Ensemble], scatter: float = SCATTER) -> Posterior:
    """Weigh the unknown inputs by the transitions and tests of the scene.

    Without any, what the scene assumes of them comes back.

    Parameters
    ----------
    ensemble : Ensemble or sequence of Ensemble
        Samples of a sweep; or of several, which share the inputs of body and surface that have the
        same path, and have those of the lubricant (`OF_LUBRICANT`) each of its own.
    scatter : float
        Relative standard deviation that measured velocities are said to have where they do not
        give their own; inferred with the inputs, about this one within a factor of 2.

    Raises
    ------
    InputError
        If a test lies outside its sweep, sweeps differ in the distribution of an input that they
        share, the samples are too few, or no draw comes near to the tests.

    Examples
    --------
    >>> import pipeline
    >>> ensemble = pipeline.Ensemble.of(pipeline.open_sweep("results/unknown.zarr"))
    >>> weighed = pipeline.posterior(ensemble)
    >>> before, after = (row["sd"] for row in list(weighed.summary())[1].values() if "sd" in row)
    >>> after < before
    True
    """
    if not 0 < scatter < 1:
        raise InputError(f"scatter is {scatter:g}; give a share between 0 and 1, such as 0.05")
    ensembles = (ensemble,) if isinstance(ensemble, Ensemble) else tuple(ensemble)
    unknown, columns = _joined(ensembles)
    for one in ensembles:
        require_possible(one)
    tests = [test for one in ensembles for test in one.tests]
    known, (unknown, rigs) = len(unknown), with_rigs(ensembles, unknown, columns)
    scatters, seed = scatter * _FACTORS, ensembles[0].design.seed + 1
    before = prior(unknown, seed, _FIRST)
    if not tests:
        middle = tuple(scatter * 2.0**score for score in (-1.645, 0.0, 1.645))
        return Posterior(ensembles, unknown, columns, before, before, (), scatter, middle)

    def judge(inputs: Array) -> tuple[Distances, Array, Array, Array]:
        """Distances, results of `log_likelihoods`, and the sum of these and of the prior."""
        parts = [
            distances_of(one, one.tests, inputs[:, part], places and places.rig(inputs))
            for one, part, places in zip(ensembles, columns, rigs, strict=True)
        ]
        distances = Distances(*(np.concatenate(part) for part in zip(*parts, strict=True)))
        z, likelihoods = log_likelihoods(tests, distances, scatters)
        return distances, z, likelihoods, likelihoods.sum(axis=0) + _LOG_PRIOR

    distances, z, likelihoods, joint = judge(before.inputs)
    _require_near(tests, distances, float(scatters[-1]))
    draws = Draws(before.inputs, softmax(joint).sum(axis=1))
    if draws.effective < _ENOUGH:
        after = tempered(unknown, lambda x: logsumexp(judge(x)[-1], axis=1), seed, _TEMPERED)
        distances, z, likelihoods, joint = judge(after)
        joint -= logsumexp(joint, axis=1, keepdims=True)  # as draws have equal weights
        draws = Draws(after, np.full(_TEMPERED, 1 / _TEMPERED))
    inferred = _inferred(scatters, softmax(joint))
    wrong = faults(unknown[:known], draws, scatter, inferred)

    def judged() -> Iterator[Judged]:
        sweeps = [number for number, one in enumerate(ensembles) for _ in one.tests]
        rows = zip(tests, sweeps, distances.values, z, likelihoods, strict=True)
        for test, sweep, distance, score, likelihood in rows:
            weights = softmax(joint - likelihood)  # without the test
            others = Draws(draws.inputs, weights.sum(axis=1))
            yield Judged(
                test,
                sweep,
                draws.interval(test["velocity"] * np.exp(-distance)),
                _probability(test, score, weights),
                not wrong
                or explains(unknown[:known], others, scatter, _inferred(scatters, weights)),
            )

    by_others = tuple(judged())
    return Posterior(
        ensembles,
        unknown,
        columns,
        before,
        draws,
        by_others,
        scatter,
        inferred,
        faults=() if any(one.contradicts for one in by_others) else wrong,
        cut_off=cut_off(softmax(joint).sum(axis=0)),
        rigs=rigs,
    )


def _inferred(scatters: Array, weights: Array) -> tuple[float, float, float]:
    """Scatters that 5, 50 and 95 % stay below, by weights of draws and scatters."""
    of_scatter = Draws(scatters[:, None], weights.sum(axis=0))
    low, middle, high = np.exp(of_scatter.interval(np.log(scatters))).tolist()
    return low, middle, high


def _joined(ensembles: Sequence[Ensemble]) -> tuple[tuple[Unknown, ...], tuple[Any, ...]]:
    """Unknown inputs of all sweeps, and those of each among them."""
    inputs: dict[str, Unknown] = {}
    columns = []
    for number, ensemble in enumerate(ensembles, 1):
        names = {
            quantity.path: f"{number}: {quantity.path}"
            if len(ensembles) > 1 and quantity.path.startswith(OF_LUBRICANT)
            else quantity.path
            for quantity in ensemble.unknown
        }
        for quantity in ensemble.unknown:
            named = replace(
                quantity,
                path=names[quantity.path],
                correlated=tuple((names[path], value) for path, value in quantity.correlated),
            )
            same = inputs.setdefault(named.path, named)
            if (same.kind, same.parameters) != (named.kind, named.parameters):
                raise InputError(
                    f"{quantity.path} is shared by the sweeps, which differ in its distribution; "
                    "give the same one in [unknown] of each, and run them again"
                )
        columns.append(np.array([[*inputs].index(name) for name in names.values()], int))
    return tuple(inputs.values()), tuple(columns)


def _probability(test: Test, z: Array, weights: Array) -> float:
    """Probability of a test's outcome, or of a transition as far off, by weights of draws."""
    severe = float(np.sum(weights * ndtr(z)))
    match test.get("outcome"):
        case "severe":
            return severe
        case "mild":
            return 1 - severe
        case _:
            return 2 * min(severe, 1 - severe)


def _require_near(tests: Sequence[Test], distances: Distances, scatter: float) -> None:
    """Raise an `InputError` where even the best draws of the prior are far from the tests."""
    z = distances.values / np.sqrt(distances.variance + scatter**2)
    for number, test in enumerate(tests):
        if "outcome" in test:
            z[number] = np.minimum(SIGNS[test["outcome"]] * z[number], 0.0)
    apart = float(np.sqrt(np.mean(z**2, axis=0).min()))
    if apart > _FAR:
        raise InputError(
            f"hardly any draw agrees with the tests, the best within {apart * scatter:.0%} of "
            "their velocities; widen [unknown], or look at the tests"
        )


def posterior_if_given(
    ensemble: Ensemble, given_measured: bool, scatter: float | None = None
) -> Posterior | None:
    """Inputs weighed by the tests, if they are to count, of which there has to be one then."""
    if not given_measured:
        if scatter is not None:
            raise InputError(
                f"scatter is {scatter:g}, of measured velocities that do not count here; add "
                "--given-measured (in Python given_measured=True), or leave it out"
            )
        return None
    if not ensemble.tests:
        raise InputError(
            "the scene has no measured transition and no test; give it a [[measured]] with load "
            "and velocity, or a [[tested]] with an outcome besides"
        )
    return posterior(ensemble, SCATTER if scatter is None else scatter)
