"""Draws of the unknown inputs, before or after tests weigh them, and inputs that are fixed."""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from scipy.special import ndtr

from pipeline.scene.units import in_si
from pipeline.sweep.conditions import Conditions
from pipeline.sweep.samples import REACH
from pipeline.sweep.unknown import Fixed, Unknown, drawn
from tribo import InputError
from tribo.types import Array

QUANTILES = (0.05, 0.5, 0.95)
"""Probabilities of which values are given, and lines drawn."""
COUNT = 2**12
"""Number of draws of the scene's own distributions."""
_AT_A_TIME = 256


@dataclass(frozen=True, slots=True, eq=False)
class Draws:
    """Values of the unknown inputs (n, n_unknown) [SI], each with a weight; their sum is 1.

    Faults are reasons why the model does not fit the tests that weigh them.
    """

    inputs: Array
    weights: Array
    faults: tuple[str, ...] = ()

    @property
    def misfit(self) -> str:
        """Why the model does not fit, and what to do; empty if nothing speaks against it."""
        if not self.faults:
            return ""
        return (
            f"the model does not fit: {'; '.join(self.faults)}; nothing is decided by it: look at "
            "the scene and at [unknown]"
        )

    @property
    def effective(self) -> float:
        """Effective sample size: number of draws of equal weight that tell as much."""
        return float(1 / np.sum(self.weights**2))

    def parts(self) -> Iterator[Draws]:
        """The draws in parts, of which many values at a time take little memory."""
        for begin in range(0, len(self.weights), _AT_A_TIME):
            part = slice(begin, begin + _AT_A_TIME)
            yield Draws(self.inputs[part], self.weights[part])

    def mean(self, values: Array) -> Any:
        """Weighted mean over the draws, the first axis."""
        return np.tensordot(self.weights, values, axes=1)

    def spread(self, values: Array) -> float:
        """Weighted standard deviation over the draws, the first axis."""
        return math.sqrt(float(self.mean((values - self.mean(values)) ** 2)))

    def quantile(self, values: Array, share: float) -> float:
        """Value that a share of the probability stays below; values may be infinite."""
        order = np.argsort(values)
        below = np.cumsum(self.weights[order]) - 0.5 * self.weights[order]
        return float(np.interp(share, below, values[order]))

    def interval(self, values: Array) -> tuple[float, float, float]:
        """Values that 5, 50 and 95 % of the probability stay below."""
        low, middle, high = (self.quantile(values, share) for share in QUANTILES)
        return low, middle, high


def prior(unknown: Sequence[Unknown], seed: int, count: int = COUNT) -> Draws:
    """Draw from the distributions that the scene gives its unknown inputs."""
    inputs = drawn(tuple(unknown), seed, count)
    return Draws(inputs, np.full(count, 1 / count))


FRICTION, BULK, CRITICAL, SHARE = (
    "friction.coefficient", "temperature.bulk", "temperature.critical", "temperature.failing_share",
)  # fmt: skip
LEAST_FRICTION = 1e-3
"""Friction of the few draws of a wide distribution that are lower, or negative."""
_ROUNDED = 1e-9  # of a range, beyond which a value is outside


_FIELDS = {
    FRICTION: "friction",
    BULK: "bulk_temperature",
    CRITICAL: "critical_temperature",
    SHARE: "failing_share",
}
_NAMES = _FIELDS | {SHARE: "share"}  # as `pipeline.boundary` takes them


def condition(conditions: Conditions, path: str) -> float | None:
    """Value of a condition by the path of its entry [SI]; None if not known, or no condition."""
    return getattr(conditions, _FIELDS[path]) if path in _FIELDS else None


def with_conditions(at: Mapping[str, float | str], changed: Mapping[str, Any]) -> dict[str, Any]:
    """Conditions that are changed, with those among the values to fix inputs at."""
    both = {name: value for name, value in changed.items() if value is not None}
    for path, value in at.items():
        if path in _NAMES:
            name = _NAMES[path]
            if name in both:
                raise InputError(f"{path} is given twice, also as {name}; give it once")
            both[name] = value
    return both


def fixed_at(
    unknown: Sequence[Unknown],
    stored: Sequence[Fixed],
    at: Mapping[str, float | str],
    changed: Mapping[str, Any],
    conditions: Conditions,
) -> tuple[Fixed, ...]:
    """Inputs that a condition or a value fixes, also in place of what samples have fixed."""
    by_path = {one.path: one for one in (*(one.unknown for one in stored), *unknown)}
    for path in at:
        if path not in by_path and path not in _NAMES:
            raise InputError(
                f"{path} is not an unknown input of these samples, which have "
                f"{', '.join(by_path)}; give one of these, or run the scene with it into another "
                "store"
            )
    fixed = []
    for path, one in by_path.items():
        if _NAMES.get(path) in changed:
            fixed.append(Fixed(one, float(getattr(conditions, _FIELDS[path]))))
        elif path in at:
            fixed.append(Fixed(one, _within(one, at[path])))
    return tuple(fixed)


def _within(unknown: Unknown, value: float | str) -> float:
    """A value of an input in SI; raises if the samples do not reach it."""
    shown = unknown.shown
    if isinstance(value, str) and unknown.unit == "1":
        raise InputError(f'{unknown.path} is "{value}"; give a plain number')
    number = in_si(unknown.path, value, f"1 {shown.name}")
    if unknown.kind == "list":
        nearest = min(unknown.parameters, key=lambda one: abs(one - number))
        if abs(nearest - number) <= _ROUNDED * abs(nearest):
            return nearest
        listed = ", ".join(f"{shown.of(one):g}" for one in unknown.parameters)
        allowed = f"one of {listed}{shown.suffix}"
    else:
        low, high = unknown.quantile(ndtr(np.array([-REACH, REACH]))).tolist()
        if unknown.kind == "uniform":
            low, high = unknown.parameters
        slack = _ROUNDED * (high - low)
        if low - slack <= number <= high + slack:
            return number
        allowed = f"one from {shown.of(low):.4g} to {shown.of(high):.4g}{shown.suffix}"
    raise InputError(
        f"{unknown.path} is {shown.of(number):.6g}{shown.suffix}, beyond the samples; give "
        f"{allowed}, or run the scene with --set {unknown.path}=… into another store"
    )
