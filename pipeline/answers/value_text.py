"""Values of answers as text: codes, and numbers with as many digits as their errors allow.

Datasets, JSON and CSV files have all digits.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable
from typing import Any

import numpy as np
import xarray as xr

from pipeline.constants import MIN_STATED_PROBABILITY, RISE_EXPONENT

OUTSIDE = (
    "outside the model: the oil film carries more than 20 % of the load, and wear may be severe"
)
LINE_OUTCOMES = {
    "mild": "mild over the whole sweep",
    "severe": "severe over the whole sweep",
    "outside the model": OUTSIDE,
}
"""Sentences on lines without a critical value."""
_SEPARATOR = " | "  # since sentences have semicolons
_MAX_DIGITS = 4  # significant digits, however small the error is
_DIGITS_WITHOUT_ERROR = 3  # significant digits if the error is unknown
_TEMPERATURES = "governing_temperature", "temperature_margin", "end_temperature"
"""Variables whose error is that of the governing temperature."""


def code_text(variable: xr.DataArray) -> Any:
    """Names of the codes of a variable, such as "outside the model"; empty for others."""
    names = variable.attrs["flag_meanings"].replace("outside_model", "outside_the_model").split()
    texts = np.array([name.replace("_", " ") for name in names] + [""], object)
    codes = np.asarray(variable.values)
    return np.asarray(texts[np.where(codes < 0, len(names), codes)], object)


def verdict_text(point: xr.Dataset) -> str:
    """The verdict on one point, as text."""
    return str(code_text(point["verdict"])[()])


def flag_names(variable: xr.DataArray, flags: int) -> list[str]:
    """Names of the flags of a variable that are set in `flags`."""
    pairs = zip(variable.attrs["flag_meanings"].split(), variable.attrs["flag_masks"], strict=True)
    return [name for name, mask in pairs if flags & int(mask)]


def join_texts(texts: Iterable[str]) -> str:
    """Join several texts to that of an attribute or a cell, without repeats and empty ones."""
    return _SEPARATOR.join(dict.fromkeys(filter(None, texts)))


def split_texts(cells: Iterable[str]) -> list[str]:
    """Texts in `cells` that `join_texts` has made, without repeats."""
    return [*dict.fromkeys(text for cell in cells if cell for text in cell.split(_SEPARATOR))]


def attribute_texts(answer: xr.Dataset, name: str) -> list[str]:
    """Distinct texts in an attribute; it is a coordinate if cases differ in it."""
    values: Any = [answer.attrs[name]] if name in answer.attrs else answer[name].values.ravel()
    return split_texts(values)


def probability_text(probability: float, round_percent: Callable[[float], float] = round) -> str:
    """A probability as text: a percentage of two digits, or "less than 1 %".

    The ends of a range are rounded outward, by `math.floor` and `math.ceil`, so that an end that
    is printed as 95 % decides a verdict as 95 % does.
    """
    if probability < MIN_STATED_PROBABILITY:
        return f"less than {100 * MIN_STATED_PROBABILITY:g} %"
    if probability > 1 - MIN_STATED_PROBABILITY:
        return f"more than {100 * (1 - MIN_STATED_PROBABILITY):g} %"
    parts = 1 if probability >= 0.1 else 10  # of a percent
    return f"{round_percent(round(100 * parts * probability, 9)) / parts:g} %"


def format_value(value: float, error: float) -> str:
    """Write a value with the digits that its error allows; empty if it is NaN.

    It ends at the first digit of the error, or at the second one if the first is 1. So rounding
    changes it by at most a quarter of the error.

    Examples
    --------
    >>> [format_value(x, error) for x, error in ((118.43, 1.6), (2.2864, 0.062), (-48.08, 12.2))]
    ['118.4', '2.29', '-48']
    """
    if not math.isfinite(value):
        return ""
    digits = _MAX_DIGITS if error >= 0 else _DIGITS_WITHOUT_ERROR
    last = math.floor(math.log10(abs(value))) - digits + 1 if value else -digits
    if error > 0 and math.isfinite(error):
        first, _, exponent = f"{error:.1e}".partition("e")
        last = max(last, int(exponent) - first.startswith("1"))
    text = f"{round(value, -last):.{max(-last, 0)}f}"
    return text if float(text) else text.removeprefix("-")


def format_error(error: float) -> str:
    """Write an error with two digits; empty if it is NaN."""
    return f"{float(f'{error:.2g}'):g}" if math.isfinite(error) else ""


def format_limit(value: float, is_mild: bool = True, digits: int = 3) -> str:
    """Write a limit with 3 digits, rounded to its own side: mild downwards, severe upwards.

    It is empty if the limit is NaN.

    Examples
    --------
    >>> format_limit(2.2957), format_limit(2.2911, is_mild=False), format_limit(402.9)
    ('2.29', '2.30', '402')
    """
    if math.isnan(value):
        return ""
    if not (math.isfinite(value) and value > 0):
        return f"{value:g}"
    last = math.floor(math.log10(value)) - digits + 1
    parts, scale = (value * 10**-last, 10**-last) if last < 0 else (value / 10**last, 10.0**-last)
    rounded_parts = math.floor(parts + 1e-9) if is_mild else math.ceil(parts - 1e-9)
    return f"{rounded_parts / scale:.{max(-last, 0)}f}"


def load_factor_texts(margins: xr.Dataset) -> Any:
    """Mild load factors as texts, such as "0.49", "less than 0.5" and "at least 1.25"."""
    low, high = margins["mild_load_factor"].attrs["valid_range"]
    words = {"below": f"less than {low:.4g}", "above": f"at least {high:.4g}"}
    factors, sides = margins["mild_load_factor"].values, code_text(margins["mild_load_factor_side"])
    texts = [
        format_limit(factor) if math.isfinite(factor) else words.get(side, side)
        for factor, side in zip(factors.ravel(), np.ravel(sides), strict=True)
    ]
    return np.array(texts, object).reshape(factors.shape)


def line_sides(mild: str, severe: str, outcome: str) -> dict[str, str]:
    """Where the values of a boundary lie on one line, if they are not inside the sweep.

    `mild` and `severe` are the sides of both limits, and `outcome` is the computed one. The
    boundary with tests lies between the limits.

    Examples
    --------
    >>> line_sides("inside", "above", "mild")["critical_velocity_p50"]
    'above'
    """
    outside = outcome if outcome == "outside the model" else "unknown"
    with_tests = {("inside", "above"): "above", ("above", "above"): "above"} | {
        ("below", "inside"): "below", ("below", "below"): "below"
    }  # fmt: skip
    return {
        "mild": mild,
        "critical": {"mild": "above", "severe": "below"}.get(outcome, outside),
        "critical_velocity_p50": with_tests.get((mild, severe), outside),
        "severe": severe,
    }


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
    is_friction = name == "critical_friction"  # inversely proportional to the rise
    return values * (relative if is_friction else relative / RISE_EXPONENT)


def format_variable(answer: xr.Dataset, name: str, offset: float = 0.0) -> str:
    """Write a single value of an answer, plus `offset`, with the digits that its error allows."""
    return format_value(answer[name].item() + offset, error_of(answer, name).item())
