"""Facts of an answer: conditions, values, errors, tests, warnings and notes, each as text.

Terminal, report and captions print one list of facts, or those of some names.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Container, Iterator
from typing import NamedTuple

import numpy as np
import xarray as xr

from pipeline.answers.answer_dataset import SIDES
from pipeline.answers.answer_frames import row_labels
from pipeline.answers.error import PARTS
from pipeline.answers.headline import headline, limit_text, probability_line
from pipeline.answers.scene_wording import named_value
from pipeline.answers.value_text import (
    OUTSIDE,
    attribute_texts,
    code_text,
    flag_names,
    format_error,
    range_text,
    split_texts,
    variable_texts,
    verdict_text,
)
from pipeline.messages import listed
from pipeline.quantities import UNITS, in_unit
from pipeline.store.schema import PLANE
from pipeline.sweep.case_table import CASE

HEAD = "mild load factor", "conditions"
"""Names of what is printed above a table."""
ERRORS = "numerical error (95 %)", "model error", "uncertain inputs"
PARTS_OF_ERROR = "parts of the numerical error"
NOTES = "outlier", "verdicts withheld", "points that are pending or failed, and not used", "note"
"""Names of what concerns a whole answer: its tests, missing points, notes."""
_ORIGINS = {
    "simulated": "simulated at this point",
    "interpolated": "interpolated between simulated points",
    "extrapolated": "extrapolated beyond the simulated points by a power law in velocity",
}
_FEW_GROOVES = (
    "one surface realization has too few independent grooves; simulate several, sweep.realizations"
)
"""Reason why the part by surface sampling is unknown."""
_LINE_OUTCOMES = {
    "mild": "none, mild over the whole sweep",
    "severe": "none, severe over the whole sweep",
    "outside the model": OUTSIDE,
}
"""Texts on lines without a critical value."""
_MAX_REASONS = 6


class Fact(NamedTuple):
    """A fact of an answer: its name, and its value with unit and error as text."""

    name: str
    value: str
    is_sentence: bool = False  # the value is a sentence of its own, printed without the name

    def __str__(self) -> str:
        return self.value if self.is_sentence else f"{self.name}: {self.value}"


def point_lines(point: xr.Dataset, has_ends: bool = True) -> list[str]:
    """Lines on one operating point, without those on the whole answer.

    Without `has_ends`, they omit limits beyond the simulated loads and velocities.
    """
    if verdict_text(point) == "unknown":
        return [f"Unknown: {point['reason'].item()}"]
    lines = headline(point, has_ends), probability_line(point), *other_lines(point, NOTES)
    return [*filter(None, lines)]


def fact_lines(answer: xr.Dataset, *names: str) -> list[str]:
    """Lines of the facts of an answer that are called `names`, in this order."""
    by_name = dict[str, list[str]]()
    for fact in facts(answer):
        by_name.setdefault(fact.name, []).append(str(fact))
    return [line for name in names for line in by_name.get(name, ())]


def other_lines(answer: xr.Dataset, names: Container[str]) -> list[str]:
    """Lines of the facts of an answer, except those that are called `names`."""
    return [str(fact) for fact in facts(answer) if fact.name not in names]


def facts(answer: xr.Dataset) -> Iterator[Fact]:
    """Yield the facts of an answer, in the order in which they are printed."""
    for line in load_factor_lines(answer):
        yield Fact("mild load factor", line, is_sentence=True)
    yield from _of_first_case(answer, "conditions")
    yield from _not_included(answer)
    if not answer.sizes:
        yield from _temperatures(answer)
    elif "severe_velocity" in answer and "end_temperature" in answer:
        ends = range_text(in_unit(answer["end_temperature"].values, "°C"), "{:.3g}".format)
        text = f"{ends} °C where the whole pin is at the critical temperature"
        yield Fact("hottest end of the pin", text)
    yield from _numerical_error(answer)
    yield from (*_of_first_case(answer, ERRORS[1]), *_of_first_case(answer, ERRORS[2]))
    if not answer.sizes:
        yield from _critical_values(answer)
    yield from _reasons(answer)
    yield from _rulings(answer)
    yield from _contact_warnings(answer)
    for name, attribute in zip(NOTES, ("outliers", "verdicts_withheld", "", "notes"), strict=True):
        if attribute:
            for text in attribute_texts(answer, attribute):
                yield Fact(name, text, is_sentence=name in ("outlier", "note"))
        elif missing := answer.attrs["missing_points"]:
            yield Fact(name, str(missing))


def _of_first_case(answer: xr.Dataset, name: str) -> Iterator[Fact]:
    """Text of an attribute, of the first case if cases differ in it; none if it is empty."""
    texts = attribute_texts(answer, name.replace(" ", "_"))
    if texts:
        yield Fact(name, f"{texts[0]}; {len(texts) - 1} more" if len(texts) > 1 else texts[0])


def _not_included(answer: xr.Dataset) -> Iterator[Fact]:
    """Effects that are not included and may be unsafe."""
    texts = [answer.attrs["not_included"]] if "not_included" in answer.attrs else []
    texts = texts or answer["not_included"].values.ravel().tolist()
    for text, count in Counter(texts).items():
        cases = "" if count == len(texts) else f" (in {count} of {len(texts)} cases)"
        yield Fact("not included", f"{text}{cases}")


def _temperatures(point: xr.Dataset) -> Iterator[Fact]:
    """Governing temperature of one point with its origin, and that at the end of the pin."""
    origin = _ORIGINS[str(code_text(point["origin"])[()])]
    temperature = variable_texts(point, "governing_temperature").item()
    yield Fact("governing temperature", f"{temperature} °C, {origin}")
    if "end_temperature" in point and point["end_temperature"].notnull():
        end = point["end_temperature"].item()
        excess = end - point["governing_temperature"].item()
        text = f"{abs(excess):.2g} K {'above' if excess >= 0 else 'below'} the whole pin"
        yield Fact("hottest end of the pin", f"{in_unit(end, '°C'):.4g} °C, {text}")


def _numerical_error(answer: xr.Dataset) -> Iterator[Fact]:
    """Numerical error at all points of an answer, or of a boundary; its parts.

    Points without a result, and lines without a critical velocity, have none.
    """
    name, unit, of = "temperature_error", "K", "governing temperature"
    if "velocity_error" in answer:
        name, unit, of = "velocity_error", "%", "critical velocity"
    if name not in answer:
        return
    is_known = answer[of.replace(" ", "_")].notnull().values
    total, *parts = (
        in_unit(answer[variable].values[is_known], unit)
        for variable in (name, *(f"{name}_{part}" for part in PARTS))
    )
    count = np.count_nonzero(np.isnan(total))
    if not total.size:
        yield Fact(ERRORS[0], f"none, as there is no {of}")
    if count < total.size:
        yield Fact(ERRORS[0], f"± {range_text(total, format_error)} {unit} of the {of}")
    by_part = [*zip(PARTS.values(), parts, strict=True)]
    if count:
        unknown = [meaning for meaning, part in by_part if np.isnan(part).any()]
        reasons = " and ".join(unknown)
        if np.isnan(parts[-1]).any():
            reasons = f"{reasons} ({_FEW_GROOVES})"
        where = f" at {count} of {total.size}" if total.size > 1 else ""
        yield Fact(ERRORS[0], f"unknown{where}, because a part is unknown: {reasons}")
    known = [
        f"{meaning} {range_text(part, format_error)} {unit}"
        for meaning, part in by_part
        if np.fmax.reduce(part, initial=0.0) > 0
    ]
    if known:
        yield Fact(PARTS_OF_ERROR, ", ".join(known))


def _critical_values(point: xr.Dataset) -> Iterator[Fact]:
    """Critical velocity and load of one point, or why there is none; limit of friction."""
    for axis in ("velocity", "load"):
        outcome = str(code_text(point[f"outcome_along_{axis}"])[()])
        text = _LINE_OUTCOMES.get(outcome, "")
        if outcome == "transition":
            text = f"{variable_texts(point, f'critical_{axis}').item()} {UNITS[axis]}"
        if text:
            yield Fact(f"critical {axis}", text)
        if axis == "velocity" and (p50 := variable_texts(point, "critical_velocity_p50").item()):
            text = f"{p50} m/s (severe wear is 50 % probable)"
            yield Fact("critical velocity with tests", text)
    if friction := limit_text(point, "friction"):
        yield Fact("limit of friction", friction)


def _reasons(answer: xr.Dataset) -> Iterator[Fact]:
    """Reasons for points without a verdict, each with its first point."""
    if "reason" not in answer or "critical_velocity" not in answer:
        return  # tests state theirs in a column
    axes = (answer[name].broadcast_like(answer["reason"]).values.ravel() for name in PLANE)
    points = dict[str, list[str]]()
    for reason, load, velocity in zip(answer["reason"].values.ravel(), *axes, strict=True):
        points.setdefault(reason, []).append(f"{load:g} N at {velocity:g} m/s")
    points.pop("", None)
    texts = [f"{listed(at, 1)}: {r}" if answer.sizes else r for r, at in points.items()]
    if rest := sum(map(len, [*points.values()][_MAX_REASONS:])):
        texts[_MAX_REASONS:] = [f"{rest} further points; see the column reason of -o TABLE.csv"]
    for text in texts:
        yield Fact("without a verdict", text)


def _rulings(answer: xr.Dataset) -> Iterator[Fact]:
    """Tests that limit the velocities at which wear is mild, or severe, on a boundary."""
    if "ruled_out_by" not in answer:
        return
    texts, loads = xr.broadcast(answer["ruled_out_by"], answer["load"])
    loads_of = dict[str, list[float]]()
    for cell, load in zip(texts.values.ravel(), loads.values.ravel().tolist(), strict=True):
        for text in split_texts([cell]):
            loads_of.setdefault(text, []).append(load)
    for text, ruled_loads in loads_of.items():
        ends = range_text(np.array(ruled_loads), "{:g}".format)
        yield Fact("ruling", f"at {ends} N, {text}", is_sentence=True)


def _contact_warnings(answer: xr.Dataset) -> Iterator[Fact]:
    """Warnings of a contact that reaches an edge, or is severe at an end only, at points."""
    if "warning_flags" not in answer:
        return
    flags, texts = answer["warning_flags"], list[str]()
    if "contact_at_edge" in flag_names(flags, int(np.bitwise_or.reduce(flags.values.ravel()))):
        texts.append("the contact reaches the edge of the window nearby; increase window.pixels")
    if "end_temperature" in answer:
        margin = answer["temperature_margin"]
        critical = answer["governing_temperature"] + margin
        if ((margin > 0) & (answer["end_temperature"] > critical)).any():
            texts.append(
                "the hottest end of the pin is above the critical temperature, but the verdict on "
                "the whole pin is mild; relieve the ends, or let them wear"
            )
    for text in texts:
        at = "at some points, " if flags.ndim else ""
        yield Fact("contact", f"warning: {at}{text}", is_sentence=True)


def load_factor_lines(margins: xr.Dataset) -> Iterator[str]:
    """Lines on the smallest mild load factor of all rows; none without load factors."""
    if "mild_load_factor" not in margins:
        return
    dims = [str(dim) for dim in margins.sizes if dim != CASE]
    for index in np.ndindex(*(margins.sizes[dim] for dim in dims)):
        rows = margins.isel(dict(zip(dims, index, strict=True)))
        conditions = "".join(f" with {named_value(rows[dim])}" for dim in dims)
        yield _load_factor_line(rows, conditions)


def _load_factor_line(rows: xr.Dataset, conditions: str) -> str:
    """Line on the mild load factor of one row, or on the smallest of several."""
    texts = variable_texts(rows, "mild_load_factor").values
    unchanged = "at unchanged bulk temperature and friction"
    if not rows.sizes:
        return f"mild load factor{conditions}: {texts.item()}, {unchanged}"
    if not rows["governs"].any():
        return f"mild load factor{conditions}: no row has one"
    row = int(np.argmax(rows["governs"].values))
    count = int(rows["mild_load_factor_side"].isin(SIDES).sum())
    which = "all rows" if count == len(texts) else f"{count} of {len(texts)} rows"
    return (
        f"mild load factor of {which}{conditions}: {texts[row]}; {row_labels(rows, CASE)[row]} "
        f"governs, {unchanged}"
    )
