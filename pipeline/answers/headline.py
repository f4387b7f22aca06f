"""Sentences on one operating point: verdict, limits, probability, and what decides it."""

from __future__ import annotations

import math

import xarray as xr

from pipeline.answers.value_text import (
    OUTSIDE,
    attribute_texts,
    code_text,
    flag_names,
    format_limit,
    probability_text,
    variable_texts,
    verdict_text,
)
from pipeline.quantities import UNITS

_REMEDIES = {
    "points": "simulate more points nearby",
    "warnings": "follow the warnings of its points",
    "realizations": "simulate more surface realizations (sweep.realizations)",
    "preset": "use a finer preset",
    "test": "run a test at this point",
}
"""What decides an undecided verdict."""
_PRESET_FOR_CUSTOM_SETTINGS = "use a preset, whose error is known"


def headline(point: xr.Dataset, has_ends: bool = True) -> str:
    """The verdict on one point, up to where wear is mild, and what would decide a verdict."""
    verdict, load, velocity = verdict_text(point), point["load"].item(), point["velocity"].item()
    at = f"{load:g} N and {velocity:g} m/s"
    if verdict == "outside the model":
        temperature = variable_texts(point, "governing_temperature").item()
        return f"{OUTSIDE[:1].upper()}{OUTSIDE[1:]}; governing temperature {temperature} °C"
    axes = [
        axis
        for axis in ("load", "velocity")
        if has_ends or math.isfinite(point[f"mild_{axis}"].item())
    ]
    limits = [*filter(None, (limit_text(point, axis) for axis in axes))]
    parts = [f"{verdict.capitalize()} at {at}", ", and ".join(limits)]
    if advice := to_decide(point):
        parts.append(f"to decide it, {advice}")
    return "; ".join(filter(None, parts))


def limit_text(point: xr.Dataset, axis: str) -> str:
    """The mild limit along `axis` with its safety factor, as text; empty without a line."""
    line = {"load": "at this velocity", "velocity": "at this load", "friction": "at this point"}[
        axis
    ]
    low, high = point[f"mild_{axis}"].attrs.get("valid_range", (math.nan, math.nan))
    side = str(code_text(point[f"mild_{axis}_side"])[()])
    unit = f" {UNITS[axis]}".rstrip()
    if side == "above":
        least = high / point[axis].item()
        return (
            f"mild up to the highest simulated {axis}, {high:.4g}{unit}, {line} "
            f"(factor at least {format_limit(least)})"
        )
    if side == "below" and axis == "friction":
        return "not mild at any friction"
    if side == "below":
        return f"not mild even at the lowest simulated {axis}, {low:.4g}{unit}, {line}"
    if side in ("outside the model", "unknown"):
        return ""
    limit, factor = point[f"mild_{axis}"].item(), point[f"{axis}_safety_factor"].item()
    factor_text = f" (factor {format_limit(factor)})" if math.isfinite(factor) else ""
    value = (
        f"friction {format_limit(limit)}" if axis == "friction" else f"{format_limit(limit)}{unit}"
    )
    return f"mild up to {value} {line}{factor_text}"


def probability_line(point: xr.Dataset) -> str:
    """The probability of severe wear at one point, and its distance from the critical temperature.

    Empty without a probability.
    """
    if math.isnan(point["probability"].item()):
        return ""
    ends = point["probability_low"].item(), point["probability_high"].item()
    probability = probability_text(point["probability"].item())
    low, high = probability_text(ends[0], math.floor), probability_text(ends[1], math.ceil)
    margin = variable_texts(point, "temperature_margin").item()
    distance = f"{margin} K below the critical temperature"
    if margin.startswith("-"):
        distance = f"{margin[1:]} K above the critical temperature"
    if math.isnan(point["temperature_error"].item()):
        return f"probability of severe wear {probability}, numerical error unknown, {distance}"
    if low == high or ends[0] == ends[1]:
        return f"probability of severe wear {probability}, {distance}"
    return f"probability of severe wear {probability} ({low} to {high}), {distance}"


def to_decide(point: xr.Dataset) -> str:
    """Advice how to decide an undecided verdict; empty if decided, or ruled out by a test."""
    names = flag_names(point["decided_by"], int(point["decided_by"].item()))
    largest_input = " ".join(attribute_texts(point, "largest_input"))
    texts = _REMEDIES | {"input": f"measure the {largest_input}"}
    if math.isnan(point["temperature_error_discretization"].item()):
        texts["preset"] = _PRESET_FOR_CUSTOM_SETTINGS
    return " and ".join(texts[name] for name in names)
