"""Bodies of unequal bulk temperature, from the scene file to the figures."""

import numpy as np
import pytest
import xarray as xr

import pipeline
from pipeline import Conditions
from pipeline.answers.results import sweep_of
from tests.helpers import tiny
from tests.helpers.sweeps import deciding
from tests.pipeline.conftest import commit_all
from tribo import InputError

BOTH = {"pin": 333.15, "disk": 298.15}
CONDITIONS = Conditions(0.07, 333.15, 373.15, disk_temperature=298.15)


def warm(**changes):
    """Tiny sweep with (disk − pin bulk temperature)/friction = −500 K, a stored ratio."""
    return tiny.full(conditions=CONDITIONS, unequal_bulks=True, **changes)


@pytest.fixture(scope="module")
def stores(tmp_path_factory):
    """Folder with stores of a sweep with unequal and with equal bulk temperatures."""
    folder = tmp_path_factory.mktemp("bulks")
    for name, sweep in (("unequal", warm()), ("equal", tiny.full())):
        commit_all(folder / f"{name}.zarr", sweep)
    return folder


@pytest.fixture
def unequal(stores):
    return pipeline.open_sweep(stores / "unequal.zarr")


@pytest.fixture
def equal(stores):
    return pipeline.open_sweep(stores / "equal.zarr")


def test_only_unequal_bulk_temperatures_are_stored_with_both_parts(unequal, equal):
    further = {"bulk_ratio", "mean_bulk_response", "bulk_rise_quantile", "bulk_response"}
    assert set(unequal.variables) - set(equal.variables) == further
    assert sweep_of(equal).conditions.disk_temperature is None
    assert sweep_of(unequal).conditions == CONDITIONS
    for name in ("rise_quantile", "rise", "max_rise", "pressure"):
        assert np.array_equal(unequal[name], equal[name], equal_nan=True)


def test_the_conditions_stay_free_after_the_run(unequal, equal):
    for friction, bulk in ((0.1, 298.15), (0.07, "40 degC")):
        conditions = {"friction": friction, "bulk_temperature": bulk, "critical_temperature": 400.0}
        one, other = (pipeline.boundary(ds, **conditions) for ds in (unequal, equal))
        xr.testing.assert_equal(one, other)
    colder_disk, warmer_disk = (
        deciding(unequal, bulk_temperature={"pin": "60 degC", "disk": disk})
        for disk in ("20 degC", 353.15)
    )
    assert (colder_disk < warmer_disk).all()
    # Without friction the temperature of a contact is between those of the bodies.
    still = deciding(unequal, friction=0.0, bulk_temperature=BOTH)
    assert ((still > 298.15) & (still < 333.15)).all()


def test_a_sweep_of_equal_ones_cannot_tell_what_unequal_ones_would_do(stores, equal, irg):
    with pytest.raises(InputError, match="for bodies of one bulk temperature"):
        pipeline.boundary(equal, bulk_temperature=BOTH)
    option = ("--bulk-temperature", "pin=60 degC,disk=25 degC")
    error = irg("boundary", stores / "equal.zarr", *option, code=2)
    assert error.count("\n") == 1
    assert "bulk = { pin = ..., disk = ... }" in error


SCENE = """
extends = "{paper}"
without = ["measured", "friction.band"]

[window]
pixels = [48, 48]
pixel_size = ["8 um", "9.5 um"]

[fidelity]
preset = "standard"
increments = 2

[sweep]
loads = ["600 N"]
velocities = ["1 m/s", "4 m/s"]

[temperature]
bulk = {{ pin = "60 degC", disk = "25 degC" }}

[[measured]]
load = "600 N"
velocity = "1 m/s"
"""


@pytest.fixture
def scene(tmp_path, request):
    path = tmp_path / "warm_pin.toml"
    paper = request.config.rootpath / "workflows" / "irg_transition.toml"
    path.write_text(SCENE.format(paper=paper))
    return path


def test_the_scene_file_gives_one_temperature_or_two(scene):
    both = pipeline.load_scene(scene)
    assert both.scene.unequal_bulks
    assert both.conditions == Conditions(0.1, 333.15, 418.15, disk_temperature=298.15)
    for same in ("25 degC", {"pin": "25 degC", "disk": "25 degC"}):
        one = pipeline.load_scene(scene, overrides={"temperature.bulk": same})
        assert not one.scene.unequal_bulks
        assert one.conditions == Conditions(0.1, 298.15, 418.15)


def test_the_commands_take_both(scene, irg):
    out = scene.with_suffix(".zarr")
    commit_all(out, pipeline.load_scene(scene))
    assert "bulk 60 °C (pin) and 25 °C (disk)" in " ".join(irg("boundary", out).split())
    option = ("--bulk-temperature", "pin=40 degC, disk=50 degC")
    first, *_ = irg("boundary", out, *option, "--json")
    assert "bulk 40 °C (pin) and 50 °C (disk)" in first["conditions"]
    place = ("--load", "600 N", "--velocity", "1 m/s", "--preset", "standard")  # of known error
    temperatures = []
    for options in ((), option, ("--bulk-temperature", "25 degC")):
        (row,) = irg("point", scene, *place, *options, "--json")
        temperatures.append(row["temperature [°C]"] + 273.15)
    assert temperatures[2] < temperatures[0] < temperatures[1]
    said = irg("boundary", out, "--bulk-temperature", "pin=40 degC", code=2)
    assert "bulk_temperature names pin; give one temperature for both bodies" in said
