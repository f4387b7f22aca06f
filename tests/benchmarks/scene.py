"""The scene that most benchmarks run, and the grid and increments that the paper solves it with."""

from pathlib import Path

import pipeline
import tribo
from tests.helpers.entries import changed

SCENE = Path(__file__).parents[2] / "workflows" / "irg_transition.toml"
PAPER = tribo.Fidelity(pixels_per_element=2, increments=100)


def paper_scene():
    """The shipped scene on 240 × 240 elements, with 100 increments of first order."""
    return changed(pipeline.load_scene(SCENE), fidelity=PAPER)
