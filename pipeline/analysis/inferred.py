"""The critical temperature as an uncertain input, found from the tests of a scene."""

from __future__ import annotations

import math
from dataclasses import dataclass, field, replace
from typing import Any

import numpy as np
from scipy.special import ndtr

from pipeline.analysis.at import asked_at
from pipeline.analysis.likelihood import Belief, Prior, condition
from pipeline.analysis.results import Results, ResultsLike
from pipeline.analysis.tested import Evidence, evidence_of
from pipeline.sweep.conditions import Conditions, known_critical_temperature
from pipeline.sweep.shown import shown
from tribo import InputError

_USUAL = 120.0  # K above the bulk, where the search begins without a critical temperature
_SETTLED = 0.1  # K
_MOST_STEPS = 50
_LARGEST = math.log(2.0)  # of a step in ln(critical − bulk)


@shown
@dataclass(frozen=True, eq=False)
class Inferred:
    """What tests say of the critical temperature.

    The input is λ = ln(critical − bulk temperature of the scene), of standard deviation 1 about the
    scene's own.
    """

    temperature: float  #: Critical temperature [K].
    bulk: float  #: Bulk temperature of the scene [K].
    spread: float  #: Standard deviation on another rig, with the model's bias in it [K].
    own_spread: float  #: Standard deviation on this rig, without the bias [K].
    at_least: float | None  #: Where only mild tests bound it: its 5 % quantile [K].
    at_most: float | None  #: Where only severe tests bound it: its 95 % quantile [K].
    evidence: Evidence = field(repr=False)  #: Tests at the temperature found.

    @property
    def is_bounded(self) -> bool:
        """True if tests bound the temperature from both sides."""
        return self.at_least is None and self.at_most is None

    def effect(self, conditions: Conditions) -> float:
        """Change of y for one standard deviation of λ, under a place's own bulk temperature."""
        return _effect(self.temperature, self.bulk, conditions)


def _effect(critical: float, bulk: float, conditions: Conditions) -> float:
    return -(critical - bulk) / (critical - conditions.coldest_bulk_temperature)


@np.errstate(under="ignore")
def infer(ds: ResultsLike, **conditions: Any) -> Inferred:
    """Find the critical temperature of the lubricant from the tests of a scene.

    Parameters
    ----------
    ds : Dataset, str or path
        Dataset of `pipeline.open_sweep` or `pipeline.at`, or path or URL of the store, whose tests
        are done.
    **conditions
        Conditions to judge by, as in `pipeline.at`. A critical temperature is where the search
        begins.

    Returns
    -------
    Inferred
        The temperature, its spread with and without the model's bias, and the tests. If the tests
        bound it from one side only, ``at_least`` or ``at_most`` has the bound.

    Raises
    ------
    InputError
        If no test has a result.

    Examples
    --------
    >>> import pipeline
    >>> found = pipeline.infer("results/first_try.zarr")
    >>> round(found.temperature - 273.15), found.is_bounded
    (140, True)
    """
    data = asked_at(ds, conditions)
    if data.entry_dims:
        data = next(data.scenes)
    judged = data.plain_conditions
    if judged.critical_temperature is None:
        judged = replace(judged, critical_temperature=judged.bulk_temperature + _USUAL)
    else:
        judged = data.conditions
    return infer_critical_temperature(data, judged)


def infer_critical_temperature(data: Results, conditions: Conditions) -> Inferred:
    """Find the critical temperature from the tests of a scene.

    y and its change by λ are taken again at the value found, until that moves by less than 0.1 K.

    Raises
    ------
    InputError
        If no test has a result.
    """
    bulk = data.stored.conditions.coldest_bulk_temperature
    prior = math.log(known_critical_temperature(conditions) - bulk)
    at = prior
    for _ in range(_MOST_STEPS):
        critical = bulk + math.exp(at)
        evidence, belief = _conditioned(data, conditions, critical, bulk, at - prior, data.prior)
        sides = _sides(evidence)
        if sides != (True, True):
            break
        step = prior + float(belief.inputs()[0][0]) - at
        step = math.copysign(min(abs(step), _LARGEST), step)
        at += step
        if abs(math.exp(at) - math.exp(at - step)) < _SETTLED:
            break
    if not evidence.results:
        raise InputError(
            f"the scene {data.sweep.name} has no test with a result, from which to find the "
            "critical temperature; give it [[measured]] or [[tested]], and run it"
        )
    _, alone = _conditioned(
        data, conditions, critical, bulk, at - prior, replace(data.prior, bias=0.0)
    )
    scale = math.exp(at)
    spreads = (scale * float(one.inputs()[1][0]) for one in (belief, alone))
    is_mild, is_severe = sides
    temperature = bulk + math.exp(prior + float(belief.inputs()[0][0]))
    return Inferred(
        temperature=temperature if is_mild and is_severe else bulk + math.exp(prior),
        bulk=bulk,
        spread=next(spreads),
        own_spread=next(spreads),
        at_least=bulk + math.exp(prior + _quantile(belief, 0.05)) if not is_severe else None,
        at_most=bulk + math.exp(prior + _quantile(belief, 0.95)) if not is_mild else None,
        evidence=replace(evidence, belief=belief.moved(at - prior)),
    )


def _sides(evidence: Evidence) -> tuple[bool, bool]:
    """Whether some result was mild, and whether some was severe."""
    mild = any(result.sign < 0 or math.isfinite(result.width) for result in evidence.results)
    severe = any(result.sign > 0 for result in evidence.results)
    return mild, severe


def _conditioned(
    data: Results, conditions: Conditions, critical: float, bulk: float, way: float, prior: Prior
) -> tuple[Evidence, Belief]:
    """Evidence at a critical temperature [K], with λ as an input that is `way` from its prior."""
    evidence = evidence_of(data, replace(conditions, critical_temperature=critical))
    results = []
    for result, rows in zip(evidence.results, evidence.members, strict=True):
        own = rows[0].conditions
        assert own is not None  # a test without conditions has no result
        effect = _effect(critical, bulk, own)
        results.append(replace(result, y=result.y - effect * way, a=(effect,)))
    held = replace(evidence, results=tuple(results))
    return held, condition(held.results, prior, 1)


def _quantile(belief: Belief, share: float) -> float:
    """Quantile of the first input, in its standard deviations from the prior."""
    means, spreads = belief.means[:, 0], np.sqrt(belief.covariances[:, 0, 0])
    low, high = -20.0, 20.0
    for _ in range(80):
        middle = (low + high) / 2
        is_below = float(belief.weights @ ndtr((middle - means) / spreads)) < share
        low, high = (middle, high) if is_below else (low, middle)
    return (low + high) / 2
