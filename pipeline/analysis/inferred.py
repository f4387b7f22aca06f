"""What tests say of the uncertain inputs of a scene, its critical temperature among them."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, field, replace
from typing import Any

import numpy as np
import pandas as pd
from scipy.special import ndtr

from pipeline.analysis.at import asked_at
from pipeline.analysis.inputs import Effects, effects_of
from pipeline.analysis.likelihood import Belief, condition
from pipeline.analysis.reading import ResultsLike
from pipeline.analysis.results import Results
from pipeline.analysis.tables import frame_of
from pipeline.analysis.tested import Evidence, evidence_of
from pipeline.sweep.conditions import Conditions, known_critical_temperature
from pipeline.sweep.inputs import RISE
from tribo import InputError

_USUAL = 120.0  # K above the bulk, where the search begins without a critical temperature
_SETTLED = 0.1  # K
_MOST_STEPS = 50
_LARGEST = math.log(2.0)  # of a step in ln(critical − bulk)


@dataclass(frozen=True, eq=False)
class Weighed:
    """A case after its tests: conditions with the critical temperature found, and the evidence.

    The critical temperature counts as λ = ln(critical − bulk temperature of the scene). y and its
    change by λ are taken again at the value found, until that moves by less than 0.1 K.
    """

    conditions: Conditions
    evidence: Evidence
    effects: Effects
    way: float  # of the critical temperature from its value before, in standard deviations
    sides: tuple[bool, bool]  # whether some result was mild, and whether some was severe

    @property
    def is_from_tests_alone(self) -> bool:
        """True if nothing is known of the critical temperature before the tests."""
        number = self.effects.critical
        return number is not None and self.effects.inputs[number].spread is None

    @property
    def is_bounded(self) -> bool:
        """False if tests alone give the critical temperature, and bound it from one side only."""
        return not self.is_from_tests_alone or self.sides == (True, True)


def weigh(data: Results, conditions: Conditions, effects: Effects) -> Weighed:
    """Weigh the tests of a scene, with its uncertain inputs.

    Raises
    ------
    InputError
        If the critical temperature is to come from tests alone, and no test has a result.
    """
    number = effects.critical
    if number is None:
        evidence = evidence_of(data, conditions, effects)
        return Weighed(conditions, evidence, effects, 0.0, _sides(evidence))
    bulk, is_alone = effects.bulk, effects.inputs[number].spread is None
    prior = at = math.log(known_critical_temperature(conditions) - bulk)
    for _ in range(_MOST_STEPS):
        found = replace(conditions, critical_temperature=bulk + math.exp(at))
        way = (at - prior) / effects.scale
        evidence = evidence_of(data, found, effects, way)
        sides = _sides(evidence)
        if is_alone and sides != (True, True):
            break
        mean = float(evidence.belief.inputs()[0][number])
        step = prior + effects.scale * mean - at
        step = math.copysign(min(abs(step), _LARGEST), step)
        at += step
        if abs(math.exp(at) - math.exp(at - step)) < _SETTLED:
            break
    if is_alone:
        _require_results(data, evidence)
    evidence = replace(evidence, belief=evidence.belief.moved(way, number))
    return Weighed(found, evidence, effects, way, sides)


@dataclass(frozen=True, slots=True)
class KnownInput:
    """An uncertain input before and after the tests, in words."""

    path: str  #: Its entry.
    before: str  #: Value and standard uncertainty as given.
    after: str  #: Value and standard uncertainty after the tests.
    mean: float  #: Its mean after the tests, in standard deviations from its value before.
    spread: float  #: Its standard deviation after the tests, in standard deviations before.


@dataclass(frozen=True, eq=False)
class Inferred:
    """What tests say of the critical temperature, and of other uncertain inputs.

    The input is λ = ln(critical − bulk temperature of the scene). Its standard deviation about the
    scene's own is 1, or what the scene's uncertainty says.
    """

    temperature: float  #: Critical temperature [K].
    bulk: float  #: Bulk temperature of the scene [K].
    spread: float  #: Standard deviation on another rig, with the model's bias in it [K].
    own_spread: float  #: Standard deviation on this rig, without the bias [K].
    at_least: float | None  #: Where only mild tests bound it: its 5 % quantile [K].
    at_most: float | None  #: Where only severe tests bound it: its 95 % quantile [K].
    inputs: tuple[KnownInput, ...]  #: Each other uncertain input, before and after the tests.
    evidence: Evidence = field(repr=False)  #: Tests at the temperature found.

    @property
    def is_bounded(self) -> bool:
        """True if tests bound the temperature from both sides."""
        return self.at_least is None and self.at_most is None


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

    Raises
    ------
    InputError
        If no test has a result.
    """
    effects = effects_of(data, conditions, infers=True)
    found, number = weigh(data, conditions, effects), effects.critical or 0
    evidence, bulk, scale = found.evidence, effects.bulk, effects.scale
    _require_results(data, evidence)
    exact = replace(data.prior, bias=0.0)
    alone = condition(evidence.results, exact, len(effects.inputs))
    temperature = known_critical_temperature(found.conditions)
    spreads = [
        scale * (temperature - bulk) * float(one.inputs()[1][number])
        for one in (evidence.belief, alone)
    ]
    ends = [
        temperature
        if found.is_bounded
        else bulk + (temperature - bulk) * math.exp(scale * _quantile(evidence.belief, p, number))
        for p in (0.05, 0.95)
    ]
    is_mild, is_severe = found.sides
    return Inferred(
        temperature=temperature,
        bulk=bulk,
        spread=spreads[0],
        own_spread=spreads[1],
        at_least=ends[0] if not (found.is_bounded or is_severe) else None,
        at_most=ends[1] if not (found.is_bounded or is_mild) else None,
        inputs=known_inputs(found),
        evidence=evidence,
    )


def known_inputs(found: Weighed) -> tuple[KnownInput, ...]:
    """Each uncertain input with a standard uncertainty, before and after the tests."""
    means, spreads = found.evidence.belief.inputs()
    rows, effects = [], found.effects
    for number, one in enumerate(effects.inputs):
        if one.spread is None:
            continue
        mean, spread = float(means[number]), float(spreads[number])
        if number == effects.critical:
            mean += found.way
            value = known_critical_temperature(found.conditions)
            width = effects.scale * (value - effects.bulk) * spread
        else:
            width = one.spread * spread
            value = one.value + one.spread * mean
            if not one.is_kelvin:
                value = one.value * math.exp(one.spread * mean)
        if one.path == RISE:
            value = (1 + one.value) * math.exp(one.spread * mean) - 1
        rows.append(KnownInput(one.path, one.words(), one.words(value, width), mean, spread))
    return tuple(rows)


def inputs_frame(inputs: Sequence[KnownInput]) -> pd.DataFrame:
    """Data frame of uncertain inputs, with a row for each."""
    heads = "uncertain input", "before the tests", "after the tests"
    return frame_of(heads, [(one.path, one.before, one.after) for one in inputs])


def _require_results(data: Results, evidence: Evidence) -> None:
    """Raise an `InputError` if no test has a result."""
    if not evidence.results:
        raise InputError(
            f"the scene {data.sweep.name} has no test with a result, from which to find the "
            "critical temperature; give it [[measured]] or [[tested]], and run it"
        )


def _sides(evidence: Evidence) -> tuple[bool, bool]:
    """Whether some result was mild, and whether some was severe."""
    mild = any(result.sign < 0 or math.isfinite(result.width) for result in evidence.results)
    severe = any(result.sign > 0 for result in evidence.results)
    return mild, severe


def _quantile(belief: Belief, share: float, k: int) -> float:
    """Quantile of input k, in its standard deviations from where it is counted."""
    means, spreads = belief.means[:, k], np.sqrt(belief.covariances[:, k, k])
    low, high = -20.0, 20.0
    for _ in range(80):
        middle = (low + high) / 2
        is_below = float(belief.weights @ ndtr((middle - means) / spreads)) < share
        low, high = (middle, high) if is_below else (low, middle)
    return (low + high) / 2
