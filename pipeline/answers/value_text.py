"""Values of answers as text: codes, and numbers with as many digits as their errors allow.

Datasets, JSON and CSV files have all digits.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable
from typing import Any

import numpy as np
import xarray as xr

from pipeline.constants import MIN_STATED_PROBABILITY
from tribo.types import Array

OUTSIDE = (
    "outside the model: the oil film carries more than 20 % of the load, and wear may be severe"
)
_SEPARATOR = " | "  # since sentences have semicolons
_MAX_DIGITS = 4  # significant digits, however small the error is
_DIGITS_WITHOUT_ERROR = 3  # significant digits if the error is unknown


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
    """A probability as text: a percentage of two digits, or "less than 1 %"; empty if unknown.

    The ends of a range are rounded outward, by `math.floor` and `math.ceil`, so that an end that
    is printed as 95 % decides a verdict as 95 % does.
    """
    if math.isnan(probability):
        return ""
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


def range_text(values: Array, write: Callable[[float], str]) -> str:
    """The least and the largest of several values as text, such as "2 to 3"."""
    return " to ".join(dict.fromkeys(map(write, (np.nanmin(values), np.nanmax(values)))))
