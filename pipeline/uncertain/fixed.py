"""Unknown inputs that are fixed at a value, without a new run: samples have them as an input."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any, NamedTuple

import numpy as np
from scipy.special import ndtr

from pipeline.scene.quantities import in_si
from pipeline.sweep.conditions import Conditions
from pipeline.sweep.samples import REACH
from pipeline.sweep.unknown import Fixed, Unknown
from tribo import InputError

FRICTION, BULK, CRITICAL, SHARE = (
    "friction.coefficient", "temperature.bulk", "temperature.critical", "temperature.failing_share",
)  # fmt: skip
_ROUNDED = 1e-9  # of a range, beyond which a value is outside


class _Condition(NamedTuple):
    """Name of a condition among those that `pipeline.boundary` takes, and in `Conditions`."""

    name: str
    field: str


_CONDITIONS = {
    FRICTION: _Condition("friction", "friction"),
    BULK: _Condition("bulk_temperature", "bulk_temperature"),
    CRITICAL: _Condition("critical_temperature", "critical_temperature"),
    SHARE: _Condition("share", "failing_share"),
}


def condition(conditions: Conditions, path: str) -> float | None:
    """Value of a condition by the path of its entry [SI]; None if it is none, or not known."""
    return getattr(conditions, _CONDITIONS[path].field) if path in _CONDITIONS else None


def with_conditions(at: Mapping[str, float | str], changed: Mapping[str, Any]) -> dict[str, Any]:
    """Conditions that are changed, with those among the values to fix inputs at."""
    both = {name: value for name, value in changed.items() if value is not None}
    for path, value in at.items():
        if path in _CONDITIONS:
            name = _CONDITIONS[path].name
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
    """Unknown inputs that a condition or a value fixes, besides what the samples have fixed.

    Of these, an input that the samples have may be fixed at another value.
    """
    by_path = {one.path: one for one in (*(one.unknown for one in stored), *unknown)}
    for path in at:
        if path not in by_path and path not in _CONDITIONS:
            raise InputError(
                f"{path} is not an unknown input of these samples, which have "
                f"{', '.join(by_path)}; give one of these, or run the scene with it into another "
                "store"
            )
    fixed = []
    for path, one in by_path.items():
        if path in _CONDITIONS and _CONDITIONS[path].name in changed:
            value = float(getattr(conditions, _CONDITIONS[path].field))
            fixed.append(Fixed(one, value))
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
