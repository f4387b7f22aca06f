"""Every command and function that gives a verdict states each warning and note once."""

import shutil

import numpy as np
import pandas as pd
import pytest

import pipeline
from tests.helpers import synthetic
from tests.helpers.answer_at import asked
from tests.helpers.scenes import SCENE
from tests.helpers.stores import commit_all

NOTE = "Not validated: no test of this steel."
HARD = "materials.steel.hardness: 3.14 times the elastic modulus is unusual (0.001 to 0.2 times"
POINT = ["--load", "300 N", "--velocity", "1.5 m/s"]


@pytest.fixture(scope="module")
def odd(tmp_path_factory):
    """Scene file of steel with mistyped moduli; its store is in the same folder."""
    path = tmp_path_factory.mktemp("odd") / "odd.toml"
    text = SCENE.replace("increments = 10", "increments = 1").replace("210 GPa", "21 GPa")
    path.write_text(text.replace("6.6 GPa", "66 GPa"))
    commit_all(path.with_suffix(".zarr"), pipeline.load_scene(path))
    return path


def test_every_door_says_a_doubt_once(odd, irg, tmp_path):
    store, figure = odd.with_suffix(".zarr"), tmp_path / "a.svg"
    doors = {
        "check": irg("check", odd),
        "run": irg("run", odd, "-o", store, "-q"),
        "one point": irg("point", odd, *POINT),
        "attributes": pipeline.boundary(store).attrs["notes"],
    }
    for door, output in doors.items():
        assert " ".join(output.split()).count(HARD) == 1, door
    irg("plot", store, "-o", figure)
    assert "3.14 times the elastic modulus" in " ".join(figure.read_text().split())


def caveats_in(row):
    """Notes in a row of a table."""
    return [*row["notes"].split(" | "), row["not_included"]]


def test_every_answer_on_a_store_says_the_same_caveats_each_once(odd, irg, tmp_path):
    store = shutil.copytree(odd.with_suffix(".zarr"), tmp_path / "noted.zarr")
    irg("run", odd, "--set", f"note={NOTE}", "-o", store, "-q")
    expected = asked(store, "300 N", "1.5 m/s")
    assert expected.notes[0] == NOTE
    assert sum(HARD in note for note in expected.notes) == 1
    for part in ("pin ends", "uncertain inputs"):
        assert expected.not_included.count(part) == 1
    lines = [*expected.notes, expected.not_included]
    for command in (("margin", store, *POINT), ("boundary", store)):
        output = " ".join(irg(*command, "-o", tmp_path / "out.csv").split())
        assert [output.count(line) for line in lines] == [1] * len(lines)
        rows = pd.read_csv(tmp_path / "out.csv").to_dict("records")
        assert all(caveats_in(row) == lines for row in (*irg(*command, "--json"), *rows))


def test_values_of_all_cases_are_doubted(odd, irg):
    over = 'sweep.over={"pin.radius"=["2 mm","400 nm","8 mm"]}'
    output = " ".join(irg("check", odd, "--set", over).split())
    assert "pin.radius: 1 of 3 values: 0.0004 mm is unusual (0.1 to 1000 mm is common)" in output
    over = 'sweep.over={"materials.steel.hardness"=["2 GPa","66 GPa"]}'
    output = " ".join(irg("check", odd, "--set", over).split())
    assert f"{HARD} the elastic modulus is common): check number and unit (in 66 GPa)" in output


@pytest.mark.parametrize(("share", "count"), [(0.1, 0), (0.0, 9)])
def test_a_rise_is_slow_where_the_temperature_that_decides_hardly_grows_with_velocity(share, count):
    def rise(load, velocity, quantile=1.0):  # of the hottest places as velocity^0.2
        is_hottest = np.asarray(quantile) > 0.95
        return synthetic.rise(load, velocity, quantile) * velocity ** (-0.5 * is_hottest)

    conditions = synthetic.CONDITIONS | {"critical_area_fraction": share}
    plane = (200.0, 400.0, 600.0), (0.25, 0.5, 1.0)
    ds = synthetic.sweep(*plane, rise=rise, tests=(), conditions=conditions)
    assert pipeline.points_with_warnings(ds).points == count
