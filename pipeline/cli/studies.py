"""The commands that study a scene and the tool: its inputs one by one, its errors."""

from __future__ import annotations

import argparse
import itertools
import math
from collections.abc import Iterator
from functools import partial
from typing import TYPE_CHECKING, Any

import pipeline
from pipeline.analysis.tables import Column, Table
from pipeline.analysis.transition import CROSSES, outcomes
from pipeline.cli.output import Result, tell
from pipeline.cli.progress import run_line
from pipeline.cli.scenes import scene_of, settings_of
from tribo import InputError

if TYPE_CHECKING:
    from pipeline.run.vary import Variations


_STATES = ("counted", "could be counted", "cannot be sized")


def vary(options: argparse.Namespace) -> Result:
    """Print and draw the boundary for each value of some entries."""
    over: dict[str, list[Any]] = {}
    for key, values in options.over:
        over.setdefault(key, []).extend(values)
    if not over and not options.physics:
        raise InputError("nothing to vary; give --over KEY=VALUE,VALUE for an entry, or --physics")
    with run_line() as progress:
        result = pipeline.vary(
            options.scene,
            over,
            options.preset,
            settings_of(options),
            tell=tell,
            physics=options.physics,
            own_laws=options.own_laws,
            out=options.kept,
            workers=options.workers,
            progress=progress,
        )
    table = _critical_velocities(result)
    return Result(
        result.as_dict(),
        _on_variations(result, table),
        warned=result.warned,
        tables=[table],
        draw=partial(pipeline.draw_variations, result),
    )


def _critical_velocities(result: Variations) -> Table:
    """Table with a row for each value and load."""
    columns = (
        Column("entry", "entry"),
        Column("value", "value"),
        Column("load", "load", "N"),
        Column("critical_velocity", "critical velocity", "m/s"),
        Column("change", "change"),
        Column("outcome", "outcome"),
    )
    rows: list[tuple[Any, ...]] = []
    for variation in (result.base, *itertools.chain(*result.by_key().values())):
        name, changes = "as it is", [math.nan] * len(result.loads)
        if variation.key:
            name, changes = variation.key, result.changes(variation).tolist()
        values = zip(
            result.loads, variation.critical_velocities, changes, variation.outcomes, strict=True
        )
        rows += [(name, variation.value, *row) for row in values]
    return Table(columns, tuple(rows))


def _on_variations(result: Variations, table: Table) -> Iterator[str]:
    """The table with a column for each load, and physics that the scene leaves out."""
    effects = {effect.key[0] for effect in result.physics}

    def name(row: dict[str, Any]) -> str:
        is_alone = row["value"] == result.base.value or row["entry"] in effects
        return str(row["entry"]) if is_alone else f"{row['entry']} = {row['value']}"

    def cell(row: dict[str, Any]) -> str:
        if not math.isfinite(row["critical_velocity"]):
            return str(row["outcome"])
        change = f"  {100 * row['change']:+.1f} %" if math.isfinite(row["change"]) else ""
        return f"{row['critical_velocity']:.3g}{change}"

    heads = {load: f"at {load:g} N" for load in result.loads}
    yield from table.crossed("critical velocity [m/s]", name, "load", heads, cell).lines()
    if set(table.as_dict()["outcome"]) - {outcomes("velocity")[CROSSES]}:
        yield ""
        yield "in words: no transition between the sweep's velocities"
    yield ""
    yield f"from {result.points} points on the contacts of {result.contacts}"
    for state, group in itertools.groupby(
        sorted(result.physics, key=lambda effect: _STATES.index(effect.state)),
        key=lambda effect: effect.state,
    ):
        yield from ("", f"{state}:")
        for effect in group:
            yield f"  {effect.name}: {effect.size}"
            if effect.certainty:
                yield f"    certainty  {effect.certainty}"
            if effect.entry:
                yield f"    entry      {effect.entry}"


def trade(options: argparse.Namespace) -> Result:
    """Measure speed against accuracy on a scene."""
    measured = pipeline.trade(
        scene_of(options), base=options.base, diagram=options.diagram, progress=tell
    )
    draw = partial(pipeline.draw_trade, measured)
    return Result(measured.as_dict(), [str(measured)], tables=[measured.table], draw=draw)
