"""What would decide an undecided verdict: computing, a better input, or a test.

The verdict is judged without the error that a remedy removes. The first remedy is proposed that
makes the verdict definite: computing, which costs least, then a better input, then a test.
"""

from __future__ import annotations

import itertools
from collections.abc import Iterable
from dataclasses import replace
from enum import IntFlag

import numpy as np

from pipeline.answers.condition_values import QueryPoints
from pipeline.answers.error import (
    INTERPOLATION,
    POSITIONS,
    PRESET,
    SURFACE,
    WARNINGS,
    finer_preset_error,
)
from pipeline.answers.evidence import prior_of
from pipeline.answers.verdict_model import MILD, SEVERE, Rises, VerdictModel
from pipeline.constants import RISE_EXPONENT, VERDICT_PROBABILITIES
from tribo.types import Array, Indices, Mask


class Remedy(IntFlag):
    """Remedies for an undecided verdict; several are needed together."""

    POINTS = 1  # simulate more points nearby
    WARNINGS = 2  # follow the warnings of the points nearby
    REALIZATIONS = 4  # simulate more surface realizations
    PRESET = 8  # use a finer preset
    TEST = 16  # run a test at this point
    INPUT = 32  # measure the input that contributes most to the uncertainty of the rise


_PARTS = {
    Remedy.POINTS: [INTERPOLATION],
    Remedy.WARNINGS: [WARNINGS],
    Remedy.REALIZATIONS: [SURFACE, POSITIONS],
    Remedy.PRESET: [PRESET],
}
"""Parts of the numerical error that each remedy by computing removes, the cheapest first.

A finer preset leaves its own error.
"""


def remedies(model: VerdictModel, points: QueryPoints) -> Indices:
    """Sums of `Remedy` codes (k,) that would decide the verdicts on undecided points."""
    rises = model.rises(points)
    codes = np.zeros(points.load.shape, np.int16)
    is_computable = _is_decided_without(model, points, rises, [*_PARTS])
    numbers = range(1, len(_PARTS) + 1)
    for combination in itertools.chain(*(itertools.combinations(_PARTS, n) for n in numbers)):
        rest = np.flatnonzero(is_computable & (codes == 0))
        rest_points = points.take(rest), rises.take(rest)
        is_decided = _is_decided_without(model, *rest_points, combination)
        codes[rest[is_decided]] = sum(combination)
    if known := _with_known_input(model):
        is_decided = np.isin(known.judge(points, rises).verdict, (MILD, SEVERE))
        codes[is_decided & (codes == 0)] = Remedy.INPUT
    judgement = model.judge(points, rises)
    is_within_error = ~(abs(judgement.log_ratio) > np.log1p(judgement.error))
    low, _, high = judgement.probabilities
    is_at_verdict = (low <= VERDICT_PROBABILITIES[0]) | (high >= VERDICT_PROBABILITIES[-1])
    test = Remedy.TEST | np.where(is_within_error & is_at_verdict, _largest(rises.errors), 0)
    return np.where(codes == 0, test, codes).astype(np.int16)


def _with_known_input(model: VerdictModel) -> VerdictModel | None:
    """The model without the uncertainty of the input that contributes most; None without any."""
    evidence, base = model.evidence, model.case.sweep.base
    if evidence.inputs is None or evidence.critical is not None:
        return None
    inputs = evidence.inputs.without_largest
    known = replace(evidence, inputs=inputs, prior=prior_of(base, inputs))
    return replace(model, evidence=known)


def _is_decided_without(
    model: VerdictModel, points: QueryPoints, rises: Rises, removed: Iterable[Remedy]
) -> Mask:
    """True at points (k,) whose verdict is definite once remedies have `removed` errors."""
    errors = rises.errors.copy()
    for remedy in removed:
        left = finer_preset_error(model.case.sweep) if remedy == Remedy.PRESET else 0.0
        errors[_PARTS[remedy]] = RISE_EXPONENT * left
    verdicts = model.judge(points, rises._replace(errors=errors)).verdict
    return np.isin(verdicts, (MILD, SEVERE))


def _largest(errors: Array) -> Indices:
    """Code (k,) of the remedy for the largest, or unknown, part of `errors` (5, k)."""
    squares = np.nan_to_num(np.square(errors), nan=np.inf)
    removed = np.stack([squares[parts].sum(axis=0) for parts in _PARTS.values()])
    return np.asarray(np.array([*map(int, _PARTS)])[removed.argmax(axis=0)])
