"""A single point and a row have the temperatures of a plane."""

import numpy as np
import pandas as pd
import pytest

import pipeline
from tests.helpers.answer_at import named
from tests.helpers.scenes import MEASURED, SCENE
from tests.pipeline.conftest import commit_all

SAME = {"rel": 1e-9, "abs": 1e-12}  # all answers use one field and differ by rounding only
HEADS = "load [N]", "velocity [m/s]"


@pytest.fixture(scope="module")
def places_computed(tmp_path_factory):
    """Scene, and margins of some points from a plane, a single simulation, and rows."""
    folder = tmp_path_factory.mktemp("doors")
    scene, rows = folder / "small.toml", [(200.0, 2.0), (400.0, 5.0), (400.0, 1.0)]
    # The numerical error of a preset is known.
    text = SCENE.replace("pixels_per_element = 1\nincrements = 10", 'preset = "standard"')
    scene.write_text(text + MEASURED)
    pd.DataFrame(rows, columns=HEADS).to_csv(folder / "rows.csv", index=False)
    axes = {"sweep.loads": ["200 N", "400 N"], "sweep.velocities": ["1 m/s", "2 m/s", "5 m/s"]}
    along = {"sweep.along": str(folder / "rows.csv")}
    with np.errstate(all="raise", under="ignore"):
        for name, changes in (("plane", axes), ("rows", along)):
            commit_all(folder / f"{name}.zarr", pipeline.load_scene(scene, overrides=changes))
    return scene, rows, folder / "plane.zarr", pipeline.margin(folder / "rows.zarr")


def test_a_point_and_a_row_are_as_hot_as_in_a_plane_and_never_decided_otherwise(
    places_computed, irg
):
    (scene, rows, plane, table), verdicts = places_computed, set()
    for load, velocity in rows:
        options = f"--load={load} N", f"--velocity={velocity} m/s"
        (single_row,) = irg("point", scene, *options, "--json")
        (within,) = irg("margin", plane, *options, "--json")
        (row,) = np.flatnonzero((table["load"] == load) & (table["velocity"] == velocity))
        expected = {
            "governing temperature [°C]": table["governing_temperature"].values[row] - 273.15
        }
        expected["verdict"] = named(table["verdict"])[row].replace("_", " ")
        for door in (single_row, expected):
            hot = door["governing temperature [°C]"]
            assert hot == pytest.approx(within["governing temperature [°C]"], **SAME)
            assert door["verdict"] in (within["verdict"], "undecided")
            verdicts.add(door["verdict"])
    assert {"mild", "severe"} <= verdicts
