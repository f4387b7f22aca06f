"""Sentences on answers, for terminal, figure and report: all are made here, from the datasets."""

from __future__ import annotations

import math
from collections.abc import Iterable, Iterator, Mapping
from dataclasses import replace
from typing import TYPE_CHECKING, Any

import numpy as np
import xarray as xr

from pipeline.answers.conditions import NAMES
from pipeline.answers.discretization_error import error_in_words
from pipeline.answers.scene_words import (
    added_rise_words,
    value_words,
    verdict_conditions,
    warning_lines,
)
from pipeline.answers.specimen import specimen_of
from pipeline.answers.tests import waiting_text
from pipeline.constants import LEAST_STATED
from pipeline.quantities import UNITS, display
from pipeline.store.schema import PLANE
from pipeline.sweep.left_out import cold_tracks, has_sharp_ends
from pipeline.words import join_notes, split_notes
from tribo import Corrections
from tribo.simulation.corrections import NEEDED
from tribo.types import Array

if TYPE_CHECKING:
    from pipeline.answers.tests import Evidence
    from pipeline.answers.verdict import VerdictModel

OUTSIDE = "outside the model, and not safe by this: the oil film carries more than 20 % of the load"
OWN_CONDITIONS = "given for each point"
TOO_FEW = "too few points nearby are done; finish the run, or add points there"
_MOST_NAMED = 6  # rows that a line names
_NUMBER = tuple("0123456789+-−.")
_SHIFT = 0.05  # relative distance of the velocities with tests from which a line names it

ABOUT = (
    "conditions", "model_error", "realizations", "tests", "outliers", "tests_without_result",
    "not_included", "notes",
)  # fmt: skip
"""Attributes of an answer, which are coordinates where cases differ in them."""


def about(model: VerdictModel) -> dict[str, str | int]:
    """Attributes of an answer: what holds for all of it, in words."""
    evidence, tests = model.evidence, model.case.sweep.tests
    from_tests = evidence.critical is not None
    return {
        "conditions": verdict_conditions(model.conditions, tests, from_tests),
        "model_error": model_error(evidence),
        "realizations": len(model.specimen.apart),
        "tests": len(evidence.specimens),
        "outliers": join_notes(evidence.outliers),
        "tests_without_result": waiting_text(evidence),
        "not_included": not_included(model),
        "notes": join_notes(_notes(model)),
    }


def not_included(model: VerdictModel) -> str:
    """What is not included on the unsafe side, where a scene has it, on one line."""
    sweep = model.case.sweep
    parts = ["sharp pin ends (severe wear at 9 to 23 % lower velocity)"] * has_sharp_ends(sweep)
    if cold_tracks(sweep):
        warmer = _with_earlier_turns(model)
        parts.append("heat from earlier revolutions" + f" (severe {warmer})" * bool(warmer))
    parts += ["an oil film that carries load (unknown here)"] * model.lacks_film
    parts.append("uncertain inputs")
    if not model.evidence.specimens:
        bias = 100 * model.evidence.prior.bias
        parts.append(f"a model bias beyond the assumed {bias:.3g} %, as no test confirms it")
    return ", ".join(parts)


def _notes(model: VerdictModel) -> Iterator[str]:
    """Limits that all answers of a case have, beside `not_included`."""
    sweep = model.case.sweep
    unknown = error_in_words(sweep) if model.promised is None else ""
    lines = sweep.note, *warning_lines(sweep, answered=True), added_rise_words(model.conditions)
    yield from filter(None, (*lines, unknown))


def _with_earlier_turns(model: VerdictModel) -> str:
    """From where wear is severe with heat of earlier revolutions; empty if unknown."""
    case, tracks = model.case, cold_tracks(model.case.sweep)
    if not {*NEEDED} <= {*case.ds}:
        return ""
    parts = model.conditions.corrections or Corrections()
    parts = replace(parts, motion=case.sweep.scene.motion, **tracks)
    conditions = replace(model.conditions, corrections=parts)
    field = specimen_of(case, conditions).field
    lines = field.along_velocity(field.loads, np.full(field.loads.shape, model.limit))
    if case.status.size == 1:  # a row with its own load and velocity
        return "with it" * bool(lines.severe_at_start[0])
    said = []
    for k in (0, -1):
        if lines.severe_at_start[k]:
            said.append(f"at all simulated velocities at {field.loads[k]:g} N")
        elif math.isfinite(lines.critical[k]):
            said.append(f"from {lines.critical[k]:.3g} m/s at {field.loads[k]:g} N")
    return ", ".join(said)


def model_error(evidence: Evidence) -> str:
    """How far the model may be off, as a part of the rise, and by how many tests."""
    low, high = (100 * math.expm1(-evidence.posterior.level(p)) for p in (0.95, 0.05))
    signed = [f"{x:+.0f}" if abs(x) >= 10 else f"{x:+.2g}" for x in (low, high)]
    count = len(evidence.specimens)
    tests = f"{count} test{'s' * (count > 1)} and " * bool(count)
    said = f"{' to '.join(signed)} % of the temperature rise (90 % range, from {tests}the prior)"
    return said.replace("-", "−")


def outside(ends: Mapping[str, tuple[float, float]], **place: float) -> str:
    """Why nothing is known at a load and a velocity; empty if they lie within the `ends`."""
    said = []
    for name, value in place.items():
        (low, high), unit = ends[name], UNITS[name]
        if not (low <= value <= high and value > 0):
            within = f"({low:g} to {high:g} {unit})"
            said.append(f"{name} {value:g} {unit} is outside the sweep {within}")
    is_able = all(0 < value < math.inf for value in place.values())
    advice = "add it to the scene, and run it again" if is_able else "give a value inside it"
    return f"{', '.join(said)}; {advice}" if said else ""


# One point or one boundary: from codes to text


def code_text(variable: xr.DataArray) -> Any:
    """Names of the codes of a variable, such as "outside the model"; empty for others."""
    names = variable.attrs["flag_meanings"].replace("outside_model", "outside_the_model").split()
    found = np.array([one.replace("_", " ") for one in names] + [""], object)
    codes = np.asarray(variable.values)
    return np.asarray(found[np.where(codes < 0, len(names), codes)], object)


def verdict_text(here: xr.Dataset) -> str:
    """The verdict on one point, as text."""
    return str(code_text(here["verdict"])[()])


_OUTCOMES = {
    "mild": "mild over the whole sweep",
    "severe": "severe over the whole sweep",
    "mild to highest": "mild up to the highest simulated {axis}",
    "severe from lowest": "severe down to the lowest simulated {axis}",
    "several": "severe at one {axis} and mild again at a higher one",
    "unknown": "unknown because too few points are done",
    "outside the model": OUTSIDE,
}


def outcome_texts(found: xr.Dataset, axis: str) -> Any:
    """Outcome of each line along `axis`, as text; empty where there is no line."""
    codes = code_text(found[f"outcome_along_{axis}"])
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


def headline(here: xr.Dataset) -> str:
    """The verdict on one point, and the probability of severe wear."""
    verdict, margin = verdict_text(here), here["temperature_margin"].item()
    if verdict == "outside the model":
        heat = display(here["governing_temperature"].item(), "°C", 4)
        return f"{OUTSIDE[:1].upper()}{OUTSIDE[1:]}; governing temperature {heat}"
    low, high = here["probability_low"].item(), here["probability_high"].item()
    within = f" ({probability_text(low)} to {probability_text(high)})" * (
        probability_text(low) != probability_text(high)
    )
    if math.isnan(here["temperature_error"].item()):
        within = ", numerical error unknown"
    side = "below" if margin >= 0 else "above"
    where = f"{abs(margin):.3g} K {side} the critical temperature"
    tests = f"; tested nearby: {here['nearby_tests'].item()}" * bool(here["nearby_tests"].item())
    likely = f"probability of severe wear {probability_text(here['probability'].item())}"
    return f"{verdict.capitalize()}: {likely}{within}, {where}{tests}"


_PARTS = {
    "interpolation": "interpolation", "discretization": "discretization", "warnings": "warnings",
    "surface": "surface sampling",
}  # fmt: skip


def error_text(here: xr.Dataset) -> str:
    """The numerical error of a temperature and its parts."""
    parts = {text: here[f"temperature_error_{name}"].item() for name, text in _PARTS.items()}
    known = ", ".join(f"{name} {part:.2g} K" for name, part in parts.items() if part > 0)
    if unknown := " and ".join(name for name, part in parts.items() if math.isnan(part)):
        return f"unknown, because a part is unknown: {unknown}" + f" ({known})" * bool(known)
    return f"± {here['temperature_error'].item():.2g} K: {known}"


def to_decide(here: xr.Dataset) -> str:
    """What would decide an undecided verdict; empty if it is decided, or ruled out by a test."""
    if verdict_text(here) != "undecided" or here["reason"].item():
        return ""
    if 0.05 < here["probability"].item() < 0.95:
        tested = here["nearby_tests"].item()
        return "change the conditions or the scene" if tested else "run a test at this point"
    remedies = {
        "interpolation": "simulate more points nearby", "discretization": "use a finer preset",
        "warnings": "do what the warnings of its points ask for",
        "surface": "simulate more surface realizations (sweep.realizations)",
    }  # fmt: skip
    sizes = {name: here[f"temperature_error_{name}"].item() for name in remedies}
    return remedies[
        max(sizes, key=lambda name: math.inf if math.isnan(sizes[name]) else sizes[name])
    ]


def margin_lines(here: xr.Dataset) -> Iterator[str]:
    """Lines on one point."""
    if verdict_text(here) == "unknown":
        yield f"Unknown: {here['reason'].item()}"
        return
    yield headline(here)
    yield from not_included_lines(here)
    yield from (f"  {name:22}  {text}" for name, text in margin_facts(here))
    yield from (f"warning: {text}" for text in margin_warnings(here))


def not_included_lines(found: xr.Dataset) -> Iterator[str]:
    """The line below a verdict or a boundary on what is not included on the unsafe side."""
    texts = attribute_texts(found, "not_included")
    if len(texts) < 2 or found["not_included"].ndim != 1:
        yield from (f"not included: {one}" for one in texts)
        return
    one = found["not_included"]
    each = [*zip(one.values.tolist(), row_labels(found, str(one.dims[0])), strict=True)]
    for text in texts:
        rows = [label for own, label in each if own == text]
        more = f" and {len(rows) - _MOST_NAMED} more" * (len(rows) > _MOST_NAMED)
        yield f"not included ({', '.join(rows[:_MOST_NAMED])}{more}): {text}"


def row_labels(found: xr.Dataset, row: str) -> list[str]:
    """Label of each row of an answer: its first column of the user's own, else load and velocity.

    `row` is the dimension of the rows.
    """
    hidden = {*PLANE, *ABOUT, *NAMES}
    own = [name for name, one in found.coords.items() if one.dims == (row,) and name not in hidden]
    if not own:
        places = zip(*(found[name].values.tolist() for name in PLANE), strict=True)
        return [f"{load:.4g} N, {velocity:.4g} m/s" for load, velocity in places]
    axis = found[min(own, key=lambda name: name == row)]
    texts = [value_words(axis, one) for one in axis.values.tolist()]
    name = str(axis.name).replace("_", " ").partition(" [")
    named = (f"{name[0]} {one} {name[2][:-1]}".rstrip() for one in texts)
    return [many if one[:1] in _NUMBER else one for one, many in zip(texts, named, strict=True)]


def margin_facts(here: xr.Dataset) -> Iterator[tuple[str, str]]:
    """Yield the name and the value, as text, of each quantity of one point."""
    origin = {
        "simulated": "simulated at this point",
        "interpolated": "interpolated between simulated points",
        "extrapolated": "extrapolated beyond the simulated points by a power law in velocity",
    }[str(code_text(here["origin"])[()])]
    yield "conditions", attribute_texts(here, "conditions")[0]
    heat = display(here["governing_temperature"].item(), "°C", 4)
    yield "governing temperature", f"{heat}, {origin}"
    yield "numerical error (95 %)", error_text(here)
    yield "model error", attribute_texts(here, "model_error")[0]
    for axis in ("velocity", "load"):
        value, outcome = here[f"critical_{axis}"].item(), str(outcome_texts(here, axis)[()])
        if not outcome:
            continue
        ratio = f"{value / here[axis].item():.3g} times the operating {axis}"
        said = f"{value:.4g} {UNITS[axis]}, {ratio}" + f"; {outcome}" * (outcome != "transition")
        yield f"critical {axis}", outcome if math.isnan(value) else said
        tested = here["critical_velocity_p50"].item()
        if axis == "velocity" and not math.isnan(tested):
            yield "with tests", f"{tested:.4g} m/s (severe wear is 50 % probable)"
    yield "critical friction", f"{here['critical_friction'].item():.3g}"
    if here["reason"].item():
        yield "verdict withheld", here["reason"].item()
    if advice := to_decide(here):
        yield "to decide", advice


def margin_warnings(here: xr.Dataset) -> Iterator[str]:
    """Yield what limits the answer on one point."""
    one = here["warning_flags"]
    flagged = flag_names(one, int(np.bitwise_or.reduce(one.values.ravel())))
    if "ramp_passes_severe" in flagged:
        yield "wear is severe at lower loads at this velocity, through which a load ramp passes"
    if "contact_at_edge" in flagged:
        yield "the contact reaches the edge of the window nearby; increase window.pixels"


def flag_names(variable: xr.DataArray, flags: int) -> list[str]:
    """Names of the flags of a variable that are set in `flags`."""
    pairs = zip(variable.attrs["flag_meanings"].split(), variable.attrs["flag_masks"], strict=True)
    return [name for name, mask in pairs if flags & int(mask)]


def next_run_line(found: xr.Dataset) -> str:
    """Sentence on the velocities at which severe wear is 5, 50 and 95 % probable.

    They are stated at the lowest and the highest load of a boundary whose points are done. Without
    any such velocity, the sentence states the outcome that all loads have.
    """
    outcomes = outcome_texts(found, "velocity").tolist()
    if len({*outcomes}) == 1 and not found["critical_velocity_p50"].notnull().any():
        subject = "wear" if outcomes[0].startswith(("mild", "severe")) else "the boundary"
        return f"{subject} is {outcomes[0]}"
    pairs = zip(found["load"].values.tolist(), outcomes, strict=True)
    loads = [load for load, outcome in pairs if not outcome.startswith("unknown")]
    said = []
    for load in dict.fromkeys((loads[0], loads[-1])):
        here = found.sel(load=load)
        low, middle, high = (here[f"critical_velocity_p{p}"].item() for p in ("05", "50", "95"))
        known = {"5 %": low, "95 %": high}
        ends = ", ".join(f"{k}: {x:.3g} m/s" for k, x in known.items() if math.isfinite(x))
        centre = "no velocity in the sweep" if math.isnan(middle) else f"{middle:.3g} m/s"
        said.append(f"at {centre} at {load:g} N" + f" ({ends})" * bool(ends))
    return f"severe wear is 50 % probable {'; '.join(said)}"


def reason_lines(found: xr.Dataset) -> Iterator[str]:
    """Why points have no verdict, each reason once, with its first point."""
    places = [
        found[name].broadcast_like(found["reason"]).values.ravel() for name in ("load", "velocity")
    ]
    rows = dict[str, list[tuple[float, float]]]()
    for reason, *place in zip(found["reason"].values.ravel(), *places, strict=True):
        rows.setdefault(reason, []).append((place[0], place[1]))
    rows.pop("", None)
    for reason, here in [*rows.items()][:_MOST_NAMED]:
        more = f" and {len(here) - 1} more" * (len(here) > 1)
        yield f"{here[0][0]:g} N at {here[0][1]:g} m/s{more}: {reason}"
    if others := sum(map(len, [*rows.values()][_MOST_NAMED:])):
        yield f"{others} more points without a verdict: see the column reason of -o TABLE.csv"


def row_warnings(found: xr.Dataset) -> Iterator[str]:
    """Warnings on several points, each once."""
    yield from (f"warning: at some points {text}" for text in margin_warnings(found))


def boundary_lines(found: xr.Dataset) -> Iterator[str]:
    """Lines to print below a boundary: what is not included, errors, tests, missing points."""
    yield from not_included_lines(found)
    yield from error_lines(found)
    yield from shift_lines(found)
    yield from common_lines(found)


def error_lines(found: xr.Dataset) -> Iterator[str]:
    """Lines on the numerical error of a boundary and on the model error."""
    errors = found["velocity_error"].values
    if np.isfinite(errors).any():
        surface = found["velocity_error_surface"].values
        part = f", of which surface sampling {_percents(surface)}" * bool(np.nanmax(surface))
        yield f"numerical error (95 %): ± {_percents(errors)} of the critical velocity{part}"
    elif found["critical_velocity"].notnull().any():
        yield "numerical error of the critical velocity: unknown"
    else:
        yield "numerical error: not stated, as no critical velocity lies within the sweep"
    yield model_error_line(found)


def model_error_line(found: xr.Dataset) -> str:
    """Line on how far the model may be off: in the first case, and how many others there are."""
    first, *others = attribute_texts(found, "model_error")
    return f"model error: {first}" + f", and {len(others)} more" * bool(others)


def shift_lines(found: xr.Dataset) -> Iterator[str]:
    """Line on how far the boundary with tests is from the computed one, unless it is near."""
    ratios = (found["critical_velocity_p50"] / found["critical_velocity"]).values.ravel()
    ratios = ratios[np.isfinite(ratios)]
    shift = float(np.median(ratios)) - 1 if ratios.size else 0.0
    if abs(shift) > _SHIFT:
        side = "higher" if shift > 0 else "lower"
        size = f"{100 * abs(shift):.0f} %"
        yield f"with tests, the boundary lies {size} {side} in velocity than computed"


def common_lines(found: xr.Dataset) -> Iterator[str]:
    """Lines below any answer: tests that do not fit or wait, missing points, limits."""
    yield from test_lines(found)
    if missing := found.attrs["missing_points"]:
        yield f"{missing} points are pending or failed and were not used"
    yield from split_notes(attribute_texts(found, "notes"))


def test_lines(found: xr.Dataset) -> Iterator[str]:
    """Lines on tests that do not fit the others, and on those without a result."""
    yield from split_notes(attribute_texts(found, "outliers"))
    yield from withheld_lines(found)


def withheld_lines(found: xr.Dataset) -> Iterator[str]:
    """Lines on verdicts that are withheld, as tests have no result."""
    yield from (
        f"some verdicts are withheld: {why}"
        for why in attribute_texts(found, "tests_without_result")
    )


def conditions_lines(found: xr.Dataset) -> list[str]:
    """The line with the conditions of an answer; those of the first where rows differ in them."""
    each = attribute_texts(found, "conditions")
    return [f"conditions: {one}" + f"; {len(each) - 1} more" * (len(each) > 1) for one in each[:1]]


def attribute_texts(found: xr.Dataset, name: str) -> list[str]:
    """Distinct values of an attribute, which is a coordinate where cases differ in it."""
    values: Iterable[Any] = (
        [found.attrs[name]] if name in found.attrs else found[name].values.ravel()
    )
    return [str(value) for value in dict.fromkeys(values) if value]


def _percents(values: Array) -> str:
    ends = [f"{100 * end:.2g}" for end in (np.nanmin(values), np.nanmax(values))]
    return f"{' to '.join(dict.fromkeys(ends))} %"
