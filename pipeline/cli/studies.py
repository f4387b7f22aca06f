"""The command ``irg trade``."""

from __future__ import annotations

import argparse
from functools import partial
from pathlib import Path

import pipeline
from pipeline.cli import given, output
from pipeline.cli.output import Result


def trade(options: argparse.Namespace) -> Result:
    """Answer ``irg trade``: what each accuracy of a scene's boundary costs, measured."""
    out = options.store_path or Path("results") / f"{options.scene.stem}-trade.zarr"
    scene = given.scene_in(options)
    with output.run_line() as progress:
        found = pipeline.trade(scene, out, workers=options.workers, progress=progress)
    text = [str(found), f"points: {out}"]
    return Result(text=text, frames=[found.table], draw=partial(pipeline.plot, found))
