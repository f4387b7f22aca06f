"""Points at which steel would have melted carry a warning, at the friction that judges them."""

import pipeline
from tests.helpers import tiny
from tests.pipeline.conftest import commit_all


def test_points_hotter_than_molten_steel_are_counted(tmp_path, irg):
    commit_all(tmp_path / "tiny.zarr", tiny.full())
    ds = pipeline.open_sweep(tmp_path / "tiny.zarr")
    friction = 0.1
    assert "molten" not in pipeline.warned(ds, friction=friction).kinds
    hottest = pipeline.decisive_temperature(ds, friction=friction) - ds_bulk(ds)
    molten = friction * (1700.0 - ds_bulk(ds)) / float(hottest.max())
    assert "molten" not in pipeline.warned(ds, friction=0.999 * molten).kinds
    warned = pipeline.warned(ds, friction=1.001 * molten)
    assert warned.kinds["molten"] == 1
    margin = ("margin", tmp_path / "tiny.zarr", "--load=600 N", "--velocity=1.5 m/s", "--friction")
    assert "where steel melts" in irg(*margin, f"{1.001 * molten:.9g}")
    assert "where steel melts" not in irg(*margin, f"{0.999 * molten:.9g}")


def ds_bulk(ds):
    """Bulk temperature of a sweep [K]."""
    return pipeline.boundary(ds).attrs["bulk_temperature"]
