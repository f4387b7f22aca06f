"""The boundary of a scene, one input at a time."""

import numpy as np
import pytest

import pipeline
from tests.helpers.scenes import SCENE

SMALL = SCENE.replace("coefficient = 0.1", "coefficient = 0.13").replace(
    '"200 N", "400 N", ', '"200 N", '
)


OVER = {
    "friction.coefficient": [0.12],
    "temperature.critical": ["137 degC"],
    "wear.specific_wear_rate": ["4e-6 mm^3/(N m)"],
}


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    path = tmp_path_factory.mktemp("vary")
    (path / "small.toml").write_text(SMALL)
    return path


@pytest.fixture(scope="module")
def variations(folder):
    return pipeline.vary(folder / "small.toml", OVER, out=folder / "kept.zarr", workers=1)


def velocities(found, entry):
    """Critical velocities [m/s] by load, with an entry changed."""
    table = found.table
    return table.loc[table["entry"] == entry, "critical velocity [m/s]"].to_list()


def test_less_friction_and_more_wear_raise_the_boundary_and_a_weaker_oil_lowers_it(variations):
    changes = variations.table.groupby("entry", sort=False)["change [%]"]
    first = changes.first()
    assert first["friction.coefficient"] > 2
    assert first["temperature.critical"] < -2
    assert first["wear.specific_wear_rate"] > 2
    swings = changes.agg(lambda change: change.abs().max())
    assert swings.index[0] == "unchanged"
    assert swings[1:].is_monotonic_decreasing


def test_the_boundary_is_that_of_the_whole_sweep(variations, folder):
    sweep = pipeline.load_scene(folder / "small.toml")
    grid = np.array([2.0, 2.4, 2.8, 3.3, 4.0])
    results = [pipeline.run_point(sweep, 200.0, v).verdict(sweep.conditions) for v in grid]
    critical = np.interp(418.15, [result.deciding_temperature for result in results], grid)
    # The search and linear interpolation between the five velocities may each be 1 % wrong.
    assert velocities(variations, "unchanged")[0] == pytest.approx(critical, rel=0.02)


def test_a_notebook_shows_the_boundaries_once_below_the_other_values(variations):
    assert variations._repr_html_().count("<table") == 2


def test_thermal_constants_and_friction_take_each_contact_once(folder, variations):
    scene = folder / "small.toml"
    over = {
        "friction.coefficient": [0.12],
        "materials.steel.thermal_conductivity": ["43 W/(m K)"],
        "wear.specific_wear_rate": ["1.4e-6 mm^3/(N m)"],
    }
    shared = pipeline.vary(scene, over, out=folder / "shared.zarr", workers=1)
    store = pipeline.open_sweep(folder / "shared.zarr")
    own = [int((store["status"].isel(variation=one) == 1).sum()) for one in range(4)]
    assert sum(own) == shared.points
    assert max(own[:3]) + own[3] <= shared.contacts < shared.points - min(own)
    friction, conductivity, rate = over
    # The points are the same, but other rows share their contacts.
    assert velocities(shared, friction) == pytest.approx(velocities(variations, friction), rel=1e-9)
    unchanged, rated = (velocities(shared, entry) for entry in ("unchanged", rate))
    assert velocities(shared, conductivity)[0] < 0.995 * unchanged[0]
    alone = pipeline.vary(scene, {}, overrides={rate: over[rate][0]}, workers=1)
    # Other points are computed, and each search may be 1 % wrong; the measured difference is 0.9 %.
    expected = pytest.approx(velocities(alone, "unchanged"), rel=0.015, nan_ok=True)
    assert rated == expected
    assert rated != unchanged
    assert alone.contacts == alone.points


def test_points_that_are_kept_are_resumed_with_the_same_numbers(folder, variations):
    done = []
    again = pipeline.vary(
        folder / "small.toml", OVER, out=folder / "kept.zarr", progress=done.append, workers=1
    )
    assert repr(again) == repr(variations)
    labels = pipeline.open_sweep(folder / "kept.zarr")["variation"].values.tolist()
    assert labels[:2] == ["unchanged", "friction.coefficient = 0.12"]
    assert done[0].done == done[-1].done == variations.points


def test_the_command_takes_percents_and_says_on_which_side_a_missing_boundary_lies(folder, irg):
    over = ("--over", "pin.radius=-20%", "--over", "friction.coefficient=-5%,0.01,0.9")
    table = folder / "table.csv"
    document = irg("vary", folder / "small.toml", *over, "--json", "-o", table, "--workers", 1)
    assert {row["value"] for row in document} == {"", "1.6 mm", "0.1235", "0.01", "0.9"}
    count = len({row["load [N]"] for row in document})
    rows = [line.split(",") for line in table.read_text().splitlines()]
    for value, outcome in (("0.01", "mild throughout"), ("0.9", "severe throughout")):
        told = [row for row in document if row["value"] == value]
        assert [row["critical velocity [m/s]"] for row in told] == [None] * count
        assert [row["outcome"] for row in told] == [outcome] * count
        assert [row[-1] for row in rows if row[1] == value] == [outcome] * count


def test_the_command_tells_of_a_window_that_is_too_narrow(folder, irg):
    narrow = ["--set", 'window.pixel_size=["3 um", "16 um"]', "-o", folder / "vary.csv"]
    narrow += ["--workers", "1"]
    text = irg("vary", folder / "small.toml", "--over", "friction.coefficient=0.01,0.12", *narrow)
    assert "points carry a warning" in text
    assert "contact at edge" in text
    assert "mild throughout" in text
    assert "on the first surface; tests and uncertain inputs do not count" in text
    assert "mild throughout" in (folder / "vary.csv").read_text()
