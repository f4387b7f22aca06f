"""Variables of an answer as texts in their printed unit, with the digits that their errors allow.

Tables, facts and figures print these.
"""

from __future__ import annotations

import math
import re
from collections.abc import Callable
from typing import Any

import numpy as np
import xarray as xr

from pipeline.answers.scene_wording import usual_unit
from pipeline.answers.value_text import (
    code_text,
    format_error,
    format_limit,
    format_value,
    probability_text,
)
from pipeline.constants import RISE_EXPONENT
from pipeline.quantities import in_unit
from pipeline.store.schema import PLANE

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
            return text or side
        return f"{side} {format_limit(end, side == 'above') if is_factor else f'{end:g}'}"

    sides = (answer[code].copy(data=code_text(answer[code])) for code in codes)
    return _texts(with_side, texts, *ends, *sides)
