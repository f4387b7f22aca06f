"""Sentences on answers, for terminal, figure and report: all are made here, from the datasets."""

from __future__ import annotations

import math
from collections.abc import Iterable, Iterator
from dataclasses import replace
from typing import TYPE_CHECKING, Any

import numpy as np
import xarray as xr

from pipeline.answers.condition_words import unmodelled_rise_words, verdict_conditions
from pipeline.answers.field import Lines, Outcome
from pipeline.answers.preset_error import error_in_words
from pipeline.answers.specimen import specimen_of
from pipeline.constants import LEAST_STATED
from pipeline.quantities import UNITS, display
from pipeline.sweep.left_out import (
    UNKNOWN_FILM,
    caveat_on_turns,
    cold_tracks,
    doubt_lines,
    note_on_ends,
)
from pipeline.words import join_notes, split_notes
from tribo import Corrections
from tribo.simulation.corrections import NEEDED
from tribo.simulation.lubrication import find_lubrication
from tribo.types import Array, Indices, Mask

if TYPE_CHECKING:
    from pipeline.answers.judge import Judge
    from pipeline.answers.tests import Evidence

OUTSIDE = "outside the model: the oil film carries more than a fifth of the load"
FILM_NOT_KNOWN = "whether an oil film carries much of the load is not known here"
_EXACT = "inputs such as the steel's conductivity are taken as exact (irg help model)"
_APART = 0.05  # relative distance of the velocities with tests from which a line names it


ABOUT = ("conditions", "model_error", "patches", "tests", "misfits", "waiting", "notes")
"""Attributes of an answer, which are coordinates where cases differ in them."""


def about(judge: Judge) -> dict[str, str | int]:
    """Attributes of an answer: what holds for all of it, in words."""
    evidence = judge.evidence
    return {
        "conditions": verdict_conditions(judge.conditions, None, judge.case.sweep.tests),
        "model_error": model_error(evidence),
        "patches": len(judge.specimen.apart),
        "tests": len(evidence.specimens),
        "misfits": join_notes(evidence.misfits) or "",
        "waiting": waiting(evidence),
        "notes": join_notes(_notes(judge)) or "",
    }


def _notes(judge: Judge) -> Iterator[str]:
    """Limits that all answers of a case have."""
    case, sweep = judge.case, judge.case.sweep
    has_film = sweep.scene.pin.length is None and find_lubrication(sweep.scene, sweep.lubricant)
    lines = [
        case.note_on_failed, sweep.caveat, *doubt_lines(sweep, answered=True),
        unmodelled_rise_words(judge.conditions), note_on_ends(sweep),
        UNKNOWN_FILM if has_film else None,
        caveat_on_turns(sweep, _with_earlier_turns(judge)), _EXACT,
        error_in_words(sweep) if judge.promised is None else None,
    ]  # fmt: skip
    yield from filter(None, lines)


def _with_earlier_turns(judge: Judge) -> str:
    """From where wear is severe with heat of earlier turns that is left out; empty if unknown."""
    case, tracks = judge.case, cold_tracks(judge.case.sweep)
    if not tracks or not {*NEEDED} <= {*case.ds}:
        return ""
    parts = judge.conditions.corrections or Corrections()
    parts = replace(parts, motion=case.sweep.scene.motion, **tracks)
    conditions = replace(judge.conditions, corrections=parts)
    field = specimen_of(case, conditions, np.zeros(case.status.shape, int)).field
    lines = field.along_velocity(field.loads, np.full(field.loads.shape, judge.limit))
    said = []
    for k in (0, -1):
        if lines.begins_severe[k]:
            said.append(f"at every velocity computed at {field.loads[k]:g} N")
        elif math.isfinite(lines.critical[k]):
            said.append(f"from {lines.critical[k]:.3g} m/s at {field.loads[k]:g} N")
    return ", ".join(said)


def model_error(evidence: Evidence) -> str:
    """How far the model may be off, as a part of the rise, and by how many tests."""
    low, high = (100 * math.expm1(-evidence.posterior.level(p)) for p in (0.95, 0.05))
    signed = [f"{x:+.0f}" if abs(x) >= 10 else f"{x:+.2g}" for x in (low, high)]
    count = len(evidence.specimens)
    tests = "no test" if not count else f"{count} test{'s' * (count > 1)}"
    return f"{' to '.join(signed)} % of the rise (90 %), by {tests} and the prior".replace("-", "−")


def waiting(evidence: Evidence) -> str:
    """Which tests have no result yet, and why; empty if all have one."""
    rows = evidence.waiting
    others = f" and {len(rows) - 1} more" * (len(rows) > 1)
    return f"{rows[0]}{others} {rows[0].reason}" if rows else ""


def beyond(name: str, value: float, low: float, high: float) -> str:
    """Why nothing is known at a load or velocity beyond those of the sweep."""
    unit = UNITS[name]
    return f"{name} is {value:g} {unit}; the sweep has {low:g} to {high:g} {unit}"


def outcomes(lines: Lines, codes: Indices, axis: str, outside: Mask) -> Array:
    """What wear does along each line, in words."""
    found = np.full(codes.shape, "", object)
    for k, code in enumerate(codes.tolist()):
        low, high = (f"{end[k]:.4g} {UNITS[axis]}" for end in (lines.low, lines.high))
        found[k] = {
            Outcome.CROSSES: "crosses",
            Outcome.MILD: "mild throughout",
            Outcome.SEVERE: "severe throughout",
            Outcome.UNKNOWN: "not known yet",
            Outcome.ABOVE: f"mild at every {axis} computed (to {high})",
            Outcome.BELOW: f"severe at every {axis} computed (from {low})",
        }.get(code) or _ranges(lines.places[k], bool(lines.begins_severe[k]), axis)
    found[outside] = OUTSIDE
    return found


def _ranges(places: Array, begins_severe: bool, axis: str) -> str:
    """Ranges of severe wear, from the places at which wear changes."""
    ends = ["" if begins_severe else None, *(f"{x:.3g}" for x in places if math.isfinite(x)), ""]
    ends = [one for one in ends if one is not None]
    unit, parts = UNITS[axis], []
    for begin, end in zip(ends[::2], ends[1::2], strict=False):
        parts.append(
            f"from {begin} to {end} {unit}" if begin and end
            else f"from {begin} {unit} on" if begin else f"up to {end} {unit}"
        )  # fmt: skip
    return f"severe {' and '.join(parts)}"


def percent(probability: float) -> str:
    """A probability in words: a percentage, or "less than 1 %"."""
    if probability < LEAST_STATED:
        return f"less than {100 * LEAST_STATED:g} %"
    if probability > 1 - LEAST_STATED:
        return f"more than {100 * (1 - LEAST_STATED):g} %"
    return f"{100 * probability:.2g} %"


def sentence(here: xr.Dataset) -> str:
    """The verdict on one place, and how likely severe wear is."""
    verdict, distance = here["verdict"].item(), here["distance"].item()
    if verdict == "outside":
        heat = display(here["temperature"].item(), "°C", 4)
        return f"{OUTSIDE[:1].upper()}{OUTSIDE[1:]}; the contact is at {heat}"
    likely = percent(here["probability"].item())
    low, high = here["probability_low"].item(), here["probability_high"].item()
    within = f" ({percent(low)} to {percent(high)})" * (percent(low) != percent(high))
    if math.isnan(here["temperature_error"].item()):
        within = ", numerical error not known"
    side = "below" if distance >= 0 else "above"
    where = f"{abs(distance):.3g} K {side} the critical temperature"
    tests = here["tests_beside"].item()
    tested = f"; tested there: {tests}" * bool(tests)
    return f"{verdict.capitalize()}: severe wear is {likely} likely{within}, {where}{tested}"


def error_text(here: xr.Dataset) -> str:
    """The numerical error of a temperature and its parts."""
    parts = {
        name.removeprefix("error_"): here[name].item()
        for name in map(str, here)
        if name.startswith("error_")
    }
    known = ", ".join(f"{name} {part:.2g} K" for name, part in parts.items() if part > 0)
    if unknown := " and ".join(name for name, part in parts.items() if math.isnan(part)):
        return f"not known, because a part is not: {unknown}" + f" ({known})" * bool(known)
    return f"± {here['temperature_error'].item():.2g} K: {known}"


def decided_by(here: xr.Dataset) -> str:
    """What would decide an undecided verdict; empty if it is decided, or a test forbids it."""
    if here["verdict"].item() != "not decided" or here["reason"].item():
        return ""
    if 0.05 < here["probability"].item() < 0.95:
        beside = here["tests_beside"].item()
        return "a change of conditions or of the scene" if beside else "a test at this point"
    remedies = {
        "interpolation": "more points near it", "preset": "a finer preset",
        "warnings": "what its warnings ask for", "surface": "more patches (sweep.realizations)",
    }  # fmt: skip
    sizes = {name: here[f"error_{name}"].item() for name in remedies}
    return remedies[
        max(sizes, key=lambda name: math.inf if math.isnan(sizes[name]) else sizes[name])
    ]


def margin_lines(here: xr.Dataset) -> Iterator[str]:
    """Lines on one place."""
    if here["verdict"].item() == "not known":
        yield f"Not known: {here['reason'].item()}"
        return
    yield sentence(here)
    yield from (f"  {name:18}  {text}" for name, text in margin_facts(here))
    yield from (f"warning: {text}" for text in margin_warnings(here))


def margin_facts(here: xr.Dataset) -> Iterator[tuple[str, str]]:
    """Yield the name and the value, in words, of each quantity of one place."""
    flagged = _flags(here)
    origin = "extrapolated beyond the computed points" if "extrapolated" in flagged else (
        "interpolated between computed points" if "interpolated" in flagged else "computed there"
    )  # fmt: skip
    yield "judged at", told(here, "conditions")[0]
    yield "temperature", f"{display(here['temperature'].item(), '°C', 4)}, {origin}"
    yield "numerical error", error_text(here)
    yield "model's own error", told(here, "model_error")[0]
    for axis in ("velocity", "load"):
        value, outcome = here[f"critical_{axis}"].item(), here[f"{axis}_outcome"].item()
        if not outcome:
            continue
        said = f"{value:.4g} {UNITS[axis]}, {value / here[axis].item():.3g} times the {axis}"
        said += f"; {outcome}" * (outcome != "crosses")
        yield f"critical {axis}", outcome if math.isnan(value) else said
        tested = here["tested_velocity"].item()
        if axis == "velocity" and not math.isnan(tested):
            yield "with tests", f"{tested:.4g} m/s, where 50 % are severe"
    yield "critical friction", f"{here['critical_friction'].item():.3g}"
    if here["reason"].item():
        yield "no verdict", here["reason"].item()
    if decider := decided_by(here):
        yield "would decide it", decider


def margin_warnings(here: xr.Dataset) -> Iterator[str]:
    """Yield what limits the answer on one place."""
    flagged = _flags(here)
    if "film_not_known" in flagged:
        yield FILM_NOT_KNOWN
    if "ramp_passes_severe" in flagged:
        yield "wear is severe at lower loads at this velocity, through which a ramp passes"
    if "at_edge" in flagged:
        yield "the contact touches the window's edge nearby: give more window.pixels"


def _flags(here: xr.Dataset) -> set[str]:
    """Names of the flags of one place."""
    about = here["caveats"].attrs
    pairs = zip(about["flag_meanings"].split(), about["flag_masks"], strict=True)
    return {name for name, mask in pairs if int(here["caveats"].item()) & mask}


def next_run_line(found: xr.Dataset) -> str:
    """Sentence on the velocities at which a further run is 5, 50 and 95 % likely to be severe.

    They are stated at the lowest and the highest load of a boundary. Those beyond the sweep are
    stated where 50 % are within it.
    """
    said, (lowest, highest) = [], found["velocity"].values[[0, -1]].tolist()
    for load in dict.fromkeys(found["load"].values[[0, -1]].tolist()):
        here = found.sel(load=load)
        names = "tested_velocity_low", "tested_velocity", "tested_velocity_high"
        low, middle, high = (here[name].item() for name in names)
        is_inside, ends = lowest <= middle <= highest, {"5 %": low, "95 %": high}
        if is_inside:
            centre = f"at {middle:.3g} m/s"
        elif math.isnan(middle):
            centre = "at no velocity of the sweep"
        else:
            centre = f"below {lowest:.3g} m/s" if middle < lowest else f"above {highest:.3g} m/s"
        known = {k: x for k, x in ends.items() if lowest <= x <= highest or is_inside}
        likely = ", ".join(f"{k}: {x:.3g} m/s" for k, x in known.items() if math.isfinite(x))
        said.append(f"{centre} at {load:g} N" + f" ({likely})" * bool(likely))
    return f"severe wear is 50 % likely {'; '.join(said)}"


def reason_lines(found: xr.Dataset) -> Iterator[str]:
    """Why places have no verdict, each reason once, with its first place."""
    places = [
        found[name].broadcast_like(found["reason"]).values.ravel() for name in ("load", "velocity")
    ]
    rows = dict[str, list[tuple[float, float]]]()
    for reason, *place in zip(found["reason"].values.ravel(), *places, strict=True):
        rows.setdefault(reason, []).append((place[0], place[1]))
    for reason, here in rows.items():
        if reason:
            more = f" and {len(here) - 1} more" * (len(here) > 1)
            yield f"{here[0][0]:g} N at {here[0][1]:g} m/s{more}: {reason}"


def boundary_lines(found: xr.Dataset) -> Iterator[str]:
    """Lines to print below a boundary: errors, tests, missing points."""
    yield from error_lines(found)
    yield from apart_lines(found)
    yield from common_lines(found)


def error_lines(found: xr.Dataset) -> Iterator[str]:
    """Lines on the numerical error of a boundary and on the model's own."""
    errors = found["velocity_error"].values
    if np.isfinite(errors).any():
        surface = found["velocity_error_surface"].values
        part = f", surface {_percents(surface)}" * bool(np.nanmax(surface))
        yield f"numerical error: ± {_percents(errors)} of the critical velocity (95 %){part}"
    else:
        yield "numerical error: not known"
    yield model_error_line(found)


def model_error_line(found: xr.Dataset) -> str:
    """Line on how far the model may be off: in the first case, and how many others there are."""
    first, *others = told(found, "model_error")
    return f"the model's own error: {first}" + f", and {len(others)} more" * bool(others)


def apart_lines(found: xr.Dataset) -> Iterator[str]:
    """Line on how far the boundary with tests is from the computed one, unless it is near."""
    ratios = (found["tested_velocity"] / found["critical_velocity"]).values.ravel()
    ratios = ratios[np.isfinite(ratios)]
    apart = float(np.median(ratios)) - 1 if ratios.size else 0.0
    if abs(apart) > _APART:
        side = "higher" if apart > 0 else "lower"
        yield f"the tests lie {100 * abs(apart):.0f} % {side} than computed, in velocity"


def common_lines(found: xr.Dataset) -> Iterator[str]:
    """Lines below any answer: tests that do not fit or wait, missing points, limits."""
    yield from test_lines(found)
    if missing := found.attrs["missing_points"]:
        yield f"{missing} points are pending or failed and were left out"
    yield from split_notes(told(found, "notes"))


def test_lines(found: xr.Dataset) -> Iterator[str]:
    """Lines on tests that do not fit the others, and on those without a result."""
    yield from split_notes(told(found, "misfits"))
    yield from (f"not every verdict is given: {why}" for why in told(found, "waiting"))


def judged_at(found: xr.Dataset) -> list[str]:
    """The line with the conditions of an answer; those of the first where rows differ in them."""
    each = told(found, "conditions")
    return [f"judged at {one}" + f"; {len(each) - 1} more" * (len(each) > 1) for one in each[:1]]


def told(found: xr.Dataset, name: str) -> list[str]:
    """Distinct values of an attribute, which is a coordinate where cases differ in it."""
    values: Iterable[Any] = (
        [found.attrs[name]] if name in found.attrs else found[name].values.ravel()
    )
    return [str(value) for value in dict.fromkeys(values) if value]


def _percents(values: Array) -> str:
    ends = [f"{100 * end:.2g}" for end in (np.nanmin(values), np.nanmax(values))]
    return f"{' to '.join(dict.fromkeys(ends))} %"
