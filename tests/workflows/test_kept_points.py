"""Points of all scenes, on coarse grids, have the numbers that are kept."""

from pathlib import Path

import numpy as np
import pytest

import pipeline
from tests.helpers.kept import assert_as_kept, some

WORKFLOWS = Path(__file__).parents[2] / "workflows"
COARSE = {
    "fidelity.increments": 4,
    "fidelity.fewest_elements": 0,
    "fidelity.pixels_per_element": 4,
    "fidelity.contact_tolerance": 1e-5,  # so that libraries agree on five digits
}
COARSER = COARSE | {"fidelity.pixels_per_element": 8}
SHIPPED = sorted(scene.stem for scene in WORKFLOWS.glob("*.toml"))
LARGE = "ball_on_disk", "pin_on_disk", "srv", "whole_pin"
VARIED = {
    "local wear": {"wear.pattern": "local"},
    "unworn": {"without": ["wear"]},
    "smooth": {"without": ["disk.roughness"]},
    "elastic": {"without": ["materials.steel.hardness"]},
    "soft": {"materials.steel.hardness": "2 GPa", "materials.steel.elastic_modulus": "100 GPa"},
    "held": {"loading.hold": "2 s", "sweep.steps": "course"},
    "in stages": {
        "loading.stages": {"first": "250 N", "step": "250 N", "hold": "1 s"},
        "sweep.loads": ["250 N", "750 N"],
        "without": ["tests"],
    },
    "rolling": {"motion.slide_roll_ratio": 0.5, "disk.track_length": "100 mm"},
    "free ends": {"pin.length": "0.3 mm", "pin.ends": "free"},
}
"""Entries of the scene first_try that differ."""
GROOVES = {"disk.roughness.correlation_length": ["6 um", "60 um"]}


def numbers(name, overrides):
    sweep = pipeline.load_scene(name, overrides=overrides)
    case = sweep.case_table.rows[0] if sweep.case_table.rows else {}
    load, velocity = case.get("load", sweep.loads[-1]), case.get("velocity", sweep.velocities[-1])
    result = pipeline.run_point(sweep, load, velocity)
    values = {**result.columns, **result.sampling, "end_rise_ratio": result.end_rise_ratio}
    # Rounding errors, on which libraries do not agree.
    del values["residual"], values["iterations"]
    spread = values["rise_realization_std"]
    values["rise_realization_std"] = np.where(spread < 1e-5, 0.0, spread)
    for field, value in result.fields.items():
        values[f"mean and maximum of {field}"] = value.mean(), value.max()
    lines = [f"{variable}: {some(value)}" for variable, value in values.items()]
    return "\n".join([f"{load} N, {velocity} m/s", *lines, *(w.text for w in result.warnings)])


@pytest.mark.parametrize("name", SHIPPED)
def test_points_of_shipped_scenes_are_kept(name):
    overrides = COARSER if name in LARGE else COARSE
    assert_as_kept(f"points/{name}", {name: numbers(name, overrides)})


@pytest.mark.parametrize("name", VARIED)
def test_points_of_varied_scenes_are_kept(name):
    assert_as_kept(f"points/{name}", {name: numbers("first_try", COARSE | VARIED[name])})


def test_points_of_a_ball_on_grooves_are_kept():
    texts = {"ball_on_disk": numbers("ball_on_disk", COARSER | GROOVES)}
    assert_as_kept("points/ball on grooves", texts)
