"""Lines below an answer: conditions, errors, effects not included, tests, points and notes.

First those below any answer, then those on one operating point, then those on a boundary.
"""

from __future__ import annotations

import math
from collections.abc import Iterator

import numpy as np
import xarray as xr

from pipeline.answers.answer_dataset import SHARP_PERCENTS
from pipeline.answers.readable import (
    OUTSIDE,
    attribute_texts,
    code_text,
    flag_names,
    format_error,
    format_value,
    format_variable,
    outcome_texts,
    probability_text,
    row_labels,
    verdict_text,
)
from pipeline.constants import VERDICT_PROBABILITIES
from pipeline.messages import listed, split_notes
from pipeline.quantities import UNITS, ZERO
from tribo.types import Array

_MAX_REASONS = 6
_MILD_ROWS_BUT_FOR_ENDS = (
    "mild wear may be severe at the pin's sharp ends, which are not modelled and wear severely at "
    "{} to {} % lower velocity"
)
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
_FIRST_COMPUTE = "to reduce the numerical error, {remedy}; if it stays undecided, {test}"
_MIN_SHIFT = 0.05  # relative shift of the boundary by tests above which it is stated
_VELOCITIES = {
    (True, True): "{p50} at {load:g} N (5 %: {p05} m/s, 95 %: {p95} m/s)",
    (True, False): "{p50} at {load:g} N (5 %: {p05} m/s)",
    (False, True): "{p50} at {load:g} N (95 %: {p95} m/s)",
    (False, False): "{p50} at {load:g} N",
}
"""Velocities at which severe wear is probable, by whether 5 and 95 % lie within the sweep."""
_TOO_FEW_GROOVES = (
    "numerical error unknown at {} of {} critical velocities: one surface realization has too few "
    "independent grooves; simulate several (sweep.realizations)"
)


def common_lines(answer: xr.Dataset) -> Iterator[str]:
    """Lines below any answer: outliers, tests without a result, missing points, notes."""
    yield from lines_of_tests(answer)
    if missing := answer.attrs["missing_points"]:
        yield f"points that are pending or failed, and were not used: {missing}"
    yield from split_notes(attribute_texts(answer, "notes"))


def lines_of_tests(answer: xr.Dataset) -> Iterator[str]:
    """Lines on outliers, and on tests without a result."""
    yield from split_notes(attribute_texts(answer, "outliers"))
    yield from withheld_lines(answer)


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
    first, *further_texts = attribute_texts(answer, "model_error")
    if further_texts:
        return f"model error: {first}, and {len(further_texts)} more"
    return f"model error: {first}"


def temperature_error_line(answer: xr.Dataset) -> str:
    """Line on the numerical error of the governing temperature at several points."""
    errors = answer["temperature_error"].values
    if not np.isfinite(errors).any():
        return "numerical error of the governing temperature: unknown"
    ends = dict.fromkeys(map(format_error, (np.nanmin(errors), np.nanmax(errors))))
    return f"numerical error (95 %): ± {' to '.join(ends)} K of the governing temperature"


def not_included_lines(answer: xr.Dataset) -> Iterator[str]:
    """Lines on effects that are not included and may be unsafe."""
    texts = attribute_texts(answer, "not_included")
    if len(texts) < 2 or answer["not_included"].ndim != 1:
        yield from (f"not included: {text}" for text in texts)
        return
    column = answer["not_included"]
    pairs = [*zip(column.values.tolist(), row_labels(answer, str(column.dims[0])), strict=True)]
    for text in texts:
        rows = [label for row_text, label in pairs if row_text == text]
        yield f"not included ({listed(rows)}): {text}"


def reason_lines(answer: xr.Dataset) -> Iterator[str]:
    """Reasons for points without a verdict, each with its first point."""
    axes = [
        answer[name].broadcast_like(answer["reason"]).values.ravel()
        for name in ("load", "velocity")
    ]
    rows = dict[str, list[tuple[float, float]]]()
    for reason, *pair in zip(answer["reason"].values.ravel(), *axes, strict=True):
        rows.setdefault(reason, []).append((pair[0], pair[1]))
    rows.pop("", None)
    for reason, points in [*rows.items()][:_MAX_REASONS]:
        texts = [f"{load:g} N at {velocity:g} m/s" for load, velocity in points]
        yield f"{listed(texts, 1)}: {reason}"
    if rest := sum(map(len, [*rows.values()][_MAX_REASONS:])):
        yield f"further points without a verdict: {rest}; see the column reason of -o TABLE.csv"


def point_warnings(points: xr.Dataset) -> Iterator[str]:
    """Yield the limits of the answer on one point, or on several."""
    flags = points["warning_flags"]
    names = flag_names(flags, int(np.bitwise_or.reduce(flags.values.ravel())))
    if "contact_at_edge" in names:
        yield "the contact reaches the edge of the window nearby; increase window.pixels"
    if "sharp_ends" in names and flags.ndim:
        yield _MILD_ROWS_BUT_FOR_ENDS.format(*SHARP_PERCENTS)


def row_warnings(points: xr.Dataset) -> Iterator[str]:
    """Warnings on several points, each once."""
    yield from (f"warning: at some points {text}" for text in point_warnings(points))


# One operating point


def margin_lines(point: xr.Dataset) -> Iterator[str]:
    """Lines on one operating point."""
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
    margin = format_variable(point, "temperature_margin")
    if margin.startswith("-"):
        return f"{margin[1:]} K above the critical temperature"
    return f"{margin} K below the critical temperature"


def _temperature(point: xr.Dataset) -> str:
    """Governing temperature in °C."""
    celsius = point["governing_temperature"].item() - float(ZERO["°C"])
    return format_value(celsius, point["temperature_error"].item())


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
        if axis == "velocity" and (velocity := format_variable(point, "critical_velocity_p50")):
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
    value = f"{format_variable(point, f'critical_{name}')} {UNITS[name]}".rstrip()
    factor = format_variable(point, f"{name}_safety_factor")
    return f"{value}, safety factor {factor}" if factor else value


def error_text(point: xr.Dataset) -> str:
    """The numerical error of a temperature and its parts."""
    parts = {text: point[f"temperature_error_{name}"].item() for name, text in _PART_LABELS.items()}
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
    sizes = {name: point[f"temperature_error_{name}"].item() for name in _REMEDIES}
    largest = max(sizes, key=lambda name: math.inf if math.isnan(sizes[name]) else sizes[name])
    test = _TESTED_POINT if point["nearby_tests"].item() else _TEST_POINT
    if not mild < middle < severe:
        return _REMEDIES[largest]
    if mild < low and high < severe:
        return test
    return _FIRST_COMPUTE.format(remedy=_REMEDIES[largest], test=test)


# Boundaries


def boundary_lines(answer: xr.Dataset) -> Iterator[str]:
    """Lines below a boundary: effects not included, errors, tests, missing points."""
    yield from not_included_lines(answer)
    yield from ruling_lines(answer)
    yield from error_lines(answer)
    yield from shift_lines(answer)
    yield from common_lines(answer)


def closing_lines(answer: xr.Dataset) -> Iterator[str]:
    """Lines on a boundary after a run: the next specimen, tests, and effects not included."""
    yield next_run_line(answer)
    yield from ruling_lines(answer)
    yield from withheld_lines(answer)
    yield from not_included_lines(answer)


def next_run_line(answer: xr.Dataset) -> str:
    """Sentence on the velocities at which severe wear is 5, 50 and 95 % probable.

    It states them at the lowest and the highest load with a known outcome. If no load has such a
    velocity and all have the same outcome, it states the outcome.
    """
    outcomes = outcome_texts(answer, "velocity").tolist()
    if not any(outcomes):
        return "there is no boundary, as the sweep has a single velocity"
    if len({*outcomes}) == 1 and not answer["critical_velocity_p50"].notnull().any():
        is_of_wear = outcomes[0].startswith(("mild", "severe"))
        return f"wear is {outcomes[0]}" if is_of_wear else f"the boundary is {outcomes[0]}"
    pairs = zip(answer["load"].values.tolist(), outcomes, strict=True)
    loads = [load for load, outcome in pairs if not outcome.startswith("unknown")]
    texts = [_velocities(answer.sel(load=load)) for load in dict.fromkeys((loads[0], loads[-1]))]
    return f"severe wear is 50 % probable at {'; at '.join(texts)}"


def _velocities(at_load: xr.Dataset) -> str:
    """Velocities at a load at which severe wear is 50 % probable, and 5 and 95 %, if known."""
    names = "p05", "p50", "p95"
    texts = {name: format_variable(at_load, f"critical_velocity_{name}") for name in names}
    template = _VELOCITIES[bool(texts["p05"]), bool(texts["p95"])]
    texts["p50"] = f"{texts['p50']} m/s" if texts["p50"] else "no velocity in the sweep"
    return template.format(load=at_load["load"].item(), **texts)


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
    errors, surface = (answer[name].values for name in ("velocity_error", "velocity_error_surface"))
    is_critical = answer["critical_velocity"].notnull().values
    lacks_grooves = is_critical & np.isnan(surface)
    if not is_critical.any():
        yield "no numerical error, as no critical velocity lies within the sweep"
    elif not np.isfinite(errors).any():
        if not lacks_grooves.any():
            yield "numerical error of the critical velocity: unknown"
    elif np.nanmax(surface):
        yield (
            f"numerical error (95 %): ± {_percents(errors)} of the critical velocity, of which "
            f"surface sampling {_percents(surface)}"
        )
    else:
        yield f"numerical error (95 %): ± {_percents(errors)} of the critical velocity"
    if lacks_grooves.any():
        yield _TOO_FEW_GROOVES.format(lacks_grooves.sum(), is_critical.sum())
    yield model_error_line(answer)


def _percents(values: Array) -> str:
    ends = [f"{100 * end:.2g}" for end in (np.nanmin(values), np.nanmax(values))]
    return f"{' to '.join(dict.fromkeys(ends))} %"


def shift_lines(answer: xr.Dataset) -> Iterator[str]:
    """Line on the shift of the boundary by tests, if it is above `_MIN_SHIFT`."""
    ratios = (answer["critical_velocity_p50"] / answer["critical_velocity"]).values.ravel()
    ratios = ratios[np.isfinite(ratios)]
    shift = float(np.median(ratios)) - 1 if ratios.size else 0.0
    size = f"{100 * abs(shift):.0f} %"
    if shift > _MIN_SHIFT:
        yield f"with tests, the boundary lies {size} higher in velocity than computed"
    elif shift < -_MIN_SHIFT:
        yield f"with tests, the boundary lies {size} lower in velocity than computed"
