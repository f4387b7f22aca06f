"""The command that changes one input at a time."""

from __future__ import annotations

import argparse
import itertools
import math
from collections.abc import Iterator
from functools import partial
from typing import TYPE_CHECKING, Any

import pipeline
from pipeline.analysis.tables import Column, Table
from pipeline.analysis.transition import CROSSES, OUTCOMES
from pipeline.cli.exit_codes import DONE
from pipeline.cli.output import output_path, show, tell
from pipeline.cli.scenes import settings_of
from tribo import InputError

if TYPE_CHECKING:
    from pipeline.run.vary import Variation, Variations


def vary(options: argparse.Namespace) -> int:
    """Print and draw the boundary for each value of some entries."""
    out = output_path(options)
    over: dict[str, list[Any]] = {}
    for key, values in options.over:
        over.setdefault(key, []).extend(values)
    if not over and not options.physics:
        raise InputError("nothing to vary; give --over KEY=VALUE,VALUE for an entry, or --physics")
    settings = settings_of(options)
    result = pipeline.vary(
        options.scene, over, options.preset, settings, tell=tell, physics=options.physics
    )
    draw = partial(pipeline.draw_variations, result)
    show(
        options, result.as_dict(), _text(result),
        warned=result.warned, out=out, tables=[_table(result)], draw=draw,
    )  # fmt: skip
    return DONE


def _table(result: Variations) -> Table:
    """Table with a row for each value and load."""
    columns = (
        Column("entry", "entry"),
        Column("value", "value"),
        Column("load", "load", "N"),
        Column("critical_velocity", "critical velocity", "m/s"),
        Column("change", "change"),
        Column("outcome", "outcome"),
    )
    rows = []
    for variation in (result.own, *result.others):
        changes = (
            result.changes(variation).tolist() if variation.key else [None] * len(result.loads)
        )
        values = zip(
            result.loads, variation.critical_velocities, changes, variation.outcomes, strict=True
        )
        rows += [(variation.key or "as it is", variation.value, *row) for row in values]
    return Table(columns, tuple(rows))


def _text(result: Variations) -> Iterator[str]:
    """Table of critical velocities, a row for each value and a column for each load."""
    heads = (Column(f"{load:g}", f"at {load:g} N") for load in result.loads)
    others = itertools.chain.from_iterable(result.by_key().values())
    effects = {effect.name for effect in result.left_out}
    entries = [("as it is", result.own)]
    entries += [
        (
            variation.key if variation.key in effects else f"{variation.key} = {variation.value}",
            variation,
        )
        for variation in others
    ]
    rows = tuple((name, *_cells(result, variation)) for name, variation in entries)
    yield from Table((Column("entry", "critical velocity [m/s]"), *heads), rows).lines()
    outcomes = {
        outcome for variation in (result.own, *result.others) for outcome in variation.outcomes
    }
    if outcomes - {OUTCOMES[CROSSES]}:
        yield ""
        yield "in words: no transition between the sweep's velocities"
    yield ""
    yield f"from {result.points} points on the contacts of {result.contacts}"
    for effect in result.left_out:
        yield ""
        yield f"{effect.name}: {effect.size}"
        yield f"  certainty  {effect.certainty}"
        if effect.entry:
            yield f"  entry      {effect.entry}"


def _cells(result: Variations, variation: Variation) -> Iterator[str]:
    """Critical velocities and their changes by load, or outcomes in words."""
    changes = result.changes(variation) if variation.key else [math.nan] * len(result.loads)
    for velocity, change, outcome in zip(
        variation.critical_velocities, changes, variation.outcomes, strict=True
    ):
        percent = f"  {100 * change:+.1f} %" if math.isfinite(change) else ""
        yield f"{velocity:.3g}{percent}" if math.isfinite(velocity) else outcome
