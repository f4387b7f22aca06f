"""The commands ``irg vary`` and ``irg trade``."""

from __future__ import annotations

import argparse
from dataclasses import replace
from functools import partial
from typing import Any

import pipeline
from pipeline.analysis.tables import short
from pipeline.cli import given
from pipeline.cli.output import Result, run_line, tell
from tribo import InputError


def vary(options: argparse.Namespace) -> Result:
    """Answer ``irg vary``: find the boundary with one entry changed at a time."""
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
    counts = f"{result.points} points computed, which share {result.contacts} contacts"
    about = "computed on the first surface; tests and uncertain inputs do not count"
    text = [short(result.table), "", about, counts]
    return Result(text=text, warned=result.warned, frames=[result.table])


def trade(options: argparse.Namespace) -> Result:
    """Answer ``irg trade``: what each accuracy of a scene's boundary costs."""
    found = pipeline.trade(given.scene_in(options), progress=tell)
    found = replace(found, scene=given.typed_scene(options))
    return Result(text=[str(found)], frames=[found.table], draw=partial(pipeline.plot, found))
