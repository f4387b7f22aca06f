"""Whether the model fits the tests, before any of them is named as contradicting the others."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from scipy.special import ndtr

from pipeline.sweep.unknown import Unknown
from pipeline.uncertain.inputs import Draws
from tribo.types import Array

_OUTER, _MUCH = 0.03, 0.15  # share of an input's range at either end; of its posterior there
_RANGE = 3.0  # standard deviations about the mean that are the range of a normal input
_CUT_OFF = 0.05  # of the probability at an end of the scatters, beyond which it is cut off there
_EXPLAINED = 1.25  # median scatter over the one said, without a test that explains it


def faults(
    unknown: Sequence[Unknown], draws: Draws, scatter: float, inferred: Sequence[float]
) -> tuple[str, ...]:
    """Reasons why the model does not fit, in words; none if nothing speaks against it.

    Parameters
    ----------
    unknown : sequence of Unknown
        Inputs.
    draws : Draws
        Values that the tests leave.
    scatter : float
        Relative standard deviation that velocities are said to have.
    inferred : sequence of float
        That which 5, 50 and 95 % stay below, given the tests.
    """
    words = []
    if inferred[0] > scatter:
        words.append(
            f"the tests scatter by {100 * inferred[0]:.2g} % at least, and are said to by "
            f"{100 * scatter:g} %"
        )
    for one, column in zip(unknown, draws.inputs.T, strict=False):  # without those of the rig
        if (share := float(draws.mean(_is_outer(one, column)))) > _MUCH:
            words.append(
                f"{one.path} is pressed against the end of what is assumed, with {share:.2f} of "
                "its probability"
            )
    return tuple(words)


def explains(
    unknown: Sequence[Unknown], draws: Draws, scatter: float, inferred: Sequence[float]
) -> bool:
    """True if the model fits as soon as a test is left out; arguments are those without it."""
    pressed = faults(unknown, draws, scatter, (0.0, *inferred[1:]))
    return inferred[1] <= _EXPLAINED * scatter and not pressed


def cut_off(weights: Array) -> str:
    """End at which the scatters that are considered cut off the inferred one; empty if none.

    Examples
    --------
    >>> cut_off(np.array([0.01, 0.29, 0.7])), cut_off(np.array([0.01, 0.98, 0.01]))
    ('above', '')
    """
    if weights[-1] > _CUT_OFF:
        return "above"
    return "below" if weights[0] > _CUT_OFF else ""


def _is_outer(unknown: Unknown, column: Array) -> Array:
    """1 for values in the outer part of the range of an input, or beyond it; 0 for others."""
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
