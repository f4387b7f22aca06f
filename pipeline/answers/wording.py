"""Sentences on answers, from their datasets, for terminal, figure and report."""

from __future__ import annotations

import math
from collections.abc import Iterable, Iterator, Mapping
from dataclasses import replace
from typing import Any

import numpy as np
import xarray as xr

from pipeline.answers.condition_values import NAMES
from pipeline.answers.discretization_error import error_in_words
from pipeline.answers.evidence import Evidence, waiting_text
from pipeline.answers.scene_wording import (
    added_rise_words,
    model_words,
    value_words,
    verdict_conditions,
    warning_lines,
)
from pipeline.answers.specimen import specimen_of
from pipeline.answers.verdict_model import VerdictModel
from pipeline.constants import DECIDED, LEAST_STATED, SHARP_ENDS
from pipeline.messages import join_notes, split_notes
from pipeline.quantities import UNITS, display
from pipeline.store.schema import PLANE
from pipeline.sweep.sweep import cold_tracks, has_sharp_ends
from tribo import Corrections, Fidelity, Scene, Track
from tribo.simulation.corrections import NEEDED
from tribo.types import Array

OUTSIDE = "outside the model, and not safe by this: the oil film carries more than 20 % of the load"
POINT_CONDITIONS = "given for each point"
SHARP_PERCENTS = tuple(round(100 * share) for share in SHARP_ENDS)
_SHARP_ENDS = "sharp pin ends (severe wear at {} to {} % lower velocity)"
_OTHER_MODEL = (
    "warning: the critical temperature is from tests on another kind of surface, wear pattern or "
    "preset than {}; between a random and a measured surface, it differed by 7 to 36 K"
)
_MILD_BUT_FOR_ENDS = (
    "Mild, but perhaps severe at the pin's sharp ends, which are not modelled and wear severely at "
    "{} to {} % lower velocity"
)
_ENDS_OF_SOME = (
    "mild wear may be severe at the pin's sharp ends, which are not modelled and wear severely at "
    "{} to {} % lower velocity"
)
_MAX_NAMED = 6  # rows that a line lists
_NUMBER = tuple("0123456789+-−.")
_MIN_SHIFT = 0.05  # relative shift of the boundary by tests above which it is stated

ATTRIBUTES = (
    "conditions", "model_error", "realizations", "tests", "outliers", "tests_without_result",
    "verdicts_withheld", "not_included", "notes",
)  # fmt: skip
"""Attributes of an answer; they are coordinates if cases differ in them."""


def answer_attributes(model: VerdictModel) -> dict[str, str | int]:
    """Attributes of an answer, as text: its conditions, errors, tests and notes."""
    evidence, tests = model.evidence, model.case.sweep.tests
    from_tests = evidence.critical is not None
    return {
        "conditions": verdict_conditions(model.conditions, tests, from_tests),
        "model_error": model_error(evidence),
        "realizations": len(model.specimen.differences),
        "tests": len(evidence.specimens),
        "outliers": join_notes(evidence.outliers),
        "tests_without_result": waiting_text(evidence),
        "verdicts_withheld": join_notes(filter(None, model.rulings.withheld.values())),
        "not_included": not_included(model),
        "notes": join_notes(_notes(model)),
    }


def not_included(model: VerdictModel) -> str:
    """Effects that are not included and may be unsafe, on one line."""
    sweep = model.case.sweep
    parts = [_SHARP_ENDS.format(*SHARP_PERCENTS)] * has_sharp_ends(sweep)
    parts += _earlier_revolutions(model)
    parts += ["an oil film that carries load (unknown here)"] * model.lacks_film
    parts.append("uncertain inputs")
    if not model.evidence.specimens:
        bias = 100 * model.evidence.prior.bias
        parts.append(f"a model bias beyond the assumed {bias:.3g} %, as no test confirms it")
    return ", ".join(parts)


def _notes(model: VerdictModel) -> Iterator[str]:
    """Limits of all answers of a case, in addition to `not_included`."""
    sweep = model.case.sweep
    unknown = error_in_words(sweep) if model.promised is None else ""
    if model.evidence.critical is not None and _has_tests_of_other_models(model):
        yield _OTHER_MODEL.format(model_words(sweep))
    lines = sweep.note, *warning_lines(sweep, answered=True), added_rise_words(model.conditions)
    yield from filter(None, (*lines, unknown))


def _has_tests_of_other_models(model: VerdictModel) -> bool:
    """True if a test has another kind of surface, wear pattern or settings than the case."""

    def kind(scene: Scene) -> tuple[type, str, Fidelity]:
        pattern = scene.wear.pattern if scene.wear else ""
        return type(scene.roughness), pattern, scene.fidelity

    sweep = model.case.sweep
    return any(kind(test.case.scene) != kind(sweep.scene) for test in sweep.tests)


def _earlier_revolutions(model: VerdictModel) -> Iterator[str]:
    """Heat from earlier revolutions, as text: of bodies with a known track, and of the others."""
    tracks = cold_tracks(model.case.sweep)
    names = {"pin_track": "pin", "track": "disk"}
    known = {name: track for name, track in tracks.items() if track}
    if known:
        bodies = " and ".join(f"the {names[name]}" for name in known)
        warmer = _with_earlier_turns(model, known)
        yield f"heat from earlier revolutions of {bodies}" + f" (severe {warmer})" * bool(warmer)
    for name in tracks.keys() - known.keys():
        entry = f"motion.{names[name]}_track_length"
        yield f"heat from earlier revolutions of the {names[name]} (unknown; set {entry})"


def _with_earlier_turns(model: VerdictModel, tracks: Mapping[str, Track]) -> str:
    """Critical velocities with heat of earlier revolutions of `tracks`, as text; empty if unknown.

    Keys are those of `Corrections`.
    """
    case = model.case
    if not {*NEEDED} <= {*case.ds}:
        return ""
    corrections = model.conditions.corrections or Corrections()
    corrections = replace(corrections, motion=case.sweep.scene.motion, **dict[str, Any](tracks))
    conditions = replace(model.conditions, corrections=corrections)
    field = specimen_of(case, conditions).field
    lines = field.along_velocity(field.loads, np.full(field.loads.shape, model.limit))
    if case.status.size == 1:  # a row with its own load and velocity
        return "with it" * bool(lines.is_severe[0])
    texts = []
    for k in (0, -1):
        if lines.is_severe[k]:
            texts.append(f"at all simulated velocities at {field.loads[k]:g} N")
        elif math.isfinite(lines.critical[k]):
            texts.append(f"from {lines.critical[k]:.3g} m/s at {field.loads[k]:g} N")
    return ", ".join(texts)


def model_error(evidence: Evidence) -> str:
    """Range of the model error relative to the rise, and the number of tests."""
    low, high = (100 * math.expm1(-evidence.posterior.level(p)) for p in (0.95, 0.05))
    signed = [f"{x:+.0f}" if abs(x) >= 10 else f"{x:+.2g}" for x in (low, high)]
    count = len(evidence.specimens)
    tests = f"{count} test{'s' * (count > 1)} and " * bool(count)
    text = f"{' to '.join(signed)} % of the temperature rise (90 % range, from {tests}the prior)"
    return text.replace("-", "−")


# One point or one boundary: from codes to text


def code_text(variable: xr.DataArray) -> Any:
    """Names of the codes of a variable, such as "outside the model"; empty for others."""
    names = variable.attrs["flag_meanings"].replace("outside_model", "outside_the_model").split()
    texts = np.array([name.replace("_", " ") for name in names] + [""], object)
    codes = np.asarray(variable.values)
    return np.asarray(texts[np.where(codes < 0, len(names), codes)], object)


def verdict_text(point: xr.Dataset) -> str:
    """The verdict on one point, as text."""
    return str(code_text(point["verdict"])[()])


_OUTCOMES = {
    "mild": "mild over the whole sweep",
    "severe": "severe over the whole sweep",
    "mild to highest": "mild up to the highest simulated {axis}",
    "severe from lowest": "severe down to the lowest simulated {axis}",
    "unknown": "unknown because too few points are done",
    "outside the model": OUTSIDE,
}


def outcome_texts(answer: xr.Dataset, axis: str) -> Any:
    """Outcome of each line along `axis`, as text; empty where there is no line."""
    codes = code_text(answer[f"outcome_along_{axis}"])
    texts = {"transition": "transition", "no line": "", "": ""}
    texts |= {name: text.format(axis=axis) for name, text in _OUTCOMES.items()}
    return np.vectorize(texts.__getitem__, otypes=[object])(codes)


def probability_text(probability: float) -> str:
    """A probability as text: a percentage, or "less than 1 %"."""
    if probability < LEAST_STATED:
        return f"less than {100 * LEAST_STATED:g} %"
    if probability > 1 - LEAST_STATED:
        return f"more than {100 * (1 - LEAST_STATED):g} %"
    return f"{100 * probability:.2g} %"


def headline(point: xr.Dataset) -> str:
    """The verdict on one point, and the probability of severe wear."""
    verdict, margin = verdict_text(point), point["temperature_margin"].item()
    if verdict == "outside the model":
        temperature = display(point["governing_temperature"].item(), "°C", 4)
        return f"{OUTSIDE[:1].upper()}{OUTSIDE[1:]}; governing temperature {temperature}"
    low, high = point["probability_low"].item(), point["probability_high"].item()
    probability_range = f" ({probability_text(low)} to {probability_text(high)})" * (
        probability_text(low) != probability_text(high)
    )
    if math.isnan(point["temperature_error"].item()):
        probability_range = ", numerical error unknown"
    side = "below" if margin >= 0 else "above"
    where = f"{abs(margin):.3g} K {side} the critical temperature"
    tests = f"; tested nearby: {point['nearby_tests'].item()}" * bool(point["nearby_tests"].item())
    probability = f"probability of severe wear {probability_text(point['probability'].item())}"
    subject = verdict.capitalize()
    if "sharp_ends" in flag_names(point["warning_flags"], point["warning_flags"].item()):
        subject = _MILD_BUT_FOR_ENDS.format(*SHARP_PERCENTS)
    return f"{subject}: {probability}{probability_range}, {where}{tests}"


_REMEDIES = {
    "interpolation": "simulate more points nearby",
    "discretization": "use a finer preset",
    "warnings": "do what the warnings of its points ask for",
    "surface": "simulate more surface realizations (sweep.realizations)",
}
"""What makes each part of the numerical error smaller."""
_TEST_HERE = "run a test at this point"
_FIRST_COMPUTE = "{remedy}, as the numerical error may decide; if it stays undecided, {test}"
_PARTS = {
    "interpolation": "interpolation", "discretization": "discretization", "warnings": "warnings",
    "surface": "surface sampling",
}  # fmt: skip


def error_text(point: xr.Dataset) -> str:
    """The numerical error of a temperature and its parts."""
    parts = {text: point[f"temperature_error_{name}"].item() for name, text in _PARTS.items()}
    known = ", ".join(f"{name} {part:.2g} K" for name, part in parts.items() if part > 0)
    if unknown := " and ".join(name for name, part in parts.items() if math.isnan(part)):
        return f"unknown, because a part is unknown: {unknown}" + f" ({known})" * bool(known)
    return f"± {point['temperature_error'].item():.2g} K: {known}"


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
    test = "change the conditions or the scene" if point["nearby_tests"].item() else _TEST_HERE
    if not mild < middle < severe:
        return _REMEDIES[largest]
    if mild < low and high < severe:
        return test
    return _FIRST_COMPUTE.format(remedy=_REMEDIES[largest], test=test)


def margin_lines(point: xr.Dataset) -> Iterator[str]:
    """Lines on one point."""
    if verdict_text(point) == "unknown":
        yield f"Unknown: {point['reason'].item()}"
        return
    yield headline(point)
    yield from not_included_lines(point)
    yield from (f"  {name:22}  {text}" for name, text in margin_facts(point))
    yield from (f"warning: {text}" for text in margin_warnings(point))


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
        more = f" and {len(rows) - _MAX_NAMED} more" * (len(rows) > _MAX_NAMED)
        yield f"not included ({', '.join(rows[:_MAX_NAMED])}{more}): {text}"


def row_labels(answer: xr.Dataset, row: str) -> list[str]:
    """Label of each row of an answer: the user's first column, else load and velocity.

    `row` is the dimension of the rows.
    """
    hidden = {*PLANE, *ATTRIBUTES, *NAMES}
    user_columns = [
        name for name, array in answer.coords.items() if array.dims == (row,) and name not in hidden
    ]
    if not user_columns:
        points = zip(*(answer[name].values.tolist() for name in PLANE), strict=True)
        return [f"{load:.4g} N, {velocity:.4g} m/s" for load, velocity in points]
    axis = answer[min(user_columns, key=lambda name: name == row)]
    texts = [value_words(axis, value) for value in axis.values.tolist()]
    name = str(axis.name).replace("_", " ").partition(" [")
    named_texts = (f"{name[0]} {text} {name[2][:-1]}".rstrip() for text in texts)
    pairs = zip(texts, named_texts, strict=True)
    return [named_text if text[:1] in _NUMBER else text for text, named_text in pairs]


def margin_facts(point: xr.Dataset) -> Iterator[tuple[str, str]]:
    """Yield the name and the value, as text, of each quantity of one point."""
    origin = {
        "simulated": "simulated at this point",
        "interpolated": "interpolated between simulated points",
        "extrapolated": "extrapolated beyond the simulated points by a power law in velocity",
    }[str(code_text(point["origin"])[()])]
    yield "conditions", attribute_texts(point, "conditions")[0]
    temperature = display(point["governing_temperature"].item(), "°C", 4)
    yield "governing temperature", f"{temperature}, {origin}"
    yield "numerical error (95 %)", error_text(point)
    yield "model error", attribute_texts(point, "model_error")[0]
    for axis in ("velocity", "load"):
        value, outcome = point[f"critical_{axis}"].item(), str(outcome_texts(point, axis)[()])
        if not outcome:
            continue
        text = critical_text(point, axis, f"{value:.4g} {UNITS[axis]}")
        yield f"critical {axis}", outcome if math.isnan(value) else text
        tested_velocity = point["critical_velocity_p50"].item()
        if axis == "velocity" and not math.isnan(tested_velocity):
            yield "with tests", f"{tested_velocity:.4g} m/s (severe wear is 50 % probable)"
    friction = f"{point['critical_friction'].item():.3g}"
    yield "critical friction", critical_text(point, "friction", friction)
    if point["reason"].item():
        yield "verdict withheld", point["reason"].item()
    if advice := to_decide(point):
        yield "to decide", advice


def critical_text(point: xr.Dataset, name: str, value: str) -> str:
    """A critical value, with its safety factor if the point has a verdict."""
    factor = point[f"{name}_safety_factor"].item()
    return value if math.isnan(factor) else f"{value}, safety factor {factor:.3g}"


def margin_warnings(point: xr.Dataset) -> Iterator[str]:
    """Yield the limits of the answer on one point, or on several."""
    flags = point["warning_flags"]
    names = flag_names(flags, int(np.bitwise_or.reduce(flags.values.ravel())))
    if "contact_at_edge" in names:
        yield "the contact reaches the edge of the window nearby; increase window.pixels"
    if "sharp_ends" in names and flags.ndim:
        yield _ENDS_OF_SOME.format(*SHARP_PERCENTS)


def flag_names(variable: xr.DataArray, flags: int) -> list[str]:
    """Names of the flags of a variable that are set in `flags`."""
    pairs = zip(variable.attrs["flag_meanings"].split(), variable.attrs["flag_masks"], strict=True)
    return [name for name, mask in pairs if flags & int(mask)]


def next_run_line(answer: xr.Dataset) -> str:
    """Sentence on the velocities at which severe wear is 5, 50 and 95 % probable.

    It states them at the lowest and the highest load with a known outcome. If no load has such a
    velocity and all have the same outcome, it states the outcome.
    """
    outcomes = outcome_texts(answer, "velocity").tolist()
    if not any(outcomes):
        return "there is no boundary, as the sweep has a single velocity"
    if len({*outcomes}) == 1 and not answer["critical_velocity_p50"].notnull().any():
        subject = "wear" if outcomes[0].startswith(("mild", "severe")) else "the boundary"
        return f"{subject} is {outcomes[0]}"
    pairs = zip(answer["load"].values.tolist(), outcomes, strict=True)
    loads = [load for load, outcome in pairs if not outcome.startswith("unknown")]
    parts = []
    for load in dict.fromkeys((loads[0], loads[-1])):
        at_load = answer.sel(load=load)
        low, middle, high = (at_load[f"critical_velocity_p{p}"].item() for p in ("05", "50", "95"))
        known = {"5 %": low, "95 %": high}
        ends = ", ".join(f"{k}: {x:.3g} m/s" for k, x in known.items() if math.isfinite(x))
        centre = "no velocity in the sweep" if math.isnan(middle) else f"{middle:.3g} m/s"
        parts.append(f"at {centre} at {load:g} N" + f" ({ends})" * bool(ends))
    return f"severe wear is 50 % probable {'; '.join(parts)}"


def closing_lines(answer: xr.Dataset) -> Iterator[str]:
    """Lines on a boundary after a run: the next specimen, tests, and effects not included."""
    yield next_run_line(answer)
    yield from ruling_lines(answer)
    yield from withheld_lines(answer)
    yield from not_included_lines(answer)


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
    for reason, points in [*rows.items()][:_MAX_NAMED]:
        more = f" and {len(points) - 1} more" * (len(points) > 1)
        yield f"{points[0][0]:g} N at {points[0][1]:g} m/s{more}: {reason}"
    if rest := sum(map(len, [*rows.values()][_MAX_NAMED:])):
        yield f"{rest} more points without a verdict: see the column reason of -o TABLE.csv"


def row_warnings(answer: xr.Dataset) -> Iterator[str]:
    """Warnings on several points, each once."""
    yield from (f"warning: at some points {text}" for text in margin_warnings(answer))


def boundary_lines(answer: xr.Dataset) -> Iterator[str]:
    """Lines below a boundary: effects not included, errors, tests, missing points."""
    yield from not_included_lines(answer)
    yield from ruling_lines(answer)
    yield from error_lines(answer)
    yield from shift_lines(answer)
    yield from common_lines(answer)


def error_lines(answer: xr.Dataset) -> Iterator[str]:
    """Lines on the numerical error of a boundary and on the model error."""
    errors = answer["velocity_error"].values
    if np.isfinite(errors).any():
        surface = answer["velocity_error_surface"].values
        part = f", of which surface sampling {_percents(surface)}" * bool(np.nanmax(surface))
        yield f"numerical error (95 %): ± {_percents(errors)} of the critical velocity{part}"
    elif answer["critical_velocity"].notnull().any():
        yield "numerical error of the critical velocity: unknown"
    else:
        yield "numerical error: not stated, as no critical velocity lies within the sweep"
    yield model_error_line(answer)


def temperature_error_line(answer: xr.Dataset) -> str:
    """Line on the numerical error of the governing temperature at several points."""
    errors = answer["temperature_error"].values
    if not np.isfinite(errors).any():
        return "numerical error of the governing temperature: unknown"
    ends = dict.fromkeys(f"{end:.2g}" for end in (np.nanmin(errors), np.nanmax(errors)))
    return f"numerical error (95 %): ± {' to '.join(ends)} K of the governing temperature"


def model_error_line(answer: xr.Dataset) -> str:
    """Line on the model error of the first case, and the number of further cases."""
    first, *rest = attribute_texts(answer, "model_error")
    return f"model error: {first}" + f", and {len(rest)} more" * bool(rest)


def shift_lines(answer: xr.Dataset) -> Iterator[str]:
    """Line on the shift of the boundary by tests, if it is above `_MIN_SHIFT`."""
    ratios = (answer["critical_velocity_p50"] / answer["critical_velocity"]).values.ravel()
    ratios = ratios[np.isfinite(ratios)]
    shift = float(np.median(ratios)) - 1 if ratios.size else 0.0
    if abs(shift) > _MIN_SHIFT:
        side = "higher" if shift > 0 else "lower"
        size = f"{100 * abs(shift):.0f} %"
        yield f"with tests, the boundary lies {size} {side} in velocity than computed"


def common_lines(answer: xr.Dataset) -> Iterator[str]:
    """Lines below any answer: outliers, tests without a result, missing points, notes."""
    yield from test_lines(answer)
    if missing := answer.attrs["missing_points"]:
        yield f"{missing} points are pending or failed and were not used"
    yield from split_notes(attribute_texts(answer, "notes"))


def test_lines(answer: xr.Dataset) -> Iterator[str]:
    """Lines on outliers, and on tests without a result."""
    yield from split_notes(attribute_texts(answer, "outliers"))
    yield from withheld_lines(answer)


def withheld_lines(answer: xr.Dataset) -> Iterator[str]:
    """Lines on verdicts that are withheld because tests have no result, or one outcome only."""
    yield from (
        f"some verdicts are withheld: {reason}"
        for reason in split_notes(attribute_texts(answer, "verdicts_withheld"))
    )


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


def conditions_lines(answer: xr.Dataset) -> list[str]:
    """Line with the conditions of an answer, of its first row if rows differ in them."""
    texts = attribute_texts(answer, "conditions")
    return [
        f"conditions: {text}" + f"; {len(texts) - 1} more" * (len(texts) > 1) for text in texts[:1]
    ]


def attribute_texts(answer: xr.Dataset, name: str) -> list[str]:
    """Distinct values of an attribute; it is a coordinate if cases differ in it."""
    values: Iterable[Any] = (
        [answer.attrs[name]] if name in answer.attrs else answer[name].values.ravel()
    )
    return [str(value) for value in dict.fromkeys(values) if value]


def _percents(values: Array) -> str:
    ends = [f"{100 * end:.2g}" for end in (np.nanmin(values), np.nanmax(values))]
    return f"{' to '.join(dict.fromkeys(ends))} %"
