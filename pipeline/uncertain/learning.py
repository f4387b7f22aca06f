"""What measurements tell of the unknown inputs: a Kalman filter for each of many truths.

Knowledge of the inputs is a Gaussian with the covariance of the present draws. About
each truth the result of a measurement is linear in the inputs, with slopes that are taken there. A
measured number updates it by a Kalman filter. Of a result beyond an end, such as a test that is
mild or severe, only the side is known: mean and variance are those of a truncated Gaussian (assumed
density; Minka, Expectation propagation, UAI 2001).
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any, NamedTuple

import numpy as np
from scipy.special import log_ndtr, ndtr

from pipeline.sweep.unknown import Unknown
from pipeline.uncertain.inputs import Draws
from tribo.types import Array

_STEP = 0.25  # share of the spread of an input over which slopes are taken
_LEAST = 1e-300  # least spread
_OUTERMOST = 12.0  # normal score, beyond which no result lies
_LOG_ROOT = 0.5 * math.log(2 * math.pi)


class Features:
    """Truths among the inputs, and coordinates in which draws of them have a spread of about 1.

    Inputs have the logarithm of their distance from an origin, of which boundaries are powers: so
    they stay linear along inputs that tests cannot tell apart. Those that lie on both sides of it
    have their values. A list has one for each value: 1/√p where it is the one, and 0 elsewhere, if
    it has the probability p.
    """

    def __init__(
        self, unknown: Sequence[Unknown], draws: Draws, truths: Array, origins: Mapping[str, float]
    ) -> None:
        self.truths = truths
        self._unknown = tuple(unknown)
        least = draws.inputs.min(axis=0).tolist()
        found = [origins.get(one.path, 0.0) for one in unknown]
        self._origins = [o if low > o else None for low, o in zip(least, found, strict=True)]
        self._spreads = [
            _spread(one, draws, draws.inputs[:, i], self._origins[i])
            for i, one in enumerate(unknown)
        ]
        of_draws = self._coordinates(draws.inputs)
        self.mean = draws.mean(of_draws)
        away = of_draws - self.mean
        self.covariance: Array = (draws.weights * away.T) @ away
        self.of_truths = self._coordinates(truths)

    def _coordinates(self, inputs: Array) -> Array:
        """Coordinates of inputs (n, n_unknown), shape (n, n_feature)."""
        columns = []
        rows = zip(self._unknown, inputs.T, self._spreads, self._origins, strict=True)
        for one, column, spread, origin in rows:
            if one.kind == "list":
                pairs = zip(one.parameters, spread, strict=True)
                columns += [np.where(column == value, 1 / width, 0.0) for value, width in pairs]
            else:
                columns.append(_coordinate(column, origin) / spread)
        return np.stack(columns, axis=1)

    def numbers(self, number: int) -> slice:
        """Coordinates of an input."""
        sizes = [len(one.parameters) if one.kind == "list" else 1 for one in self._unknown]
        begin = sum(sizes[:number])
        return slice(begin, begin + sizes[number])

    def input_slopes(self, number: int) -> Array:
        """Slopes of an input, or its logarithm if relative, by coordinates (n, n_feature)."""
        slopes, origin = np.zeros_like(self.of_truths), self._origins[number]
        away = np.ones(len(self.truths))
        if origin is not None and not self._unknown[number].is_relative:
            away = self.truths[:, number] - origin
        slopes[:, self.numbers(number).start] = self._spreads[number] * away
        return slopes

    def slopes(self, function: Callable[[Array], Array]) -> tuple[Array, Array]:
        """Outputs (m, n) at the truths, and their slopes by the coordinates, (m, n, n_feature)."""
        shifted, widths = [self.truths], []
        for number, (one, spread) in enumerate(zip(self._unknown, self._spreads, strict=True)):
            column = self.truths[:, number]
            if one.kind == "list":
                for value, width in zip(one.parameters, spread, strict=True):
                    of_value = np.full_like(column, value)
                    shifted.append(_replaced_column(self.truths, number, of_value))
                    widths.append(np.full_like(column, 1 / width))
                continue
            place = self.numbers(number).start
            # Towards the mean, so that no truth is led beyond what is possible.
            step = -_STEP * np.where(self.of_truths[:, place] > self.mean[place], 1.0, -1.0)
            by = step * spread
            origin = self._origins[number]
            moved = column + by if origin is None else origin + (column - origin) * np.exp(by)
            shifted.append(_replaced_column(self.truths, number, moved))
            widths.append(step)
        outputs = np.stack([function(inputs) for inputs in shifted], axis=-1)
        return outputs[..., 0], (outputs[..., 1:] - outputs[..., :1]) / np.stack(widths, axis=-1)


def _coordinate(column: Array, origin: float | None) -> Array:
    return column if origin is None else np.log(column - origin)


def _spread(one: Unknown, draws: Draws, column: Array, origin: float | None) -> Any:
    """Spread of an input; of a list the root of the probability of each value."""
    if one.kind == "list":
        shares = [draws.mean(column == value) for value in one.parameters]
        return np.sqrt(np.maximum(shares, 1e-12))
    return max(draws.spread(_coordinate(column, origin)), _LEAST)


def _replaced_column(inputs: Array, number: int, column: Array) -> Array:
    other = inputs.copy()
    other[:, number] = column
    return other


class Observable(NamedTuple):
    """A measurement, with the result that it has of each truth."""

    what: str
    values: Array  # (n,) true results
    slopes: Array  # (n, n_feature) about each truth
    deviation: Array  # (n,) standard deviation of what is measured
    # Ends beyond which only the side is learnt: both are the velocity of a mild or severe test.
    low: float | Array = -math.inf
    high: float | Array = math.inf
    test: dict[str, float] | None = None  # its place
    besides: Observable | None = None  # a further number that it measures
    runs: int = 1  # that it costs


@dataclass(frozen=True, slots=True, eq=False)
class Knowledge:
    """What each truth has learnt: a mean (n, n_feature) and a covariance of the coordinates."""

    truths: Array
    mean: Array
    covariance: Array

    @classmethod
    def of(cls, features: Features) -> Knowledge:
        """Present knowledge, the same for each truth."""
        truths = features.of_truths
        mean = np.broadcast_to(features.mean, truths.shape)
        covariance = np.broadcast_to(features.covariance, (*truths.shape, truths.shape[1]))
        return cls(truths, mean, covariance)

    def spread(self, target: Array) -> float:
        """Standard deviation of a target by its slopes (m, n, n_feature), root mean square."""
        return math.sqrt(max(float(self._variances(target).mean()), 0.0))

    def expected(self, measurement: Observable, target: Array) -> float:
        """Spread of a target that a measurement is expected to leave."""
        if measurement.besides:
            together, _, deviation = self._predicted(measurement.besides)
            known = self._narrowed(together / deviation[:, None], np.ones(len(deviation)))
            return known.expected(measurement._replace(besides=None), target)
        together, predicted, deviation = self._predicted(measurement)
        low, high = _ends(measurement, predicted, deviation)
        moved = np.einsum("mnf,nf->mn", target, together) / deviation
        variances = self._variances(target) - _explained(low, high) * moved**2
        return math.sqrt(max(float(variances.mean()), 0.0))

    def after(
        self, measurement: Observable, chance: np.random.Generator, scores: Array | None = None
    ) -> Knowledge:
        """What is known after a measurement, whose error is drawn for each truth.

        Normal scores of the error may be given.
        """
        if measurement.besides:
            known = self.after(measurement.besides, chance)
            return known.after(measurement._replace(besides=None), chance, scores)
        together, predicted, deviation = self._predicted(measurement)
        low, high = _ends(measurement, predicted, deviation)
        if scores is None:
            scores = chance.standard_normal(len(self.truths))
        error = measurement.deviation * scores
        result = (measurement.values + error - predicted) / deviation
        below, above = _hazard(low), _hazard(-high)
        shift = np.where(result < low, -below, np.where(result > high, above, result))
        by_end = np.where(result < low, below * (below + low), above * (above - high))
        learnt = np.where((result < low) | (result > high), by_end, 1.0)
        gain = together / deviation[:, None]
        return replace(self._narrowed(gain, learnt), mean=self.mean + shift[:, None] * gain)

    def _narrowed(self, gain: Array, learnt: Array) -> Knowledge:
        """Knowledge with the share `learnt` of what a result explains, and the mean of before."""
        explained = np.einsum("n,nf,ng->nfg", learnt, gain, gain)
        return replace(self, covariance=self.covariance - explained)

    def knowing(self, part: slice) -> Knowledge:
        """Knowledge once some of the coordinates are known exactly."""
        inside, across = self.covariance[:, part, part], self.covariance[:, part, :]
        explained = across.transpose(0, 2, 1) @ np.linalg.pinv(inside, hermitian=True) @ across
        return Knowledge(self.truths, self.mean, self.covariance - explained)

    def _variances(self, target: Array) -> Array:
        return np.asarray(np.einsum("mnf,nfg,mng->mn", target, self.covariance, target))

    def _predicted(self, measurement: Observable) -> tuple[Array, Array, Array]:
        """Covariance of the coordinates with the result, its mean, and its standard deviation."""
        slopes = measurement.slopes
        together = np.einsum("nfg,ng->nf", self.covariance, slopes)
        predicted = measurement.values + np.sum(slopes * (self.mean - self.truths), axis=1)
        variance = np.maximum(np.sum(slopes * together, axis=1), 0.0) + measurement.deviation**2
        return together, predicted, np.sqrt(variance)


def _ends(measurement: Observable, predicted: Array, deviation: Array) -> tuple[Array, Array]:
    """Ends beyond which only the side is learnt, as normal scores."""
    low, high = (
        np.clip((end - predicted) / deviation, -_OUTERMOST, _OUTERMOST)
        for end in (measurement.low, measurement.high)
    )
    return low, high


def _hazard(score: Array) -> Array:
    """Density of a normal score over the probability below it."""
    return np.asarray(np.exp(-0.5 * score**2 - _LOG_ROOT - log_ndtr(score)))


def _explained(low: Array, high: Array) -> Array:
    """Share of a result's variance that is learnt if only the side is known beyond two ends."""
    density = [np.exp(-0.5 * end**2 - _LOG_ROOT) for end in (low, high)]
    within = ndtr(high) - ndtr(low) - high * density[1] + low * density[0]
    return np.asarray(within + density[0] * _hazard(low) + density[1] * _hazard(-high))
