"""A lubricant's limit from measured transitions (pipeline.tradeoff.critical_temperature.py)."""

import re

import numpy as np
import pytest

from pipeline.analysis.boundary import boundary
from pipeline.analysis.dataset import open_sweep
from pipeline.sweep.measurement import Measurement
from pipeline.sweep.variants import surfaces
from pipeline.tradeoff.critical_temperature import critical_temperatures
from tests.helpers import tiny
from tests.helpers.entries import changed
from tests.helpers.scenes import SCENE
from tests.pipeline.conftest import commit_all


def test_the_critical_temperature_comes_back_from_the_boundary_that_it_made(tmp_path):
    """The boundary of a surface computed with 145 °C must give 145 °C back."""
    velocities = tuple(np.arange(0.5, 4.01, 0.5).tolist())
    sweep = tiny.sweep(loads=(300.0, 600.0), velocities=velocities, variants=surfaces((1, 2)))
    commit_all(tmp_path / "a.zarr", sweep)
    critical = boundary(open_sweep(tmp_path / "a.zarr"))["critical_velocity"]
    assert critical.notnull().all()
    measured = tuple(
        Measurement(load, critical.sel(realization=2, load=load).item()) for load in sweep.loads
    )
    result = critical_temperatures(changed(sweep.take_surface(2), measured=measured))
    assert result.surfaces == (2,)
    # With velocities every 0.5 m/s the boundary is known to 1 %, and the rise of 120 K to 0.5 %.
    assert result.means == pytest.approx([418.15] * 2, abs=1.0)
    assert result.spread < 1.0
    both = critical_temperatures(changed(sweep, measured=measured))
    assert np.shape(both.temperatures) == (2, 2)
    assert [row[1] for row in both.temperatures] == list(result.means)
    assert both.mean == pytest.approx(np.mean(both.temperatures))
    assert both.spreads[0] == pytest.approx(np.std(both.temperatures[0], ddof=1))


def test_the_command_finds_temperature_and_wear_rate(tmp_path, irg):
    scene = tmp_path / "scene.toml"
    measured = '\n[[measured]]\nload = "600 N"\nvelocity = "1.5 m/s"\nfriction = 0.12\n'
    scene.write_text(SCENE + measured)
    document = irg("infer", scene, "--json", "--set", "sweep.realizations=2")
    assert document["surfaces"] == [0, 1]
    (transition,) = document["transitions"]
    assert (transition["friction"], len(transition["temperatures"])) == (0.12, 2)
    assert document["spread"] is None
    assert re.search(r"600 +1\.5 +0\.12 ", irg("infer", scene))

    place = ["--load", "600 N", "--velocity", "1.5 m/s"]
    (row,) = irg("point", scene, *place, "--json", "--set", "history_coarsening=1")
    width = row["contact width [µm]"]
    arguments = ["infer", str(scene), "--contact-width", f"{width} um", *place]
    rate = irg(*arguments, "--json")
    assert rate["lowest"] < 1.2e-15 < rate["highest"]
    assert "give --load and --velocity" in irg(*arguments[:4], code=2)
    assert "--contact-width" in irg("infer", scene, *place, code=2)
