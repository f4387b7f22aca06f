"""The command on the distance of operating points from severe wear."""

from __future__ import annotations

import argparse
import itertools
from collections import Counter
from collections.abc import Iterable, Iterator, Sequence
from typing import TYPE_CHECKING, Any

import pipeline
from pipeline.analysis.conditions import conditions_of
from pipeline.analysis.margin import NOT_DECIDED, margins_at
from pipeline.analysis.margin_table import LONG, notes_of
from pipeline.analysis.scenes import words
from pipeline.analysis.tables import as_dict, short
from pipeline.analysis.transition import BEYOND, CROSSES, UNITS, in_words, outcomes
from pipeline.cli.next_steps import commands_that_decide, lines_on, more_of_boundary
from pipeline.cli.output import Result, counted
from pipeline.cli.scenes import by_samples, conditions_in, opened, operating_points_in, values_in
from pipeline.cli.unknowns import about, frame_of_intervals, notes, on_risk, samples_of

if TYPE_CHECKING:
    import pandas as pd
    import xarray as xr

    from pipeline.analysis.margin import Margin


def margin(options: argparse.Namespace) -> Result:
    """Print the distance of one operating point to the boundary, or of those of a table."""
    place = values_in(options, "load", "velocity")
    points = operating_points_in(options) if place or options.points else None
    ds, conditions = opened(options), conditions_in(options)
    if by_samples(options, ds):
        operating_points_in(options)  # of which samples have none themselves
        return _of_samples(options, ds, conditions)
    if place:
        return _of_one(options, ds, conditions)
    table = pipeline.margin_table(ds, points, **conditions)
    if table.empty:
        operating_points_in(options)  # which says that there is none
    document, text = _on_points(options, table)
    margins = margins_at(ds, points.places if points else None, **conditions)
    commands, lines = _next(options, ds, margins, conditions)
    text += lines
    warned = pipeline.warned(ds, **conditions)
    return Result(document | {"next": commands}, text, warned, [table])


def _of_one(options: argparse.Namespace, ds: xr.Dataset, conditions: dict[str, Any]) -> Result:
    """Distance of one operating point, on one surface or on several, for each scene."""
    margins = pipeline.margins(ds, options.load, options.velocity, **conditions)
    parts = [tuple(part) for _, part in itertools.groupby(margins, lambda one: one.entries)]
    documents = [_document(part) if part[1:] else part[0].as_dict() for part in parts]
    document = documents[0] if len(parts) == 1 else {"scenes": documents}
    table = pipeline.margin_table(ds, operating_points_in(options), **conditions)
    text: list[str | pd.DataFrame] = []
    for part in parts:
        text += [f"{row}:" for row in [words(ds, part[0].entries)] if row]
        text += [_on_surfaces(part)] if part[1:] else _on_one(part[0])
    if len(margins) > len(parts):  # medians over surfaces, and a tenth of them beyond each end
        text.append(short(table, LONG))
    commands, lines = _next(options, ds, margins, conditions)
    text += lines
    command = None
    if any(map(_is_incomplete, margins)):
        judged = conditions_of(ds, **conditions).as_dict()
        command = more_of_boundary(ds, options.store, judged)
        text.append(f"compute more of the boundary with: {command}")
    warned = pipeline.warned(ds, **conditions)
    return Result(document | {"next": commands, "command": command}, text, warned, [table])


def _next(
    options: argparse.Namespace,
    ds: xr.Dataset,
    margins: Iterable[Margin],
    conditions: dict[str, Any],
) -> tuple[list[str], list[str]]:
    """Commands that decide the margins that are not decided, and lines on them."""
    undecided = [margin for margin in margins if margin.verdict == NOT_DECIDED]
    if not undecided:
        return [], []
    judged = conditions_of(ds, **conditions).as_dict()
    commands = commands_that_decide(ds, options.store, undecided, judged)
    return commands, [*lines_on(commands)]


def _of_samples(options: argparse.Namespace, ds: xr.Dataset, conditions: dict[str, Any]) -> Result:
    """Distances of operating points as intervals of probability."""
    ensemble, measured = samples_of(options, ds, **conditions)
    draws = measured.draws if measured else None
    if options.points is None:
        answer = pipeline.margin_intervals(ensemble, options.load, options.velocity, draws)
        table = frame_of_intervals(answer)
        text: list[str | pd.DataFrame] = [on_risk(answer.risk), table]
        document: dict[str, Any] = {"intervals": answer.as_dict()}
    else:
        table = pipeline.risk_table(ensemble, operating_points_in(options), draws)
        document, text = _on_points(options, table)
    document |= {"given_measured": measured is not None, **about(ensemble)}
    return Result(document, [*text, *notes(ensemble, measured)], pipeline.warned(ds), [table])


def _on_points(
    options: argparse.Namespace, frame: pd.DataFrame
) -> tuple[dict[str, Any], list[str | pd.DataFrame]]:
    """Plain data, sentences and a frame on operating points."""
    verdicts = Counter(frame["verdict"])
    counts = ", ".join(f"{number} {verdict}" for verdict, number in sorted(verdicts.items()))
    said = f"{counted(len(frame), 'operating point', 'operating points')}: {counts}"
    shown = [] if options.output else ["", short(frame, LONG)]
    return {"verdicts": verdicts, "margins": as_dict(frame)}, [said, *shown, *notes_of(frame)]


def _is_incomplete(here: Margin) -> bool:
    """A transition beyond the computed points, or across some that are not done."""
    is_beyond = any(
        outcome in (outcomes(axis)[code] for code in BEYOND)
        for axis, outcome in (("velocity", here.velocity_outcome), ("load", here.load_outcome))
    )
    return is_beyond or here.velocity_bridged + here.load_bridged > 0


def _on_one(here: Margin) -> Iterator[str]:
    """Lines on one surface."""
    wear = "" if here.verdict == NOT_DECIDED else " wear"
    yield f"{here.load:g} N at {here.velocity:g} m/s: {here.verdict}{wear}"
    deciding = pipeline.display(here.decisive_temperature, "°C", 4)
    yield f"  deciding temperature  {deciding} ({_origin(here)})"
    yield f"  its error             {here.error.worded}"
    side = "above" if here.is_severe else "below"
    critical = pipeline.display(here.critical_temperature, "°C", 4)
    yield f"  distance              {abs(here.distance):.1f} K {side} {critical}"
    for name, unit in UNITS.items():
        outcome, bridged = (getattr(here, f"{name}_{part}") for part in ("outcome", "bridged"))
        way = in_words(outcome, getattr(here, f"{name}_range"), name)
        if outcome == outcomes(name)[CROSSES]:
            factor, place = getattr(here, f"{name}_factor"), getattr(here, f"critical_{name}")
            way = f"{factor:.3g} times, severe from {place:.4g} {unit} on"
            if bridged:
                way += f", interpolated across {counted(bridged, 'point', 'points')} not done"
        yield f"  in {name:<19}{way}"


def _origin(here: Margin) -> str:
    """Where the deciding temperature comes from, in words."""
    if here.is_computed:
        return "computed there"
    if here.is_continued:
        return "continued as a power of the velocity beyond the computed points"
    return "interpolated between computed points"


def _document(margins: Sequence[Margin]) -> dict[str, Any]:
    """Plain data on several surfaces."""
    return {
        "load": margins[0].load,
        "velocity": margins[0].velocity,
        "severe_surfaces": sum(one.verdict == "severe" for one in margins),
        "undecided_surfaces": sum(one.verdict == NOT_DECIDED for one in margins),
        "surfaces": [one.as_dict() for one in margins],
    }


def _on_surfaces(margins: Sequence[Margin]) -> str:
    """Sentence on several surfaces."""
    counts = Counter(one.verdict for one in margins)
    undecided = f", not decided on {counts[NOT_DECIDED]}" if counts[NOT_DECIDED] else ""
    return (
        f"{margins[0].load:g} N at {margins[0].velocity:g} m/s: severe wear on {counts['severe']} "
        f"of {len(margins)} surfaces{undecided}"
    )
