"""The answer of a report where some points are not done, or some surfaces have no transition."""

import pytest
import xarray as xr

import pipeline
from pipeline.analysis.transition import CROSSES
from tests.helpers import synthetic

pytestmark = pytest.mark.usefixtures("undrawn")


def written(ds, tmp_path):
    return pipeline.report(ds, tmp_path / "report.html").read_text(encoding="utf-8")


def test_a_report_says_that_points_have_failed(tmp_path):
    page = written(synthetic.sweep(status={(400.0, 2.0): 2}), tmp_path)
    assert "The sweep is not finished: 179 of 180 points are done, 1 failed." in page


def test_a_report_names_no_velocity_at_a_load_where_a_surface_has_none(tmp_path):
    parts = [
        synthetic.sweep(rise=lambda *at, part=part: part * synthetic.rise(*at))
        for part in (1.0, 0.7)
    ]
    ds = xr.concat(parts, xr.Variable("realization", range(2)), combine_attrs="override")
    crosses = pipeline.boundary(ds)["outcome_at_load"] == CROSSES
    assert crosses.any("realization").sel(load=200.0)
    assert not crosses.all("realization").sel(load=200.0)
    told = written(ds, tmp_path).split("Answer: ")[1].split("</p>")[0]
    assert "at 200 N" not in told
    assert "at 750 N" in told
