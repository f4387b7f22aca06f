"""The posterior: unknown inputs weighed by the tests of a sweep.

The scatter of measured velocities is inferred with the inputs, as a log-normal factor on the stated
scatter. Draws of the prior are weighed by the tests. If few of them agree with the tests, new draws
are made near those that do (`pipeline.uncertain.sampler`).
"""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import replace

import numpy as np
from scipy.special import logsumexp, softmax

from pipeline.analysis.dataset import GIVEN_MEASURED
from pipeline.analysis.results import Results
from pipeline.uncertain.ensemble import Ensemble, Samples
from pipeline.uncertain.evidence import FACTOR, Joint, JudgedTests
from pipeline.uncertain.inputs import Draws, prior
from pipeline.uncertain.posterior import Judged, Posterior, explains, faults, shown_test
from pipeline.uncertain.sampler import effective_share, sample
from pipeline.uncertain.unknown import OF_90
from tribo import InputError
from tribo.types import Array

SCATTER = 0.05
"""Default relative standard deviation of measured velocities."""
FALSE_ALARMS = 0.02
"""Accepted share of sound logs in which a run is called an outlier."""
_FARTHEST = 1e6  # largest deviation that is told from infinity, in standard deviations
_ENOUGH = 4000  # effective draws that give a standard deviation to 1 %
_FIRST, _COUNT = 2**13, 2**13  # draws of the prior, and of the posterior


@np.errstate(under="ignore")
def posterior(ensemble: Samples, scatter: float = SCATTER) -> Posterior:
    """Weigh the unknown inputs by the transitions and tests of the scene.

    Without transitions or tests, the result is the prior.

    Parameters
    ----------
    ensemble : Ensemble, Dataset, str or path
        Samples of a sweep, its dataset or the path of its store. Each oil in the tests has its own
        critical temperature, all with the same prior.
    scatter : float
        Relative standard deviation of measured velocities whose scatter is not stated. The scatter
        is inferred together with the inputs; two thirds of its prior are within a factor of 3 of
        this value.

    Raises
    ------
    InputError
        If the scatter is not between 0 and 1, no input is unknown, a test lies outside the sweep,
        tests are of several oils but the critical temperature is known, there are too few samples,
        or no draw agrees with the tests.

    Examples
    --------
    >>> import pipeline
    >>> weighed = pipeline.posterior("results/unknown.zarr")
    >>> before, after = (row["sd"] for row in list(weighed.summary())[1].values() if "sd" in row)
    >>> after < before
    True
    """
    if not 0 < scatter < 1:
        raise InputError(f"scatter is {scatter:g}; give a share between 0 and 1, such as 0.05")
    ensemble = Ensemble.of(ensemble)
    ensemble.require_unknown()
    model = Joint.of(ensemble, scatter)
    before = prior(model.unknown, _seed(model), _FIRST)
    assumed = scatter * FACTOR**-OF_90, scatter, scatter * FACTOR**OF_90
    result = Posterior(ensemble, model.unknown, before, before, (), scatter, assumed)
    if not model.tests:
        return result
    draws, judgement = _weigh_draws(model, before)
    inferred = _scatter_interval(model.scatters, softmax(judgement.joint))
    wrong = faults(ensemble.unknown, draws, scatter, inferred)
    by_others = tuple(_left_out_judgements(model, draws, judgement, scatter, not wrong))
    wrong = () if any(one.contradicts for one in by_others) else wrong
    by_scatter = softmax(judgement.joint, axis=1)
    return replace(
        result,
        draws=replace(draws, faults=wrong, scatters=model.scatters, by_scatter=by_scatter),
        judged=by_others,
        inferred_scatter=inferred,
        rig=model.rig,
        oils=model.oils,
    )


def _weigh_draws(model: Joint, before: Draws) -> tuple[Draws, JudgedTests]:
    """Weigh the draws `before` by the tests, or make new draws if few fit.

    `model` has the inputs and the tests. Returns weighed draws, and the tests compared with them.
    """
    judgement = model.judge_draws(before.inputs)
    model.require_near(judgement.distances)
    inputs, over = before.inputs, np.zeros(len(before.inputs))
    if effective_share(logsumexp(judgement.joint, axis=1)) < _ENOUGH / len(inputs):
        inputs, log_weights = sample(
            model.unknown,
            lambda inputs: logsumexp(model.judge_draws(inputs).joint, axis=1),
            _seed(model),
            _COUNT,
        )
        judgement = model.judge_draws(inputs)
        over = log_weights - logsumexp(judgement.joint, axis=1)
    judgement = judgement._replace(joint=judgement.joint + over[:, None])
    return Draws(inputs, softmax(judgement.joint).sum(axis=1)), judgement


def _left_out_judgements(
    model: Joint, draws: Draws, judgement: JudgedTests, scatter: float, fits: bool
) -> Iterator[Judged]:
    """Yield each run, compared with the prediction from all other runs.

    `judgement` has all tests compared with the `draws`. `scatter` is the assumed relative scatter
    of measured velocities. `fits` is True if the model fits all runs together.
    """
    unknown, (distances, runs, joint) = model.ensemble.unknown, judgement
    limit = -math.expm1(math.log1p(-FALSE_ALARMS) / len(model.runs))
    for rows, low, high, likelihood in zip(model.runs, *runs, strict=True):
        weights = softmax(joint - likelihood)  # given all runs but this one
        others = Draws(draws.inputs, weights.sum(axis=1))
        tests = tuple(model.tests[row] for row in rows)
        shown = rows[shown_test(tests)]
        away = distances.signs[shown] * distances.values[shown]
        velocities = model.tests[shown]["velocity"] * np.exp(-away)
        yield Judged(
            tests,
            draws.interval(velocities),
            _probability(low, high, weights),
            limit,
            fits or explains(unknown, others, scatter, _scatter_interval(model.scatters, weights)),
        )


def _seed(model: Joint) -> int:
    return model.ensemble.design.seed + 1


def _scatter_interval(scatters: Array, weights: Array) -> tuple[float, float, float]:
    """5, 50 and 95 % quantiles of the scatter between runs, a standard deviation of ln(velocity).

    `scatters` (n_scatter,) are its possible values. `weights` (n, n_scatter) has the joint
    probability of each of n draws of the inputs and each possible scatter.
    """
    of_scatter = Draws(scatters[:, None], weights.sum(axis=0))
    low, middle, high = np.exp(of_scatter.interval(np.log(scatters))).tolist()
    return low, middle, high


def _probability(low: Array, high: Array, weights: Array) -> float:
    """Probability (p-value) of a run's result, or of one further from the prediction.

    A run is the tests of one specimen. They show that its deviation from the model lies between
    `low` and `high`, in standard deviations of the scatter between runs. The probability is
    two-sided if both bounds are finite. If one is infinite, only the other can contradict the
    model, and the probability is one-sided. `weights` are joint probabilities. All arrays have the
    shape (n, n_scatter): n draws of the inputs, and n_scatter possible values of the scatter.

    Some runs deviate more than a normal scatter allows. So the deviation is taken as Student's t
    with 4 degrees of freedom and the same standard deviation.
    """
    below, above = (float(np.sum(weights * _student_share(z))) for z in (high, -low))
    is_within = math.isfinite(low.flat[0]) and math.isfinite(high.flat[0])
    return min(1.0, 2 * min(below, above)) if is_within else min(below, above)


def _student_share(z: Array) -> Array:
    """Distribution function of Student's t, 4 degrees of freedom, at `z` standard deviations.

    It is (1 + s)² (2 − s)/4 with s = t/√(4 + t²) and t = √2 z.
    """
    t = math.sqrt(2.0) * np.clip(z, -_FARTHEST, _FARTHEST)
    root = np.sqrt(4.0 + t**2)
    beyond = 4.0 / (root * (root + np.abs(t)))  # 1 − |s|, without rounding
    tail = beyond**2 * (3.0 - beyond) / 4
    return np.asarray(np.where(t < 0, tail, 1.0 - tail))


def posterior_at(data: Results, ensemble: Ensemble) -> Posterior | None:
    """Posterior given the tests of the scene `data`; None unless `pipeline.at` asked for it."""
    scatter = data.judged.get(GIVEN_MEASURED)
    if scatter is None:
        return None
    if not ensemble.tests:
        raise InputError(
            "the scene has no measured transition and no test; give it a [[measured]] with load "
            "and velocity, or a [[tested]] with an outcome, too"
        )
    return posterior(ensemble, scatter or SCATTER)
