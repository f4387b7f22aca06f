"""The command ``irg trade``."""

from __future__ import annotations

import argparse
from dataclasses import replace
from functools import partial

import pipeline
from pipeline.cli import given
from pipeline.cli.output import Result, tell


def trade(options: argparse.Namespace) -> Result:
    """Answer ``irg trade``: what each accuracy of a scene's boundary costs."""
    found = pipeline.trade(given.scene_in(options), progress=tell)
    found = replace(found, scene=given.typed_scene(options))
    return Result(text=[str(found)], frames=[found.table], draw=partial(pipeline.plot, found))
