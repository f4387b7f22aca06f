"""What measurements tell of a target: draws of the inputs, weighed anew by each of many truths.

A measurement has a result of each truth, with an error. A truth that learns it weighs each draw by
its likelihood: of a number that of a normal error, of a result beyond an end, such as a test that
is mild or severe, that of its side. What it then knows of a target is the spread of the draws as
they are weighed. No truth is among the draws that it weighs.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import NamedTuple

import numpy as np
from scipy.special import log_ndtr, ndtr, softmax

from tribo.types import Array

_LEAST = 1e-12  # probability of an outcome


class Observable(NamedTuple):
    """A measurement, with its result by truth, and then by draw."""

    what: str
    values: Array  # (n_truth + n_draw,) true results
    deviation: Array  # likewise: standard deviation of what is measured
    # Ends beyond which only the side is learnt: both are the velocity of a mild or severe test.
    low: float | Array = -math.inf
    high: float | Array = math.inf
    test: dict[str, float] | None = None  # its place
    runs: int = 1  # that it costs


@dataclass(frozen=True, eq=False)
class Knowledge:
    """What each truth has learnt: logarithms of the weights of draws, (n_truth, n_draw)."""

    log_weights: Array

    @classmethod
    def of(cls, truths: Array, draws: Array, weights: Array) -> Knowledge:
        """Present knowledge, of inputs (n_truth, n_unknown) and (n_draw, n_unknown)."""
        is_itself = (truths[:, None] == draws).all(axis=2)
        with np.errstate(divide="ignore"):
            return cls(np.where(is_itself, -np.inf, np.log(weights)))

    @cached_property
    def weights(self) -> Array:
        """Weights of the draws; their sum is 1."""
        return np.asarray(softmax(self.log_weights, axis=1))

    def spread(self, target: Array) -> float:
        """Standard deviation of a target (n_target, n_draw), root mean square."""
        return float(self._spreads(target, np.ones((1, 1, target.shape[1])))[0])

    def expected(self, tests: Sequence[Observable], target: Array) -> Array:
        """Spreads of a target that mild or severe tests are each expected to leave, (n_test,)."""
        first = len(self.log_weights)
        mild = [ndtr((t.values[first:] - t.low) / t.deviation[first:]) for t in tests]
        return self._spreads(target, np.stack(mild)[:, None])

    def spread_given(self, column: Array, target: Array) -> float:
        """Spread of a target that is left once an input (n_draw,), one of a list, is known."""
        parts = np.where(column == np.unique(column)[:, None], 1.0, 0.0)
        return float(self._spreads(target, parts[None])[0])

    def _spreads(self, target: Array, parts: Array) -> Array:
        """Spreads of a target (n_target, n_draw), root mean square, shape (n_case,).

        In each case a truth will learn in which part it is, or in none, given the probabilities
        that a draw is in a part (n_case, n_part, n_draw).
        """
        both = np.concatenate([np.ones_like(target[:1]), target])
        moments = np.tensordot(parts[:, :, None] * both, self.weights, axes=(-1, 1))
        rest = both @ self.weights.T - moments.sum(axis=1)
        moments = np.concatenate([moments, rest[:, None]], axis=1)
        explained = moments[:, :, 1:] ** 2 / np.maximum(moments[:, :, :1], _LEAST)
        squares = float(np.mean(target**2 @ self.weights.T))
        left = squares - explained.sum(axis=1).mean(axis=(1, 2))
        return np.asarray(np.sqrt(np.maximum(left, 0.0)))

    def after(
        self, measurement: Observable, chance: np.random.Generator, scores: Array | None = None
    ) -> Knowledge:
        """What is known after a measurement, whose error is drawn for each truth.

        Normal scores of the error may be given.
        """
        _, values, deviation, low, high, *_ = measurement
        count = len(self.log_weights)
        if scores is None:
            scores = chance.standard_normal(count)
        result = values[:count] + deviation[:count] * scores

        def score(end: float | Array) -> Array:
            return (np.reshape(end, (-1, 1)) - values[count:]) / deviation[count:]

        told = np.where((result < low)[:, None], log_ndtr(score(low)), log_ndtr(-score(high)))
        if (is_number := (result >= low) & (result <= high)).any():
            told[is_number] = -0.5 * score(result[is_number]) ** 2 - np.log(deviation[count:])
        return Knowledge(self.log_weights + told)
