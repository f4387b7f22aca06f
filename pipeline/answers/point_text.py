"""Sentences on one operating point: verdict, limits, probability, and what decides it."""

from __future__ import annotations

import math
from collections.abc import Iterator

import xarray as xr

from pipeline.answers.answer_lines import contact_warnings, not_included_lines
from pipeline.answers.hottest_end import end_text
from pipeline.answers.value_text import (
    LINE_OUTCOMES,
    OUTSIDE,
    attribute_texts,
    code_text,
    flag_names,
    format_error,
    format_limit,
    format_variable,
    probability_text,
    verdict_text,
)
from pipeline.quantities import UNITS, ZERO

_ORIGINS = {
    "simulated": "{} °C, simulated at this point",
    "interpolated": "{} °C, interpolated between simulated points",
    "extrapolated": "{} °C, extrapolated beyond the simulated points by a power law in velocity",
}
"""Governing temperature with its origin."""
ERROR_PARTS = {
    "interpolation": "interpolation",
    "discretization": "discretization",
    "warnings": "warnings",
    "positions": "positions of the disk",
    "surface": "surface sampling",
}
"""Name of each part of the numerical error."""
_REMEDIES = {
    "points": "simulate more points nearby",
    "warnings": "follow the warnings of its points",
    "realizations": "simulate more surface realizations (sweep.realizations)",
    "preset": "use a finer preset",
    "test": "run a test at this point",
}
"""What decides an undecided verdict."""
_PRESET_FOR_CUSTOM_SETTINGS = "use a preset, whose error is known"


def margin_lines(point: xr.Dataset, has_ends: bool = True) -> Iterator[str]:
    """Lines on one operating point.

    Without `has_ends`, they omit limits beyond the simulated loads and velocities.
    """
    if verdict_text(point) == "unknown":
        yield f"Unknown: {point['reason'].item()}"
        return
    yield headline(point, has_ends)
    if line := probability_line(point):
        yield line
    yield from not_included_lines(point)
    yield from (f"  {name:22}  {text}" for name, text in margin_facts(point))
    yield from contact_warnings(point)


def headline(point: xr.Dataset, has_ends: bool = True) -> str:
    """The verdict on one point, up to where wear is mild, and what would decide a verdict."""
    verdict, load, velocity = verdict_text(point), point["load"].item(), point["velocity"].item()
    at = f"{load:g} N and {velocity:g} m/s"
    if verdict == "outside the model":
        return f"{OUTSIDE[:1].upper()}{OUTSIDE[1:]}; governing temperature {_temperature(point)} °C"
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
    margin = format_variable(point, "temperature_margin")
    distance = f"{margin} K below the critical temperature"
    if margin.startswith("-"):
        distance = f"{margin[1:]} K above the critical temperature"
    if math.isnan(point["temperature_error"].item()):
        return f"probability of severe wear {probability}, numerical error unknown, {distance}"
    if low == high or ends[0] == ends[1]:
        return f"probability of severe wear {probability}, {distance}"
    return f"probability of severe wear {probability} ({low} to {high}), {distance}"


def _temperature(point: xr.Dataset) -> str:
    """Governing temperature in °C."""
    return format_variable(point, "governing_temperature", -float(ZERO["°C"]))


def margin_facts(point: xr.Dataset) -> Iterator[tuple[str, str]]:
    """Yield the name and the value, as text, of each quantity of one point."""
    yield "conditions", attribute_texts(point, "conditions")[0]
    origin = _ORIGINS[str(code_text(point["origin"])[()])]
    yield "governing temperature", origin.format(_temperature(point))
    if end := end_text(point):
        yield "hottest end of the pin", end
    yield "numerical error (95 %)", error_text(point)
    yield "model error", attribute_texts(point, "model_error")[0]
    for text in attribute_texts(point, "uncertain_inputs"):
        yield "uncertain inputs", text
    for axis in ("velocity", "load"):
        outcome = str(code_text(point[f"outcome_along_{axis}"])[()])
        if outcome == "transition":
            value = format_variable(point, f"critical_{axis}")
            yield f"computed {axis}", f"severe from {value} {UNITS[axis]}"
        elif outcome in LINE_OUTCOMES:
            yield f"computed {axis}", LINE_OUTCOMES[outcome]
        if axis == "velocity" and (velocity := format_variable(point, "critical_velocity_p50")):
            yield "with tests", f"{velocity} m/s (severe wear is 50 % probable)"
    if friction := limit_text(point, "friction"):
        yield "limit of friction", friction
    if point["reason"].item():
        yield "verdict withheld", point["reason"].item()


def _error_parts(point: xr.Dataset) -> dict[str, float]:
    """Numerical error of the temperature of one point by part [K]; NaN if unknown."""
    return {name: point[f"temperature_error_{name}"].item() for name in ERROR_PARTS}


def error_text(point: xr.Dataset) -> str:
    """The numerical error of a temperature and its parts."""
    parts = {ERROR_PARTS[name]: error for name, error in _error_parts(point).items()}
    known = ", ".join(f"{name} {format_error(part)} K" for name, part in parts.items() if part > 0)
    unknown = " and ".join(name for name, part in parts.items() if math.isnan(part))
    if unknown and known:
        return f"unknown, because a part is unknown: {unknown} ({known})"
    if unknown:
        return f"unknown, because a part is unknown: {unknown}"
    total = f"± {format_error(point['temperature_error'].item())} K"
    return f"{total}: {known}" if known else total


def to_decide(point: xr.Dataset) -> str:
    """Advice how to decide an undecided verdict; empty if decided, or ruled out by a test."""
    names = flag_names(point["decided_by"], int(point["decided_by"].item()))
    largest_input = " ".join(attribute_texts(point, "largest_input"))
    texts = _REMEDIES | {"input": f"measure the {largest_input}"}
    if math.isnan(point["temperature_error_discretization"].item()):
        texts["preset"] = _PRESET_FOR_CUSTOM_SETTINGS
    return " and ".join(texts[name] for name in names)
