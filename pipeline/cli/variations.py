"""The command that changes one input at a time."""

from __future__ import annotations

import argparse
import itertools
import math
import re
from collections.abc import Iterator
from functools import partial
from typing import TYPE_CHECKING, Any

import pipeline
from pipeline.analysis.tables import Column, Table
from pipeline.analysis.transition import CROSSES, OUTCOMES
from pipeline.cli.exit_codes import DONE
from pipeline.cli.output import output_path, show, tell
from pipeline.cli.scenes import scene_of, settings_of
from tribo import InputError

if TYPE_CHECKING:
    from pipeline.run.vary import Variation, Variations

_RELATIVE = re.compile(r"([+-]\d+(?:\.\d+)?)\s*%")
_QUANTITY = re.compile(r"\s*([+-]?[\d.]+(?:[eE][+-]?\d+)?)\s*(.*)")


def vary(options: argparse.Namespace) -> int:
    """Print and draw the boundary for each value of some entries."""
    out = output_path(options)
    others = {
        (key, str(value)): scene_of(_with(options, key, value))
        for key, values in options.over
        for value in _absolute(options, key, values)
    }
    found = pipeline.vary(scene_of(options), others, tell=tell)
    draw = partial(pipeline.draw_variations, found)
    show(
        options, found.as_dict(), _text(found),
        warned=found.warned, out=out, tables=[_table(found)], draw=draw,
    )  # fmt: skip
    return DONE


def _table(found: Variations) -> Table:
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
    for each in (found.own, *found.others):
        changes = found.changes(each).tolist() if each.key else [None] * len(found.loads)
        values = zip(found.loads, each.critical_velocities, changes, each.outcomes, strict=True)
        rows += [(each.key or "as it is", each.value, *row) for row in values]
    return Table(columns, tuple(rows))


def _with(options: argparse.Namespace, key: str, value: Any) -> argparse.Namespace:
    """The options with one entry set, whatever --set says of it."""
    settings = settings_of(options) | {key.removeprefix("fidelity."): value}
    return argparse.Namespace(**{**vars(options), "set": [*settings.items()]})


def _absolute(options: argparse.Namespace, key: str, values: list[Any]) -> Iterator[Any]:
    """Values of an entry; of those such as +20%, what they make of the scene's own."""
    for value in values:
        relative = _RELATIVE.fullmatch(value) if isinstance(value, str) else None
        if relative is None:
            yield value
            continue
        own = pipeline.scene_entry(options.scene, key, settings_of(options))
        factor = 1 + float(relative[1]) / 100
        if isinstance(own, int | float) and not isinstance(own, bool):
            yield float(f"{own * factor:.12g}")
        elif isinstance(own, str) and (parts := _QUANTITY.fullmatch(own)):
            if parts[2].startswith(("deg", "°", "C")):
                raise InputError(
                    f"--over {key}={value}: the scene gives {own}, and what a percentage of a "
                    "temperature is depends on its scale; give a value such as 150 degC"
                )
            yield f"{float(parts[1]) * factor:.12g} {parts[2]}"
        else:
            raise InputError(
                f"--over {key}={value}: the scene gives no number there to change; give a value"
            )


def _text(found: Variations) -> Iterator[str]:
    """Table of critical velocities, a row for each value and a column for each load."""
    heads = (Column(f"{load:g}", f"at {load:g} N") for load in found.loads)
    others = itertools.chain.from_iterable(found.by_key().values())
    entries = [("as it is", found.own), *((f"{each.key} = {each.value}", each) for each in others)]
    rows = tuple((name, *_cells(found, each)) for name, each in entries)
    yield from Table((Column("entry", "critical velocity [m/s]"), *heads), rows).lines()
    outcomes = {outcome for each in (found.own, *found.others) for outcome in each.outcomes}
    if outcomes - {OUTCOMES[CROSSES]}:
        yield ""
        yield "in words: no transition between the sweep's velocities"


def _cells(found: Variations, variation: Variation) -> Iterator[str]:
    """Critical velocities and their changes by load, or outcomes in words."""
    changes = found.changes(variation) if variation.key else [math.nan] * len(found.loads)
    for velocity, change, outcome in zip(
        variation.critical_velocities, changes, variation.outcomes, strict=True
    ):
        percent = f"  {100 * change:+.1f} %" if math.isfinite(change) else ""
        yield f"{velocity:.3g}{percent}" if math.isfinite(velocity) else outcome
