"""The shipped scenes, against what was measured on the rig."""

from pathlib import Path

import pytest

import pipeline
from tribo import QUANTILES

WORKFLOWS = Path(__file__).parents[2] / "workflows"
PAPER = pipeline.load_scene(WORKFLOWS / "irg_transition.toml")
SLOW = ("mtm", 75.0, 1.1), ("srv", 200.0, 0.16)
MEASURED = {400.0: 2.25, 200.0: 3.75}  # Table 4: N, m/s


def governing_temperature(sweep, load, velocity):
    heat = pipeline.run_point(sweep, load, velocity).state.heat
    rise = heat.rise_quantile[QUANTILES.index(1 - sweep.conditions.critical_area_fraction)]
    return sweep.conditions.bulk_temperature + sweep.conditions.friction * rise


@pytest.mark.parametrize("load", MEASURED)
def test_predicted_critical_velocity_is_within_15_percent_of_the_measured_one(load):
    """At friction 0.1, wear is mild 15 % below the measured velocity and severe 15 % above."""
    critical = PAPER.conditions.critical_temperature
    assert governing_temperature(PAPER, load, 0.85 * MEASURED[load]) < critical
    assert governing_temperature(PAPER, load, 1.15 * MEASURED[load]) > critical


@pytest.mark.parametrize(
    ("name", "pin_turn", "disk_turn"),
    [  # 2170 rpm of the pinion with 16 teeth, which is the disk, and a wheel of 24; 1000 rpm
        ("gear_mesh", 60 / 2170 * 24 / 16, 60 / 2170),
        ("cam_tappet", 0.06, 0.06),
    ],
)
def test_each_body_of_a_row_returns_after_a_revolution_of_its_shaft(name, pin_turn, disk_turn):
    sweep = pipeline.load_scene(name)
    assert len(sweep.cases) > 4
    for case, row in zip(sweep.cases, sweep.case_table.rows, strict=True):
        motion = case.scene.motion
        speeds = motion.velocities(row["velocity"])
        assert motion.pin_track_length / abs(speeds.pin) == pytest.approx(pin_turn, rel=2e-3)
        assert motion.disk_track_length / abs(speeds.disk) == pytest.approx(disk_turn, rel=2e-3)


def test_first_try_crosses_the_boundary_and_no_point_warns(folder_with_results):
    store = folder_with_results / "results" / "first_try.zarr"
    summary = pipeline.summary(store)
    assert (summary.done, summary.failed) == (summary.total, ())
    ds = pipeline.open_sweep(store)
    assert pipeline.points_with_warnings(ds).points == 0
    velocities = pipeline.boundary(ds)["critical_velocity"]
    assert velocities.notnull().all()
    assert (velocities.diff("load") < 0).all()


@pytest.mark.parametrize(
    ("name", "load", "velocity"),  # as stated at the top of these files
    [("pin_on_disk", 200.0, 0.24), *(pytest.param(*row, marks=pytest.mark.slow) for row in SLOW)],
)
def test_scenes_of_usual_rigs_cross_the_boundary_where_they_say(name, load, velocity):
    scene = pipeline.load_scene(name)
    critical = scene.conditions.critical_temperature
    assert governing_temperature(scene, load, 0.85 * velocity) < critical
    assert governing_temperature(scene, load, 1.15 * velocity) > critical
    text = (WORKFLOWS / f"{name}.toml").read_text(encoding="utf-8")
    marked = [line.split()[0] for line in text.splitlines() if "  # yours" in line]
    assert {"oil", "ra", "coefficient", "critical"} <= {*marked}
