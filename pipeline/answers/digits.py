"""Digits of the numbers of an answer, as many as their numerical errors allow.

Datasets, JSON and CSV files have all digits; text, tables and figures round.
"""

from __future__ import annotations

import math

import xarray as xr

from pipeline.constants import RISE_SHARE

_MAX_DIGITS = 4  # significant digits, however small the error is
_DIGITS_WITHOUT_ERROR = 3  # significant digits if the error is unknown
_TEMPERATURES = "governing_temperature", "temperature_margin"  # whose error is stated itself
_OF_FRICTION = "critical_friction", "friction_safety_factor"  # inversely proportional to the rise


def rounded(value: float, error: float, upwards: bool = True) -> str:
    """Write a value with the digits that its error allows; empty if it is NaN.

    It is rounded to the nearest number, or down if `upwards` is False.

    It ends at the first digit of the error, or at the second one if the first is 1. So rounding
    changes it by at most a quarter of the error.

    Examples
    --------
    >>> rounded(118.43, 1.6), rounded(2.2864, 0.062), rounded(-48.08, 12.2), rounded(626.9, 25.0)
    ('118.4', '2.29', '-48', '630')
    >>> rounded(2.2864, 0.062, upwards=False)
    '2.28'
    """
    if not math.isfinite(value):
        return ""
    digits = _MAX_DIGITS if error >= 0 else _DIGITS_WITHOUT_ERROR
    last = math.floor(math.log10(abs(value))) - digits + 1 if value else -digits
    if error > 0 and math.isfinite(error):
        first, _, exponent = f"{error:.1e}".partition("e")
        last = max(last, int(exponent) - first.startswith("1"))
    if not upwards:
        value = math.floor(value / 10.0**last + 1e-9) * 10.0**last
    text = f"{round(value, -last):.{max(-last, 0)}f}"
    return text if float(text) else text.removeprefix("-")


def rounded_error(error: float) -> str:
    """Write an error with two digits; empty if it is NaN."""
    return f"{error:.2g}" if math.isfinite(error) else ""


def error_of(answer: xr.Dataset, name: str) -> xr.DataArray:
    """Numerical error of a variable of an answer, in the variable's unit; NaN if unknown.

    It is the error of the temperature rise, or that of the critical velocity.
    """
    values = abs(answer[name])
    if "temperature_error" not in answer:
        relative = answer["velocity_error"]
        is_along_velocity = "velocity" in values.dims and "load" in relative.dims
        return values * (relative.max("load") if is_along_velocity else relative)
    if name in _TEMPERATURES:
        return answer["temperature_error"]
    rise = answer["governing_temperature"] - answer["bulk_temperature"]
    relative = answer["temperature_error"] / rise.where(rise > 0)
    return values * (relative if name in _OF_FRICTION else relative / RISE_SHARE)


def rounded_value(answer: xr.Dataset, name: str, offset: float = 0.0) -> str:
    """Write a single value of an answer, plus `offset`, with the digits that its error allows."""
    return rounded(answer[name].item() + offset, error_of(answer, name).item())
