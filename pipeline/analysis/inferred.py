"""What tests say of the critical temperature of the lubricant."""

from __future__ import annotations

import math
from dataclasses import dataclass, field, replace
from typing import Any

import numpy as np

from pipeline.analysis.at import asked_at
from pipeline.analysis.likelihood import condition
from pipeline.analysis.reading import ResultsLike
from pipeline.analysis.results import Results
from pipeline.analysis.tested import Evidence, evidence_of
from pipeline.sweep.conditions import Conditions, known_critical_temperature
from tribo import InputError

_USUAL = 120.0  # K above the bulk, where the search begins without a critical temperature
_WIDE = 1.0  # scale of ln(critical − bulk) before the tests
_SETTLED = 0.1  # K
_TAILS = math.sqrt(2)  # standard deviation of Student's t with 4 degrees, over its scale
_MOST_STEPS = 50
_LARGEST = math.log(2.0)  # of a step in ln(critical − bulk)


@dataclass(frozen=True, eq=False)
class Inferred:
    """What tests say of the critical temperature.

    Of ln(critical − bulk) nothing is known before the tests but a scale of 1.
    """

    temperature: float  #: Critical temperature [K].
    bulk: float  #: Bulk temperature of the scene [K].
    spread: float  #: Standard deviation on another rig, with the model's bias in it [K].
    own_spread: float  #: Standard deviation on this rig, without the bias [K].
    at_least: float | None  #: Where only mild tests bound it: its 5 % quantile [K].
    at_most: float | None  #: Where only severe tests bound it: its 95 % quantile [K].
    evidence: Evidence = field(repr=False)  #: Tests at the temperature found.


@np.errstate(under="ignore")
def infer(ds: ResultsLike, **conditions: Any) -> Inferred:
    """Find the critical temperature of the lubricant from the tests of a scene.

    A shift of all y by a bias and another critical temperature are alike, so it is found as a bias
    with a wide prior, again and again until it no longer moves.

    Parameters
    ----------
    ds : Dataset, path or Results
        A sweep whose tests were computed; of several scenes the first is taken.
    **conditions
        As in `pipeline.at`.

    Returns
    -------
    Inferred

    Raises
    ------
    InputError
        If no test has a result.
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
    """Find the critical temperature from the tests of a scene; see `infer`."""
    bulk, prior = data.stored.conditions.coldest_bulk_temperature, replace(data.prior, bias=_WIDE)
    found = conditions
    for _ in range(_MOST_STEPS):
        evidence = evidence_of(data, found)
        is_mild, is_severe = _sides(data, evidence)
        belief, above = condition(evidence.results, prior), _above(found, bulk)
        mean, spread = belief.bias_moments
        step = math.copysign(min(abs(mean), _LARGEST), -mean)
        if not (is_mild and is_severe) or abs(above * math.expm1(step)) < _SETTLED:
            break
        found = replace(found, critical_temperature=bulk + above * math.exp(step))
    ends = [bulk + above * math.exp(-belief.bias_below(share)) for share in (0.95, 0.05)]
    return Inferred(
        temperature=bulk + above,
        bulk=bulk,
        spread=above * math.hypot(spread, _TAILS * data.prior.bias),
        own_spread=above * spread,
        at_least=None if is_severe else ends[0],
        at_most=None if is_mild else ends[1],
        evidence=evidence,
    )


def _above(conditions: Conditions, bulk: float) -> float:
    return known_critical_temperature(conditions) - bulk


def _sides(data: Results, evidence: Evidence) -> tuple[bool, bool]:
    """Whether some result was mild, and whether some was severe; `InputError` without any."""
    if not evidence.results:
        raise InputError(
            f"the scene {data.sweep.name} has no test with a result, from which to find the "
            "critical temperature; give it [[measured]] or [[tested]], and run it"
        )
    mild = any(result.sign < 0 or math.isfinite(result.width) for result in evidence.results)
    return mild, any(result.sign > 0 for result in evidence.results)
