"""The commands on the boundary, and on the distance of operating points from severe wear."""

from __future__ import annotations

import argparse
import itertools
from collections import Counter
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd
import xarray as xr

import pipeline
from pipeline.analysis import frames
from pipeline.analysis.dataset import has_plane, stored_sweep
from pipeline.analysis.decisive import conditions_of
from pipeline.analysis.margin import NOT_DECIDED, Margin
from pipeline.analysis.margins import LONG, in_counts, margins_at, notes_of
from pipeline.analysis.scenes import parts_of, scenes, words
from pipeline.analysis.tables import as_dict, short, upright
from pipeline.analysis.transition import BEYOND, CROSSES, UNITS, UNKNOWN, in_words, outcomes
from pipeline.analysis.warned_points import turns_left_out
from pipeline.cli.given import (
    by_samples,
    conditions_in,
    dataset_in,
    operating_points_in,
    table_in,
    values_in,
)
from pipeline.cli.next_steps import after_boundary, commands_that_decide, lines_on, more_of_boundary
from pipeline.cli.output import Result, counted
from pipeline.cli.unknowns import boundary_of_samples, frame_of_intervals, on_risk, samples_in
from pipeline.scene.along import OperatingPoints
from pipeline.sweep.about import judged_by
from pipeline.sweep.conditions import Conditions
from pipeline.sweep.severity import MELTS, MOLTEN
from pipeline.sweep.variants import PLACE
from tribo import InputError


def margin(options: argparse.Namespace) -> Result:
    """Print the distance of one operating point to the boundary, or of those of a table."""
    place = values_in(options, "load", "velocity")
    points = operating_points_in(options) if place else table_in(options)
    ds, conditions = dataset_in(options), conditions_in(options)
    if by_samples(options, ds):
        # Samples have none themselves.
        return _of_samples(options, ds, conditions, points or operating_points_in(options))
    if place:
        here = pipeline.margins(ds, options.load, options.velocity, **conditions)
    table = pipeline.margin_table(ds, points, **conditions)
    if place:
        document, text = _on_place(ds, here)
        text += ["", upright(table) if len(table) == 1 else short(table, LONG)]
    else:
        if table.empty:
            operating_points_in(options)  # which says that there is none
        document, text = _on_points(options, table, points)
    found = [*margins_at(ds, points, **conditions)]
    margins = [one for _, one in found]
    undecided = dict[Conditions, list[Margin]]()
    for judged, one in found:
        if one.verdict == NOT_DECIDED:
            undecided.setdefault(judged, []).append(one)
    is_incomplete = bool(place) and any(map(_is_incomplete, margins))
    commands = (
        command
        for judged, some in undecided.items()
        for command in commands_that_decide(ds, options.store, some, judged.as_dict())
    )
    document["next"] = [*dict.fromkeys(commands)]
    text += lines_on(document["next"]) if undecided else ()
    if place:
        if any(one.decisive_temperature > MELTS for one in margins):
            text.append(f"warning: {MOLTEN}")
        document["command"] = None
        if is_incomplete:
            own = conditions_of(ds, **conditions).as_dict()
            document["command"] = more_of_boundary(ds, options.store, own)
            text.append(f"compute more of the boundary with: {document['command']}")
    return Result(document, text, pipeline.warned(ds, **conditions), [table])


def _on_place(
    ds: xr.Dataset, margins: Sequence[Margin]
) -> tuple[dict[str, Any], list[str | pd.DataFrame]]:
    """Plain data and sentences on one operating point, on its surfaces, for each scene."""
    documents, text = list[dict[str, Any]](), list[str | pd.DataFrame]()
    for entries, group in itertools.groupby(margins, lambda one: one.entries):
        part = tuple(group)
        text += [f"{row}:" for row in [words(ds, entries)] if row]
        document, lines = _on_surfaces(part) if part[1:] else _on_one(part[0])
        documents.append(document)
        text += lines
    return documents[0] if len(documents) == 1 else {"scenes": documents}, text


def _of_samples(
    options: argparse.Namespace,
    ds: xr.Dataset,
    conditions: dict[str, Any],
    points: OperatingPoints,
) -> Result:
    """Distances of operating points as intervals of probability."""
    samples = samples_in(options, ds, **conditions)
    ensemble, draws = samples.ensemble, samples.draws
    if options.points is None:
        answer = pipeline.margin_intervals(ensemble, options.load, options.velocity, draws)
        table = frame_of_intervals(answer)
        text: list[str | pd.DataFrame] = [on_risk(answer.risk), table]
        document: dict[str, Any] = {"intervals": answer.as_dict()}
    else:
        table = pipeline.risk_table(ensemble, points, draws)
        document, text = _on_points(options, table, points)
    document |= samples.as_dict()
    return Result(document, [*text, *samples.notes()], pipeline.warned(ds), [table])


def _on_points(
    options: argparse.Namespace, frame: pd.DataFrame, points: OperatingPoints | None
) -> tuple[dict[str, Any], list[str | pd.DataFrame]]:
    """Plain data, sentences and a frame on operating points."""
    verdicts = Counter(frame["verdict"])
    said = f"{counted(len(frame), 'operating point', 'operating points')}: {in_counts(frame)}"
    shown = [] if options.output else ["", short(frame, LONG)]
    document: dict[str, Any] = {"verdicts": verdicts, "margins": as_dict(frame)}
    if points and points.unused:
        document["columns_not_used"] = [*points.unused]
    remarks = points.remarks if points else []
    return document, [said, *shown, *notes_of(frame), *remarks]


def _is_incomplete(here: Margin) -> bool:
    """A transition beyond the computed points, or across some that are not done."""
    found = {"velocity": here.velocity_outcome, "load": here.load_outcome}
    is_beyond = any(outcomes(axis)[code] == found[axis] for axis in found for code in BEYOND)
    return is_beyond or here.velocity_bridged + here.load_bridged > 0


def _on_one(here: Margin) -> tuple[dict[str, Any], list[str]]:
    """Plain data on one surface; in lines its verdict, its error and missing transitions."""
    wear = "" if here.verdict == NOT_DECIDED else " wear"
    origin = "interpolated between computed points"
    if here.is_computed:
        origin = "computed there"
    elif here.is_continued:
        origin = "extrapolated beyond the computed points, as a power of the velocity"
    lines = [
        f"{here.load:g} N at {here.velocity:g} m/s: {here.verdict}{wear}",
        f"the decisive temperature is {origin}; its error is {here.error.worded}",
    ]
    for name in UNITS:
        outcome = getattr(here, f"{name}_outcome")
        said = in_words(outcome, getattr(here, f"{name}_range"), name)
        if said != outcome:
            lines.append(f"in {name}: {said}")
    return here.as_dict(), lines


def _on_surfaces(margins: Sequence[Margin]) -> tuple[dict[str, Any], list[str]]:
    """Plain data on several surfaces, and a sentence."""
    load, velocity = margins[0].load, margins[0].velocity
    counts = Counter(one.verdict for one in margins)
    severe, undecided = counts["severe"], counts[NOT_DECIDED]
    said = f"{load:g} N at {velocity:g} m/s: severe wear on {severe} of {len(margins)} surfaces"
    document = {
        "load": load,
        "velocity": velocity,
        "severe_surfaces": severe,
        "undecided_surfaces": undecided,
        "surfaces": [one.as_dict() for one in margins],
    }
    return document, [said + (f", not decided on {undecided}" if undecided else "")]


def boundary(options: argparse.Namespace) -> Result:
    """Print critical velocities and loads."""
    ds, conditions = dataset_in(options), conditions_in(options)
    if by_samples(options, ds):
        return boundary_of_samples(options, ds, conditions)
    if not has_plane(ds):
        return _about_rows(options, ds, conditions)
    crossings = pipeline.boundary(ds, **conditions)
    command = _command(crossings, options.store, ds)
    cold = turns_left_out(ds, crossings, **conditions)
    # Of several frictions none is that of a test which gives none.
    one = {k: value for k, value in conditions.items() if not isinstance(value, tuple)}
    tests = frames.compared(ds, **one)
    text: list[str | pd.DataFrame] = [_judged_by(options, ds, conditions)]
    for part in frames.on_boundary(crossings):
        text += ["", part]
    text += ["", f"compute more of the boundary with: {command}"] if command else []
    text += ["", f"warning: {cold}"] if cold else []
    text += [] if tests is None else ["", *frames.on_tests(tests)]
    text += after_boundary(stored_sweep(ds), options.store)
    warned = pipeline.warned(ds, **conditions)
    document = document_of(crossings) | {"command": command, "not_counted": cold}
    if tests is not None:
        document["tests"] = as_dict(tests)
    return Result(document, text, warned, frames.frames_of(crossings))


def _judged_by(options: argparse.Namespace, ds: xr.Dataset, conditions: dict[str, Any]) -> str:
    """Conditions of all scenes and frictions, in words."""
    frictions = conditions.get("friction")
    each = [{"friction": one} for one in frictions] if isinstance(frictions, tuple) else [{}]
    several = (conditions_of(scene, **conditions | one) for one in each for scene in scenes(ds))
    return judged_by(several)


_IN_KELVIN = "decisive temperature [°C]", "temperature error [K]", "distance [K]"


def _about_rows(options: argparse.Namespace, ds: xr.Dataset, conditions: dict[str, Any]) -> Result:
    """Boundary about rows with places of their own: factors of velocity and load of each."""
    if PLACE not in ds.coords:
        raise InputError(
            "each row has one place, and no boundary; irg margin gives their margins in K, and "
            "sweep.around = 5 beside sweep.along the factors in velocity and load, too"
        )
    table = pipeline.margin_table(ds, **conditions).drop(columns=[*_IN_KELVIN])
    crosses = table[["velocity outcome", "load outcome"]] == outcomes("load")[CROSSES]
    text = [
        f"{int(crosses.any(axis=1).sum())} of {counted(len(table), 'row', 'rows')} cross the "
        "boundary between half and twice their velocity or load",
        "",
        short(table, ["note"]),
        *notes_of(table),
    ]
    document = {"rows": as_dict(table)}
    return Result(document, text, pipeline.warned(ds, **conditions), [table])


def document_of(crossings: xr.Dataset) -> dict[str, Any]:
    """Plain data of `pipeline.boundary`, under its names; outcomes in words."""
    document = {str(name): values.values.tolist() for name, values in crossings.variables.items()}
    for name, axis in frames.BOUNDARIES:
        words, outcome = outcomes(name.removeprefix("critical_")), f"outcome_at_{axis}"
        worded = np.vectorize(words.__getitem__, otypes=[object])(crossings[outcome])
        document[outcome] = worded.tolist()
    # Of several values where scenes differ in them.
    held = document | {"friction": frames.frictions_of(crossings)} | crossings.attrs
    names = ("friction", *frames.JUDGED)
    conditions = {name: held[name] for name in names if name in held}
    missing = frames.missing_points(crossings)
    return document | {"conditions": conditions, "missing_points": missing}


def _command(crossings: xr.Dataset, store: Path | str, ds: xr.Dataset) -> str | None:
    """The command that computes points of the boundary that are missing; None if none are."""
    for _, scene in parts_of(crossings):
        for friction, part in frames.by_friction(scene):
            is_beyond = part["outcome_at_load"].isin((*BEYOND, UNKNOWN)).any()
            if is_beyond or part["bridged_at_load"].any():
                return more_of_boundary(ds, store, scene.attrs | {"friction": friction})
    return None
