"""Values of answers as text in printed units, with as many digits as their errors allow.

Tables, facts and figures print these. Datasets, JSON and CSV files have all digits.
"""

from __future__ import annotations

import math
import re
from collections.abc import Callable, Iterable
from typing import Any

import numpy as np
import xarray as xr

from pipeline.answers.scene_wording import usual_unit
from pipeline.constants import MIN_STATED_PROBABILITY, RISE_EXPONENT
from pipeline.quantities import in_unit
from pipeline.store.schema import PLANE
from tribo.types import Array

OUTSIDE = (
    "outside the model: the oil film carries more than 20 % of the load, and wear may be severe"
)
_SEPARATOR = " | "  # since sentences have semicolons
_MAX_DIGITS = 4  # significant digits, however small the error is
_DIGITS_WITHOUT_ERROR = 3  # significant digits if the error is unknown
_TEMPERATURES = "governing_temperature", "temperature_margin", "end_temperature"
"""Variables whose error is that of the governing temperature."""
_WITH_ERROR = re.compile(f"critical_(velocity|load|friction)(_p50)?|{'|'.join(_TEMPERATURES)}")
"""Variables whose digits depend on the numerical error."""
_LIMIT = re.compile("(mild|severe)_(velocity|load|friction|load_factor)|.*_safety_factor")
"""Limits, load factors and safety factors, which are rounded to the side of their verdict."""

_SIDES = {"mild": "above", "severe": "below", "outside the model": "outside"}
"""Where a critical value lies by the outcome along its line."""
_BETWEEN_LIMITS: dict[tuple[str, ...], str] = {
    ("inside", "above"): "above", ("above", "above"): "above",
    ("below", "inside"): "below", ("below", "below"): "below",
}  # fmt: skip
"""Where the boundary with tests lies by the sides of the mild and the severe limit."""


def variable_texts(answer: xr.Dataset, name: str) -> xr.DataArray:
    """Values of a variable of an answer as texts, empty if unknown.

    A value outside the sweep is "below" or "above" its end. Variables that a user gave, and codes,
    are unchanged.
    """
    variable, unit = answer[name], printed_unit(answer, name)
    if name not in answer.data_vars:
        return variable
    if name.endswith("probability"):
        texts = _texts(probability_text, variable)
    elif _LIMIT.fullmatch(name):
        is_mild = not name.startswith("severe")
        texts = _with_sides(answer, name, _texts(lambda x: format_limit(x, is_mild), variable))
    elif _WITH_ERROR.fullmatch(name):
        texts = _texts(format_value, in_unit(variable, unit), error_of(answer, name))
        texts = _with_sides(answer, name, texts)
    elif "_error" in name:
        texts = _texts(format_error, in_unit(variable, unit))
    elif name.startswith("film_parameter"):
        texts = _texts(lambda film: "" if film != film else f"{film:.2g}", variable)
    else:
        return variable
    return texts.assign_attrs(variable.attrs)


@np.errstate(all="ignore")  # NaN and infinity are written, too
def _texts(write: Callable[..., str], *arrays: Any) -> xr.DataArray:
    """Texts that a function writes for each element of arrays."""
    texts: xr.DataArray = xr.apply_ufunc(write, *arrays, vectorize=True, output_dtypes=[object])
    return texts


def printed_unit(answer: xr.Dataset, name: str) -> str:
    """Unit in which a variable of an answer is printed; empty for a number."""
    variable = answer[name]
    unit = str(variable.attrs.get("units", ""))
    if unit and ("display_unit" in variable.attrs or (name in answer.dims and name not in PLANE)):
        unit = usual_unit(variable)
    if "error" in name or name == "temperature_margin":
        return {"1": "%"}.get(unit, unit)
    return {"1": "", "K": "°C"}.get(unit, unit)


def error_of(answer: xr.Dataset, name: str) -> xr.DataArray:
    """Numerical error of a variable of an answer, in the variable's unit; NaN if unknown.

    It is the error of the temperature rise, or that of the critical velocity.
    """
    values = abs(answer[name])
    if "temperature_error" not in answer:
        relative = answer.get("velocity_error", values * math.nan)
        is_along_velocity = "velocity" in values.dims and "load" in relative.dims
        return values * (relative.max("load") if is_along_velocity else relative)
    if name in _TEMPERATURES:
        return answer["temperature_error"]
    rise = answer["governing_temperature"] - answer["bulk_temperature"]
    relative = answer["temperature_error"] / rise.where(rise > 0)
    is_friction = name == "critical_friction"  # inversely proportional to the rise
    return values * (relative if is_friction else relative / RISE_EXPONENT)


def _with_sides(answer: xr.Dataset, name: str, texts: xr.DataArray) -> xr.DataArray:
    """Texts of limits and critical values; an empty one is replaced by where the value lies."""
    kind, _, axis = name.removesuffix("_p50").partition("_")
    is_factor = name.endswith("_safety_factor")
    if is_factor:
        kind, axis = "mild", kind
    codes = [f"outcome_along_{axis}" if kind == "critical" else f"{kind}_{axis}_side"]
    if name.endswith("_p50"):
        codes += ["mild_velocity_side", "severe_velocity_side"]
    limit = answer.get(f"mild_{axis}")
    if limit is None or "valid_range" not in limit.attrs or not {*codes} <= {*answer}:
        return texts
    ends = [end / answer[axis] if is_factor else end for end in limit.attrs["valid_range"]]

    def with_side(text: str, low: float, high: float, code: str, *limits: str) -> str:
        side = _SIDES.get(code, code)
        if limits:
            side = _BETWEEN_LIMITS.get(limits, "outside" if side == "outside" else "unknown")
        end = {"below": low, "above": high}.get(side)
        if text or end is None:
            return text or ("" if is_factor else side)  # the verdict of a row says the others
        return f"{side} {format_limit(end, side == 'above') if is_factor else f'{end:g}'}"

    sides = (answer[code].copy(data=code_text(answer[code])) for code in codes)
    return _texts(with_side, texts, *ends, *sides)


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
