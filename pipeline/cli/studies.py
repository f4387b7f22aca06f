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
    from pipeline.tradeoff.vary import Variations  # with Dask


def vary(options: argparse.Namespace) -> Result:
    """Print the boundary for each value of some entries."""
    over: dict[str, list[Any]] = {}
    for key, values in options.over:
        over.setdefault(key, []).extend(values)
    if not over:
        raise InputError("nothing to vary; give --over KEY=VALUE,VALUE for an entry")
    settings = given.settings_in(options)
    with run_line() as progress:
        result = pipeline.vary(
            options.scene, over, options.preset, settings, out=options.kept,
            workers=options.workers, progress=progress,
        )  # fmt: skip
    frame = _critical_velocities(result)
    counts = f"{result.points} points, computed on the contacts of {result.contacts}"
    return Result(text=[short(frame), "", counts], warned=result.warned, frames=[frame])


def _critical_velocities(result: Variations) -> pd.DataFrame:
    """Frame with a row for each value and load."""
    rows: list[tuple[Any, ...]] = []
    for one in (result.base, *itertools.chain(*result.keyed_changes().values())):
        changes = result.changes(one).tolist() if one.key else [math.nan] * len(result.loads)
        values = zip(result.loads, one.critical_velocities, changes, one.outcomes, strict=True)
        rows += [(one.key or "unchanged", one.value, *row) for row in values]
    heads = "entry", "value", "load [N]", "critical velocity [m/s]", "change [%]", "outcome"
    return frame_of(heads, rows)


def trade(options: argparse.Namespace) -> Result:
    """Measure speed against accuracy on a scene."""
    found = pipeline.trade(given.scene_in(options), progress=tell)
    return Result(text=[str(found)], frames=[found.table], draw=partial(pipeline.plot, found))
