"""Sentences on the answer for one operating point."""

from __future__ import annotations

import math
from collections.abc import Iterator

import xarray as xr

from pipeline.answers.answer_lines import not_included_lines, point_warnings
from pipeline.answers.attributes import SHARP_PERCENTS
from pipeline.answers.digits import rounded, rounded_error, rounded_value
from pipeline.answers.readable import (
    OUTSIDE,
    attribute_texts,
    code_text,
    flag_names,
    outcome_texts,
    probability_text,
    verdict_text,
)
from pipeline.constants import DECIDED
from pipeline.quantities import UNITS, ZERO

_HEADLINES = {
    "sure": "{verdict}: probability of severe wear {probability}, {distance}",
    "range": "{verdict}: probability of severe wear {probability} ({low} to {high}), {distance}",
    "unknown": (
        "{verdict}: probability of severe wear {probability}, numerical error unknown, {distance}"
    ),
}
"""First line on a point, by what is known of the range of the probability."""
_MILD_BUT_FOR_ENDS = (
    "Mild, but perhaps severe at the pin's sharp ends, which are not modelled and wear severely at "
    "{} to {} % lower velocity"
)
_ORIGINS = {
    "simulated": "{} °C, simulated at this point",
    "interpolated": "{} °C, interpolated between simulated points",
    "extrapolated": "{} °C, extrapolated beyond the simulated points by a power law in velocity",
}
"""Governing temperature with its origin."""
_PART_LABELS = {
    "interpolation": "interpolation", "discretization": "discretization", "warnings": "warnings",
    "surface": "surface sampling",
}  # fmt: skip
_REMEDIES = {
    "interpolation": "simulate more points nearby",
    "discretization": "use a finer preset",
    "warnings": "follow the warnings of its points",
    "surface": "simulate more surface realizations (sweep.realizations)",
}
"""What makes each part of the numerical error smaller."""
_TEST_POINT = "run a test at this point"
_TESTED_POINT = "change the conditions or the scene"
_FIRST_COMPUTE = "{remedy}, as the numerical error may decide; if it stays undecided, {test}"


def margin_lines(point: xr.Dataset) -> Iterator[str]:
    """Lines on one point."""
    if verdict_text(point) == "unknown":
        yield f"Unknown: {point['reason'].item()}"
        return
    yield headline(point)
    yield from not_included_lines(point)
    yield from (f"  {name:22}  {text}" for name, text in margin_facts(point))
    yield from (f"warning: {text}" for text in point_warnings(point))


def headline(point: xr.Dataset) -> str:
    """The verdict on one point, and the probability of severe wear."""
    verdict = verdict_text(point)
    if verdict == "outside the model":
        return f"{OUTSIDE[:1].upper()}{OUTSIDE[1:]}; governing temperature {_temperature(point)} °C"
    ends = point["probability_low"].item(), point["probability_high"].item()
    probability = probability_text(point["probability"].item())
    low, high = probability_text(ends[0], math.floor), probability_text(ends[1], math.ceil)
    known = "sure" if low == high or ends[0] == ends[1] else "range"
    if math.isnan(point["temperature_error"].item()):
        known = "unknown"
    subject = verdict.capitalize()
    if "sharp_ends" in flag_names(point["warning_flags"], point["warning_flags"].item()):
        subject = _MILD_BUT_FOR_ENDS.format(*SHARP_PERCENTS)
    return _HEADLINES[known].format(
        verdict=subject, probability=probability, low=low, high=high, distance=_distance(point)
    )


def _distance(point: xr.Dataset) -> str:
    margin = rounded_value(point, "temperature_margin")
    if margin.startswith("-"):
        return f"{margin[1:]} K above the critical temperature"
    return f"{margin} K below the critical temperature"


def _temperature(point: xr.Dataset) -> str:
    """Governing temperature in °C."""
    celsius = point["governing_temperature"].item() - float(ZERO["°C"])
    return rounded(celsius, point["temperature_error"].item())


def margin_facts(point: xr.Dataset) -> Iterator[tuple[str, str]]:
    """Yield the name and the value, as text, of each quantity of one point."""
    yield "conditions", attribute_texts(point, "conditions")[0]
    origin = _ORIGINS[str(code_text(point["origin"])[()])]
    yield "governing temperature", origin.format(_temperature(point))
    yield "numerical error (95 %)", error_text(point)
    yield "model error", attribute_texts(point, "model_error")[0]
    for axis in ("velocity", "load"):
        outcome = str(outcome_texts(point, axis)[()])
        if not outcome:
            continue
        is_known = not math.isnan(point[f"critical_{axis}"].item())
        yield f"critical {axis}", _critical(point, axis) if is_known else outcome
        if axis == "velocity" and (velocity := rounded_value(point, "critical_velocity_p50")):
            yield "with tests", f"{velocity} m/s (severe wear is 50 % probable)"
    yield "critical friction", _critical(point, "friction")
    if point["nearby_tests"].item():
        yield "tests nearby", point["nearby_tests"].item()
    if point["reason"].item():
        yield "verdict withheld", point["reason"].item()
    if advice := to_decide(point):
        yield "to decide", advice


def _critical(point: xr.Dataset, name: str) -> str:
    """A critical value, with its safety factor if the point has a verdict."""
    value = f"{rounded_value(point, f'critical_{name}')} {UNITS[name]}".rstrip()
    factor = rounded_value(point, f"{name}_safety_factor")
    return f"{value}, safety factor {factor}" if factor else value


def error_text(point: xr.Dataset) -> str:
    """The numerical error of a temperature and its parts."""
    parts = {text: point[f"temperature_error_{name}"].item() for name, text in _PART_LABELS.items()}
    known = ", ".join(f"{name} {rounded_error(part)} K" for name, part in parts.items() if part > 0)
    unknown = " and ".join(name for name, part in parts.items() if math.isnan(part))
    if unknown and known:
        return f"unknown, because a part is unknown: {unknown} ({known})"
    if unknown:
        return f"unknown, because a part is unknown: {unknown}"
    return f"± {rounded_error(point['temperature_error'].item())} K: {known}"


def to_decide(point: xr.Dataset) -> str:
    """Advice how to decide an undecided verdict; empty if decided, or ruled out by a test.

    A smaller numerical error comes first, if a verdict is possible within that error.
    """
    if verdict_text(point) != "undecided" or point["reason"].item():
        return ""
    low, middle, high = (point[f"probability{end}"].item() for end in ("_low", "", "_high"))
    mild, _, severe = DECIDED
    sizes = {name: point[f"temperature_error_{name}"].item() for name in _REMEDIES}
    largest = max(sizes, key=lambda name: math.inf if math.isnan(sizes[name]) else sizes[name])
    test = _TESTED_POINT if point["nearby_tests"].item() else _TEST_POINT
    if not mild < middle < severe:
        return _REMEDIES[largest]
    if mild < low and high < severe:
        return test
    return _FIRST_COMPUTE.format(remedy=_REMEDIES[largest], test=test)
