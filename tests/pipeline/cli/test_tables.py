"""Tables as files, for a report or another program."""

import csv

import numpy as np
import pytest
import xarray as xr

import pipeline
from pipeline.analysis.boundary import boundary
from pipeline.analysis.frames import frames_of
from tests.helpers import synthetic

HEADS = ["friction", "load [N]", "critical velocity [m/s]", "outcome"]


@pytest.fixture
def store(monkeypatch):
    monkeypatch.setattr(pipeline, "open_sweep", lambda path: synthetic.sweep())
    return "out.zarr"


def read(path):
    with path.open(newline="") as file:
        return list(csv.DictReader(file))


def test_a_boundary_is_written_as_numbers_with_its_conditions(store, tmp_path, irg):
    out = tmp_path / "table.csv"
    arguments = ["--friction", "0.09", "--friction", "0.1", "--bulk-temperature", "60 degC"]
    assert f"table: {out}" in irg("boundary", store, *arguments, "-o", out)
    rows, crossings = read(out), boundary(synthetic.sweep(), (0.09, 0.1), "60 degC")
    assert list(rows[0])[:4] == HEADS
    at_load = [row for row in rows if row["load [N]"] and row["friction"] == "0.1"]
    velocities = [float(row["critical velocity [m/s]"] or "nan") for row in at_load]
    expected = crossings.sel(friction=0.1)["critical_velocity"].values
    np.testing.assert_allclose(velocities, expected, rtol=1e-5)
    assert len(rows) == 2 * (crossings.sizes["load"] + crossings.sizes["velocity"])
    assert {row["bulk temperature [°C]"] for row in rows} == {"60"}
    assert all(row["outcome"] == "crosses" for row in at_load)


def test_a_band_is_written_with_how_many_surfaces_cross():
    hot = synthetic.sweep(rise=lambda *place: 1.2 * synthetic.rise(*place))
    both = xr.concat(
        [synthetic.sweep(), hot], xr.Variable("realization", [0, 1]), combine_attrs="override"
    )
    row = frames_of(boundary(both))[0].iloc[0]
    middle = row["critical velocity, median [m/s]"]
    assert row["10 % [m/s]"] < middle < row["90 % [m/s]"]
    assert (row["cross"], row["surfaces"]) == (2, 2)


def test_a_table_that_cannot_be_written_is_refused(store, tmp_path, irg):
    assert "cannot write" in irg("boundary", store, "-o", tmp_path / "table.xlsx", code=2)
