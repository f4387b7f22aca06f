"""Unknown inputs, weighed by tests of one sweep or of several that share inputs.

The scatter of measured velocities is inferred with the inputs: one factor, log-normal about 1, on
the stated scatter. Where few draws of the prior agree with the tests, draws are moved in steps by
sequential Monte Carlo (Del Moral, Doucet & Jasra, J. R. Stat. Soc. B 68 (2006) 411): weighed by a
power of the likelihood, resampled, and moved by walks of Metropolis in normal scores.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator, Sequence
from dataclasses import replace

import numpy as np
import xarray as xr
from scipy.optimize import brentq
from scipy.special import logsumexp, ndtr, ndtri, softmax

from pipeline.analysis.dataset import GIVEN_MEASURED, judged_values
from pipeline.sweep.unknown import OF_90, Unknown, score_values, sequence
from pipeline.uncertain.ensemble import Ensemble
from pipeline.uncertain.evidence import Joint, JudgedTests
from pipeline.uncertain.inputs import Draws, prior
from pipeline.uncertain.posterior import (
    Judged,
    Posterior,
    cut_off,
    explains,
    faults,
    shown_test,
)
from tribo import InputError
from tribo.types import Array

SCATTER = 0.05
"""Relative standard deviation of measured velocities, where a scene does not give it."""
_ENOUGH = 400  # draws of equal weight, that tell either end of 90 % to 6 % of the half-width
_FIRST, _TEMPERED = 2**13, 2**11


def posterior(
    ensemble: Ensemble | Sequence[Ensemble], scatter: float = SCATTER, discrepancy: bool = False
) -> Posterior:
    """Weigh the unknown inputs by the transitions and tests of the scene.

    Without any, the result is the prior.

    Parameters
    ----------
    ensemble : Ensemble or sequence of Ensemble
        Samples of a sweep; or of several, which share the inputs of body and surface that have the
        same path, and have those of the lubricant each of its own.
    scatter : float
        Relative standard deviation of measured velocities that give none of their own. The scatter
        is inferred with the inputs, about this value within a factor of 2.
    discrepancy : bool
        True to infer also two slopes of the rise that the model does not have, over velocity and
        bulk temperature, and how much likelier they make the tests.

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
    model = Joint.of(ensembles, scatter, discrepancy)
    before = prior(model.unknown, _seed(model), _FIRST)
    if not model.tests:
        middle = tuple(scatter * 2.0**score for score in (-OF_90, 0.0, OF_90))
        return Posterior(
            ensembles, model.unknown, model.columns, before, before, (), scatter, middle
        )
    draws, judgement, evidence = _weighed(model, before)
    inferred = _inferred(model.scatters, softmax(judgement.joint))
    wrong = faults(model.unknown[: model.known], draws, scatter, inferred)
    by_others = tuple(_left_out_judgements(model, draws, judgement, scatter, not wrong))
    wrong = () if any(one.contradicts for one in by_others) else wrong
    gain = None
    if discrepancy:
        plain = Joint.of(ensembles, scatter, discrepancy=False)
        gain = evidence - _weighed(plain, prior(plain.unknown, _seed(plain), _FIRST))[2]
    return Posterior(
        ensembles,
        model.unknown,
        model.columns,
        before,
        replace(
            draws,
            faults=wrong,
            scatters=model.scatters,
            by_scatter=softmax(judgement.joint, axis=1),
        ),
        by_others,
        scatter,
        inferred,
        cut_off=cut_off(softmax(judgement.joint).sum(axis=0)),
        rigs=model.rigs,
        evidence_gain=gain,
    )


def _weighed(model: Joint, before: Draws) -> tuple[Draws, JudgedTests, float]:
    """Draws that the tests leave, the tests beside them, and the logarithm of the evidence."""
    judgement = model.judged(before.inputs)
    model.require_near(judgement.distances)
    draws = Draws(before.inputs, softmax(judgement.joint).sum(axis=1))
    evidence = float(logsumexp(judgement.joint)) - math.log(_FIRST)
    if draws.effective < _ENOUGH:
        after, evidence = tempered(
            model.unknown,
            lambda inputs: logsumexp(model.judged(inputs).joint, axis=1),
            _seed(model),
            _TEMPERED,
        )
        judgement = model.judged(after)
        joint = judgement.joint - logsumexp(judgement.joint, axis=1, keepdims=True)
        judgement = judgement._replace(joint=joint)  # as draws have equal weights
        draws = Draws(after, np.full(_TEMPERED, 1 / _TEMPERED))
    return draws, judgement, evidence


def _left_out_judgements(
    model: Joint, draws: Draws, judgement: JudgedTests, scatter: float, fits: bool
) -> Iterator[Judged]:
    """Each test, beside what all others say."""
    known, (distances, runs, joint) = model.unknown[: model.known], judgement
    for rows, low, high, likelihood in zip(model.runs, *runs, strict=True):
        weights = softmax(joint - likelihood)  # without the run
        others = Draws(draws.inputs, weights.sum(axis=1))
        tests = tuple(model.tests[row] for row in rows)
        shown = rows[shown_test(tests)]
        velocities = model.tests[shown]["velocity"] * np.exp(-distances.values[shown])
        yield Judged(
            tests,
            model.sweeps[shown],
            draws.interval(velocities),
            _probability(low, high, weights),
            fits or explains(known, others, scatter, _inferred(model.scatters, weights)),
        )


def _seed(model: Joint) -> int:
    return model.ensembles[0].design.seed + 1


def _inferred(scatters: Array, weights: Array) -> tuple[float, float, float]:
    """Scatters that 5, 50 and 95 % stay below, by weights of draws and scatters."""
    of_scatter = Draws(scatters[:, None], weights.sum(axis=0))
    low, middle, high = np.exp(of_scatter.interval(np.log(scatters))).tolist()
    return low, middle, high


def _probability(low: Array, high: Array, weights: Array) -> float:
    """Probability of a run's outcome, or of one as far off, by weights of draws and scatters."""
    below, above = float(np.sum(weights * ndtr(high))), float(np.sum(weights * ndtr(-low)))
    is_within = math.isfinite(low.flat[0]) and math.isfinite(high.flat[0])
    return min(1.0, 2 * min(below, above)) if is_within else min(below, above)


def posterior_at(ds: xr.Dataset, ensemble: Ensemble) -> Posterior | None:
    """Inputs weighed by the tests, if `pipeline.at` said that they are to count."""
    scatter = judged_values(ds).get(GIVEN_MEASURED)
    if scatter is None:
        return None
    if not ensemble.tests:
        raise InputError(
            "the scene has no measured transition and no test; give it a [[measured]] with load "
            "and velocity, or a [[tested]] with an outcome besides"
        )
    return posterior(ensemble, scatter or SCATTER)


def basis_of(ensemble: Ensemble, weighed: Posterior | None) -> Iterator[str]:
    """Unknown inputs as answers take them, what fixes others, and whether the model fits."""
    if weighed:
        if weighed.misfit:
            yield f"warning: {weighed.misfit}"
        for path, before, after, within in weighed.in_words():
            yield f"{path}: {after}, 90 % within {within} (before the tests {before})"
    else:
        yield from map(str, ensemble.unknown)
    yield from map(str, ensemble.fixed)


_KEPT = 0.5  # effective share of the draws that a step of the power leaves
_MOVES = 4  # random walks after each step
_STEPS = 60  # of the power, at most


def tempered(
    unknown: Sequence[Unknown],
    log_likelihood: Callable[[Array], Array],
    seed: int,
    count: int,
) -> tuple[Array, float]:
    """Draws of equal weight from prior times likelihood, shape (count, n_unknown) [SI].

    The logarithm of the likelihood is called with draws (n, n_unknown) [SI], and gives (n,). The
    second result is the logarithm of the evidence, the mean of the likelihood over the prior.
    """
    rng = np.random.default_rng(seed)
    scores = ndtri(sequence(seed, count)[:, : len(unknown)])
    likelihood = log_likelihood(score_values(unknown, scores))
    power, evidence = 0.0, 0.0
    for _ in range(_STEPS):
        step = _step(likelihood, 1.0 - power)
        total = float(logsumexp(step * likelihood))
        evidence += total - math.log(count)
        weights = np.exp(step * likelihood - total)
        power += step
        places = (rng.random() + np.arange(count)) / count
        kept = np.searchsorted(np.cumsum(weights), places).clip(max=count - 1)
        scores, likelihood = scores[kept], likelihood[kept]
        covariance = np.atleast_2d(np.cov(scores.T)) + 1e-9 * np.eye(len(unknown))
        walk = 2.38 / np.sqrt(len(unknown)) * np.linalg.cholesky(covariance)
        for _ in range(_MOVES):
            proposed = scores + rng.standard_normal(scores.shape) @ walk.T
            other = log_likelihood(score_values(unknown, proposed))
            gain = power * (other - likelihood)
            gain += 0.5 * np.sum(scores**2 - proposed**2, axis=1)
            taken = np.log(rng.random(count)) < gain
            scores[taken], likelihood[taken] = proposed[taken], other[taken]
        if power >= 1.0:
            break
    return score_values(unknown, scores), evidence


def _step(likelihood: Array, most: float) -> float:
    """Largest step of the power that leaves enough draws of effect."""

    def spare(step: float) -> float:
        log = step * likelihood
        return float(np.exp(2 * logsumexp(log) - logsumexp(2 * log)) / len(log)) - _KEPT

    return most if spare(most) >= 0 else max(brentq(spare, 0.0, most), 1e-6 * most)
