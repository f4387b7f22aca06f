"""The commands that study a scene: its inputs one by one, and its errors."""

from __future__ import annotations

import argparse
import itertools
import math
from functools import partial
from typing import TYPE_CHECKING, Any

import pandas as pd

import pipeline
from pipeline.analysis.tables import frame_of, short
from pipeline.cli import given
from pipeline.cli.output import Result, run_line, tell
from tribo import InputError

if TYPE_CHECKING:
    from pipeline.run.vary import Variations  # with Dask


def vary(options: argparse.Namespace) -> Result:
    """Print and draw the boundary for each value of some entries."""
    over: dict[str, list[Any]] = {}
    for key, values in options.over:
        over.setdefault(key, []).extend(values)
    if not over:
        raise InputError("nothing to vary; give --over KEY=VALUE,VALUE for an entry")
    with run_line() as progress:
        result = pipeline.vary(
            options.scene,
            over,
            options.preset,
            given.settings_in(options),
            out=options.kept,
            workers=options.workers,
            progress=progress,
        )
    frame = _critical_velocities(result)
    counts = f"{result.points} points, computed on the contacts of {result.contacts}"
    return Result(
        result.as_dict(),
        [short(frame), "", counts],
        warned=result.warned,
        frames=[frame],
        draw=partial(pipeline.plot, result),
    )


def _critical_velocities(result: Variations) -> pd.DataFrame:
    """Frame with a row for each value and load."""
    rows: list[tuple[Any, ...]] = []
    for variation in (result.base, *itertools.chain(*result.keyed_changes().values())):
        name, changes = "unchanged", [math.nan] * len(result.loads)
        if variation.key:
            name, changes = variation.key, result.changes(variation).tolist()
        values = zip(
            result.loads, variation.critical_velocities, changes, variation.outcomes, strict=True
        )
        rows += [(name, variation.value, *row) for row in values]
    heads = "entry", "value", "load [N]", "critical velocity [m/s]", "change [%]", "outcome"
    return frame_of(heads, rows)


def trade(options: argparse.Namespace) -> Result:
    """Measure speed against accuracy on a scene."""
    measured = pipeline.trade(given.scene_in(options), progress=tell)
    draw = partial(pipeline.plot, measured)
    return Result(measured.as_dict(), [str(measured)], frames=[measured.table], draw=draw)
