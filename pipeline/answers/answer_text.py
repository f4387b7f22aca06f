"""Answers as text: codes, labels, numbers with enough digits, and lines below tables.

Datasets, JSON and CSV files have all digits. Text, tables and figures have as many as the numerical
errors allow.
"""

from __future__ import annotations

import math
from collections import Counter
from collections.abc import Callable, Iterator
from typing import Any

import numpy as np
import xarray as xr

from pipeline.constants import MIN_STATED_PROBABILITY, RISE_EXPONENT, VERDICT_PROBABILITIES
from pipeline.messages import listed, split_notes
from pipeline.quantities import UNITS, ZERO
from pipeline.store.schema import PLANE
from tribo.types import Array

OUTSIDE = (
    "outside the model: the oil film carries more than 20 % of the load, and wear may be severe"
)
_OUTCOMES = {
    "transition": "transition",
    "mild": "mild over the whole sweep",
    "severe": "severe over the whole sweep",
    "mild to highest": "mild up to the highest simulated {axis}",
    "severe from lowest": "severe down to the lowest simulated {axis}",
    "unknown": "unknown because too few points are done",
    "outside the model": OUTSIDE,
    "no line": "",
    "": "",
}
_MAX_DIGITS = 4  # significant digits, however small the error is
_DIGITS_WITHOUT_ERROR = 3  # significant digits if the error is unknown
_TEMPERATURES = "governing_temperature", "temperature_margin"  # whose error is stated itself
_OF_FRICTION = (
    "critical_friction",
    "mild_friction",
    "friction_safety_factor",
)  # inversely proportional to the rise
_MAX_REASONS = 6
_PROBABILITIES = {
    "sure": "probability of severe wear {probability}, {distance}",
    "range": "probability of severe wear {probability} ({low} to {high}), {distance}",
    "unknown": "probability of severe wear {probability}, numerical error unknown, {distance}",
}
"""Probability at a point, by what is known of its range."""
_ORIGINS = {
    "simulated": "{} °C, simulated at this point",
    "interpolated": "{} °C, interpolated between simulated points",
    "extrapolated": "{} °C, extrapolated beyond the simulated points by a power law in velocity",
}
"""Governing temperature with its origin."""
_PARTS = {
    "interpolation": ("interpolation", "simulate more points nearby"),
    "discretization": ("discretization", "use a finer preset"),
    "warnings": ("warnings", "follow the warnings of its points"),
    "positions": (
        "positions of the disk",
        "use a finer preset, or simulate more surface realizations (sweep.realizations)",
    ),
    "surface": (
        "surface sampling",
        "simulate more surface realizations (sweep.realizations)",
    ),
}
"""Name of each part of the numerical error, and what makes it smaller."""


# Values


def code_text(variable: xr.DataArray) -> Any:
    """Names of the codes of a variable, such as "outside the model"; empty for others."""
    names = variable.attrs["flag_meanings"].replace("outside_model", "outside_the_model").split()
    texts = np.array([name.replace("_", " ") for name in names] + [""], object)
    codes = np.asarray(variable.values)
    return np.asarray(texts[np.where(codes < 0, len(names), codes)], object)


def verdict_text(point: xr.Dataset) -> str:
    """The verdict on one point, as text."""
    return str(code_text(point["verdict"])[()])


def outcome_texts(answer: xr.Dataset, axis: str) -> Any:
    """Outcome of each line along `axis`, as text; empty where there is no line."""
    texts = {name: text.format(axis=axis) for name, text in _OUTCOMES.items()}
    codes = code_text(answer[f"outcome_along_{axis}"])
    return np.vectorize(texts.__getitem__, otypes=[object])(codes)


def flag_names(variable: xr.DataArray, flags: int) -> list[str]:
    """Names of the flags of a variable that are set in `flags`."""
    pairs = zip(variable.attrs["flag_meanings"].split(), variable.attrs["flag_masks"], strict=True)
    return [name for name, mask in pairs if flags & int(mask)]


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


def attribute_texts(answer: xr.Dataset, name: str) -> list[str]:
    """Distinct values of an attribute; it is a coordinate if cases differ in it."""
    values: Any = [answer.attrs[name]] if name in answer.attrs else answer[name].values.ravel()
    return [str(value) for value in dict.fromkeys(values) if value]


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
    return values * (relative if name in _OF_FRICTION else relative / RISE_EXPONENT)


def format_variable(answer: xr.Dataset, name: str, offset: float = 0.0) -> str:
    """Write a single value of an answer, plus `offset`, with the digits that its error allows."""
    return format_value(answer[name].item() + offset, error_of(answer, name).item())


# Lines below any answer


def common_lines(answer: xr.Dataset) -> Iterator[str]:
    """Lines below any answer: outliers, tests without a result, missing points, notes."""
    yield from split_notes(attribute_texts(answer, "outliers"))
    yield from withheld_lines(answer)
    if missing := answer.attrs["missing_points"]:
        yield f"points that are pending or failed, and were not used: {missing}"
    yield from split_notes(attribute_texts(answer, "notes"))


def withheld_lines(answer: xr.Dataset) -> Iterator[str]:
    """Lines on verdicts that are withheld because tests have no result, or one outcome only."""
    for reason in split_notes(attribute_texts(answer, "verdicts_withheld")):
        yield f"some verdicts are withheld: {reason}"


def conditions_lines(answer: xr.Dataset) -> list[str]:
    """Line with the conditions of an answer, of its first row if rows differ in them."""
    texts = attribute_texts(answer, "conditions")
    if len(texts) > 1:
        return [f"conditions: {texts[0]}; {len(texts) - 1} more"]
    return [f"conditions: {text}" for text in texts]


def model_error_line(answer: xr.Dataset) -> str:
    """Line on the model error of the first case, and the number of further cases."""
    first, *further_texts = split_notes(attribute_texts(answer, "model_error"))
    if further_texts:
        return f"model error: {first}, and {len(further_texts)} more"
    return f"model error: {first}"


def not_included_lines(answer: xr.Dataset) -> Iterator[str]:
    """Lines on effects that are not included and may be unsafe."""
    if "not_included" in answer.attrs:
        yield f"not included: {answer.attrs['not_included']}"
        return
    texts = answer["not_included"].values.ravel()
    for text, count in Counter(texts.tolist()).items():
        yield f"not included ({count} of {len(texts)} cases): {text}"


def reason_lines(answer: xr.Dataset) -> Iterator[str]:
    """Reasons for points without a verdict, each with its first point."""
    axes = (answer[name].broadcast_like(answer["reason"]).values.ravel() for name in PLANE)
    points = dict[str, list[str]]()
    for reason, load, velocity in zip(answer["reason"].values.ravel(), *axes, strict=True):
        points.setdefault(reason, []).append(f"{load:g} N at {velocity:g} m/s")
    points.pop("", None)
    for reason, texts in [*points.items()][:_MAX_REASONS]:
        yield f"{listed(texts, 1)}: {reason}"
    if rest := sum(map(len, [*points.values()][_MAX_REASONS:])):
        yield f"further points without a verdict: {rest}; see the column reason of -o TABLE.csv"


# Operating points


def margin_lines(point: xr.Dataset) -> Iterator[str]:
    """Lines on one operating point."""
    if verdict_text(point) == "unknown":
        yield f"Unknown: {point['reason'].item()}"
        return
    yield headline(point)
    if advice := to_decide(point):
        yield f"to decide it: {advice}"
    if line := probability_line(point):
        yield line
    yield from not_included_lines(point)
    yield from (f"  {name:22}  {text}" for name, text in margin_facts(point))
    yield from edge_warnings(point)


def edge_warnings(points: xr.Dataset) -> Iterator[str]:
    """Yield a warning if the contact of a point reaches the edge of the window."""
    flags = points["warning_flags"]
    if "contact_at_edge" in flag_names(flags, int(np.bitwise_or.reduce(flags.values.ravel()))):
        at = "at some points, " if flags.ndim else ""
        yield (
            f"warning: {at}the contact reaches the edge of the window nearby; increase "
            "window.pixels"
        )


def temperature_error_line(answer: xr.Dataset) -> str:
    """Line on the numerical error of the governing temperature at several points."""
    errors = answer["temperature_error"].values
    if not np.isfinite(errors).any():
        return "numerical error of the governing temperature: unknown"
    ends = dict.fromkeys(map(format_error, (np.nanmin(errors), np.nanmax(errors))))
    return f"numerical error (95 %): ± {' to '.join(ends)} K of the governing temperature"


def side_text(name: str, side: str) -> str:
    """Text on a limit that lies outside the sweep, such as "all" for one above it."""
    is_mild = name.startswith("mild")
    texts = {"above": ("none", "all"), "below": ("all", "none")}
    return texts[side][is_mild] if side in texts else ""


def headline(point: xr.Dataset) -> str:
    """The verdict on one point, up to where wear is mild, and the safety factors."""
    verdict, load, velocity = verdict_text(point), point["load"].item(), point["velocity"].item()
    at = f"{load:.4g} N and {velocity:.4g} m/s"
    if verdict == "outside the model":
        return f"{OUTSIDE[:1].upper()}{OUTSIDE[1:]}; governing temperature {_temperature(point)} °C"
    limits = [*filter(None, (limit_text(point, axis) for axis in ("load", "velocity")))]
    if not limits:
        return f"{verdict.capitalize()} at {at}"
    return f"{verdict.capitalize()} at {at}; {', and '.join(limits)}"


def limit_text(point: xr.Dataset, axis: str) -> str:
    """The mild limit along `axis` with its safety factor, as text; empty without a line."""
    line = {"load": "at this velocity", "velocity": "at this load", "friction": "here"}[axis]
    low, high = point[f"mild_{axis}"].attrs.get("valid_range", (math.nan, math.nan))
    side = str(code_text(point[f"mild_{axis}_side"])[()])
    unit = f" {UNITS[axis]}".rstrip()
    if side == "above":
        least = high / point[axis].item()
        return (
            f"mild up to the highest simulated {axis}, {high:.4g}{unit}, {line} "
            f"(factor at least {format_limit(least)})"
        )
    if side == "below":
        return f"not mild from the lowest simulated {axis}, {low:.4g}{unit}, {line}"
    if side == "none":
        return ""
    limit, factor = point[f"mild_{axis}"].item(), point[f"{axis}_safety_factor"].item()
    factor_text = f" (factor {format_limit(factor)})" if math.isfinite(factor) else ""
    return f"mild up to {format_limit(limit)}{unit} {line}{factor_text}"


def format_limit(value: float, is_mild: bool = True, digits: int = 3) -> str:
    """Write a limit with 3 digits, rounded to its own side: mild downwards, severe upwards.

    Examples
    --------
    >>> format_limit(2.2957), format_limit(2.2911, is_mild=False), format_limit(402.9)
    ('2.29', '2.30', '402')
    """
    if not (math.isfinite(value) and value > 0):
        return f"{value:g}"
    last = math.floor(math.log10(value)) - digits + 1
    parts, scale = (value * 10**-last, 10**-last) if last < 0 else (value / 10**last, 10.0**-last)
    whole = math.floor(parts + 1e-9) if is_mild else math.ceil(parts - 1e-9)
    return f"{whole / scale:.{max(-last, 0)}f}"


def probability_line(point: xr.Dataset) -> str:
    """The probability of severe wear at one point, and its distance from the critical temperature.

    Empty without a probability.
    """
    if math.isnan(point["probability"].item()):
        return ""
    ends = point["probability_low"].item(), point["probability_high"].item()
    probability = probability_text(point["probability"].item())
    low, high = probability_text(ends[0], math.floor), probability_text(ends[1], math.ceil)
    known = "sure" if low == high or ends[0] == ends[1] else "range"
    if math.isnan(point["temperature_error"].item()):
        known = "unknown"
    margin = format_variable(point, "temperature_margin")
    distance = f"{margin} K below the critical temperature"
    if margin.startswith("-"):
        distance = f"{margin[1:]} K above the critical temperature"
    return _PROBABILITIES[known].format(
        probability=probability, low=low, high=high, distance=distance
    )


def _temperature(point: xr.Dataset) -> str:
    """Governing temperature in °C."""
    return format_variable(point, "governing_temperature", -float(ZERO["°C"]))


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
        value = f"{format_variable(point, f'critical_{axis}')} {UNITS[axis]}"
        yield f"computed {axis}", f"severe from {value}" if is_known else outcome
        if axis == "velocity" and (velocity := format_variable(point, "critical_velocity_p50")):
            yield "with tests", f"{velocity} m/s (severe wear is 50 % probable)"
    if friction := limit_text(point, "friction"):
        yield "friction", friction
    if point["reason"].item():
        yield "verdict withheld", point["reason"].item()


def _error_parts(point: xr.Dataset) -> dict[str, float]:
    """Numerical error of the temperature of one point by part [K]; NaN if unknown."""
    return {name: point[f"temperature_error_{name}"].item() for name in _PARTS}


def error_text(point: xr.Dataset) -> str:
    """The numerical error of a temperature and its parts."""
    parts = {_PARTS[name][0]: error for name, error in _error_parts(point).items()}
    known = ", ".join(f"{name} {format_error(part)} K" for name, part in parts.items() if part > 0)
    unknown = " and ".join(name for name, part in parts.items() if math.isnan(part))
    if unknown and known:
        return f"unknown, because a part is unknown: {unknown} ({known})"
    if unknown:
        return f"unknown, because a part is unknown: {unknown}"
    return f"± {format_error(point['temperature_error'].item())} K: {known}"


def to_decide(point: xr.Dataset) -> str:
    """Advice how to decide an undecided verdict; empty if decided, or ruled out by a test.

    A smaller numerical error comes first, if a verdict is possible within that error.
    """
    if verdict_text(point) != "undecided" or point["reason"].item():
        return ""
    low, middle, high = (point[f"probability{end}"].item() for end in ("_low", "", "_high"))
    mild, _, severe = VERDICT_PROBABILITIES
    errors, test = _error_parts(point), "run a test at this point"
    largest = max(errors, key=lambda name: np.nan_to_num(errors[name], nan=math.inf))
    remedy = _PARTS[largest][1]
    if not mild < middle < severe:
        return remedy
    if mild < low and high < severe:
        return test
    return f"to reduce the numerical error, {remedy}; if it stays undecided, {test}"


# Boundaries


def boundary_lines(answer: xr.Dataset) -> Iterator[str]:
    """Lines on a boundary: effects not included, tests that limit it, and errors."""
    yield from not_included_lines(answer)
    yield from ruling_lines(answer)
    yield from error_lines(answer)


def ruling_lines(answer: xr.Dataset) -> Iterator[str]:
    """Lines on the tests that limit the velocities at which wear is mild, or severe."""
    texts, loads = xr.broadcast(answer["ruled_out_by"], answer["load"])
    loads_of = dict[str, list[float]]()
    for cell, load in zip(texts.values.ravel(), loads.values.ravel().tolist(), strict=True):
        for text in split_notes([cell]):
            loads_of.setdefault(text, []).append(load)
    for text, ruled_loads in loads_of.items():
        ends = dict.fromkeys(f"{load:g}" for load in (min(ruled_loads), max(ruled_loads)))
        yield f"at {' to '.join(ends)} N, {text}"


def error_lines(answer: xr.Dataset) -> Iterator[str]:
    """Lines on the numerical error of a boundary and on the model error."""
    names = "velocity_error", "velocity_error_surface", "velocity_error_positions"
    errors, surface, positions = (answer[name].values for name in names)
    is_critical = answer["critical_velocity"].notnull().values
    few_grooves = np.count_nonzero(is_critical & np.isnan(surface))
    if not is_critical.any():
        yield "no numerical error, as no critical velocity lies within the sweep"
    elif np.isfinite(errors).any():
        parts = [
            f", {name} {_percents(part)}"
            for name, part in (("surface sampling", surface), (_PARTS["positions"][0], positions))
            if np.nanmax(part)
        ]
        yield (
            f"numerical error (95 %): ± {_percents(errors)} of the critical velocity"
            f"{''.join(parts)}"
        )
    elif not few_grooves:
        yield "numerical error of the critical velocity: unknown"
    if few_grooves:
        yield (
            f"numerical error unknown at {few_grooves} of {is_critical.sum()} critical velocities: "
            "one surface realization has too few independent grooves; simulate several "
            "(sweep.realizations)"
        )
    yield model_error_line(answer)


def _percents(values: Array) -> str:
    ends = [f"{100 * end:.2g}" for end in (np.nanmin(values), np.nanmax(values))]
    return f"{' to '.join(dict.fromkeys(ends))} %"
