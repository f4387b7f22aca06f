"""The commands on the boundary, and on the verdict on operating points."""

from __future__ import annotations

import argparse
from collections import Counter
from collections.abc import Iterable, Mapping, Sequence
from typing import Any

import numpy as np
import pandas as pd
import xarray as xr

import pipeline
from pipeline.analysis import frames, laboratory
from pipeline.analysis.boundary import turns_left_out
from pipeline.analysis.dataset import (
    Kind,
    count_missing,
    judged_dims,
    read_conditions,
    stored_sweep,
    sweep_kind,
)
from pipeline.analysis.field import Field, fields
from pipeline.analysis.margin import Margin
from pipeline.analysis.margin_frame import LONG, Judged, counts_in_words, judged, margin_frame
from pipeline.analysis.scenes import attribute_values, caveats_of, scenes, words
from pipeline.analysis.tables import as_dict, notes_of, short, upright
from pipeline.analysis.transition import outcomes
from pipeline.cli.given import dataset_in, operating_points_in, table_in, values_in
from pipeline.cli.output import Result, counted, working
from pipeline.quantities import shown_in
from pipeline.scene.along import OperatingPoints
from pipeline.sweep.about import judged_by
from pipeline.sweep.caveats import parted
from pipeline.sweep.remarks import remarks
from pipeline.sweep.severity import MELTS, MOLTEN


def margin(options: argparse.Namespace) -> Result:
    """Print the verdict on one operating point, or on those of a table or of the sweep's rows."""
    is_one = bool(values_in(options, "load", "velocity"))
    points = operating_points_in(options) if is_one else table_in(options)
    ds = dataset_in(options)
    with working("judging operating points"):
        found = [*judged(ds, points)]
    if is_one and len(found) == 1:
        found[0].known()
    table = margin_frame(ds, found, points)
    if is_one:
        document, text = _place_lines(ds, found)
        numbers = table.drop(columns="notes")
        text += ["", upright(numbers) if len(table) == 1 else short(numbers, LONG)]
    else:
        document, text = _table_lines(options, table, points)
    document |= _tell_basis([one.field for one in found], text)
    known = [one for one in found if one.margin]
    document["caveats"] = caveats_of(ds)
    text += [] if is_one else [*notes_of(table, document["caveats"]), *_error_lines(known)]
    document["missing_points"] = missing = count_missing(ds)
    text += frames.missing_lines(missing)
    text += _deciding_lines(known)
    is_molten = is_one and any(one.known().decisive_temperature > MELTS for one in known)
    text += [*remarks("warning", MOLTEN * is_molten), "", *document["caveats"]]
    return Result(document, text, pipeline.warned(ds), [table])


def _deciding_lines(known: Iterable[Judged]) -> list[str]:
    """What kinds of things would decide the verdicts that are not decided, with their counts."""
    kinds = Counter(filter(None, (one.known().decided_by for one in known)))
    if kinds.total() == 1:
        return [f"would decide it: {next(iter(kinds))}"]
    counts = ", ".join(f"{kind} ({count})" for kind, count in kinds.most_common())
    return [f"would decide them: {counts}"] if counts else []


def _place_lines(
    ds: xr.Dataset, found: list[Judged]
) -> tuple[dict[str, Any], list[str | pd.DataFrame]]:
    """Plain data and sentences on one operating point, for each scene."""
    documents, text = list[dict[str, Any]](), list[str | pd.DataFrame]()
    for one in found:
        labels = {name: one.field.shown[name] for name in one.field.shown if name in ds.dims}
        text += [f"{row}:" for row in [words(ds, labels)] if row]
        documents.append(one.known().as_dict() if one.margin else {"note": one.reason})
        text += _margin_lines(one.margin) if one.margin else [one.reason]
    return documents[0] if len(documents) == 1 else {"scenes": documents}, text


def _margin_lines(here: Margin) -> list[str]:
    """The sentence for those who decide, and the parts of the error, in lines."""
    several = "samples" if here.counts_inputs else "surfaces"
    origin = "interpolated between computed points"
    if here.is_computed:
        origin = "computed there"
    elif here.is_continued:
        origin = "extrapolated beyond the computed points, as a power of the velocity"
    elif here.members > 1:
        origin = f"that of {here.members} {several}"
    spread = []
    if interval := here.intervals.get("decisive_temperature"):
        low, high = (shown_in(value, "°C") for value in interval)
        name = "inputs  " if here.counts_inputs else "surfaces"
        spread = [f"  {name}         {low:.4g} to {high:.4g} °C with 90 %"]
    lines = [
        here.sentence,
        f"  numerical error  {here.error.worded}; the decisive temperature is {origin}",
        *spread,
        f"  the model's own  {here.model_error}",
        *remarks("warning", here.misfit),
    ]
    for name in ("velocity", "load"):
        outcome = getattr(here, f"{name}_outcome")
        if outcome not in outcomes(name).values():
            lines.append(f"in {name}: {outcome}")
    return lines


def _table_lines(
    options: argparse.Namespace, frame: pd.DataFrame, points: OperatingPoints | None
) -> tuple[dict[str, Any], list[str | pd.DataFrame]]:
    """Plain data, sentences and a frame on operating points."""
    verdicts = Counter(frame["verdict"])
    said = f"{counted(len(frame), 'operating point', 'operating points')}: {counts_in_words(frame)}"
    shown = [] if options.output else ["", short(frame, LONG)]
    document: dict[str, Any] = {"verdicts": verdicts, "margins": as_dict(frame)}
    if points and points.unused:
        document["columns_not_used"] = [*points.unused]
    if points and points.counted:
        document["rows_read"] = points.counted
    above, remarks = (points.counted, points.remarks) if points else ("", [])
    return document, [*filter(None, [above]), said, *shown, *remarks]


def _error_lines(known: list[Judged]) -> list[str]:
    """What the verdicts of a table rest on."""
    errors = dict.fromkeys(one.known().model_error for one in known)
    misfits = dict.fromkeys(one.known().misfit for one in known)
    return [
        *([f"the model's own error: {' or '.join(errors)}"] if errors else []),
        *remarks("warning", *misfits),
    ]


def _tell_basis(some: Sequence[Field], text: list[str | pd.DataFrame]) -> Mapping[str, Any]:
    """Add what the answers of some fields rest on to the text; return it as plain data."""
    data, lines = some[0].basis if some else ({}, ())
    text += lines
    return data


def boundary(options: argparse.Namespace) -> Result:
    """Print critical velocities and loads, and the band of their errors."""
    ds = dataset_in(options)
    kind = sweep_kind(ds)
    with working("finding the boundary"):
        crossings = pipeline.boundary(ds)
    tests = None
    document = document_of(crossings)
    drawn = stored_sweep(ds).variants.unknown
    text: list[str | pd.DataFrame] = [judged_by(map(read_conditions, scenes(ds)), drawn)]
    for part in frames.boundary_parts(crossings):
        text += ["", part] if isinstance(part, pd.DataFrame) else [part]
    if kind is Kind.SAMPLES:
        document |= _tell_basis(fields(ds), text)
    else:
        document["not_counted"] = left_out = turns_left_out(ds, crossings)
        text += [part for warning in remarks("warning", left_out) for part in ("", warning)]
        # Of several values of a condition none is that of a test which gives none.
        tests = laboratory.compared(ds.isel(dict.fromkeys(judged_dims(ds), 0)))
    if tests is not None:
        text += ["", *laboratory.test_parts(tests)]
        document["tests"] = as_dict(tests)
    text += ["", *document["caveats"]]
    return Result(document, text, pipeline.warned(ds), frames.frames_of(crossings))


def document_of(crossings: xr.Dataset) -> dict[str, Any]:
    """Plain data of `pipeline.boundary`, under its names; outcomes in words."""
    document = {str(name): values.values.tolist() for name, values in crossings.variables.items()}
    for name, axis in frames.BOUNDARIES:
        outcome = f"outcome_at_{axis}"
        if outcome in crossings:
            meanings = outcomes(name.removeprefix("critical_"))
            worded = np.vectorize(meanings.__getitem__, otypes=[object])(crossings[outcome])
            document[outcome] = worded.tolist()
    held = document | crossings.attrs
    names = ("friction", *frames.JUDGED)
    conditions = {name: held[name] for name in names if name in held}
    told = {"conditions": conditions, "model_error": held["model_error"]}
    told["caveats"] = parted(attribute_values(crossings, "caveats"))
    return document | told | {"missing_points": held["missing_points"]}
