"""Quantities as text with units, wherever the command takes them."""

import xarray as xr

import pipeline
from tests.helpers import synthetic, tiny


def test_a_point_is_the_same_from_text_as_from_numbers():
    text = pipeline.run_point(tiny.sweep(), "0.25 kN", "3.6 km/h")
    number = pipeline.run_point(tiny.sweep(), 250.0, 1.0)
    assert text.point == number.point
    assert (text.state.pressure == number.state.pressure).all()


def test_a_boundary_and_a_margin_take_text():
    ds = synthetic.sweep()
    text, number = (
        {"bulk_temperature": "40 degC", "critical_area_fraction": "20%"},
        {"bulk_temperature": 313.15},
    )
    one, other = (
        pipeline.boundary(ds, **text),
        pipeline.boundary(ds, **number, critical_area_fraction=0.2),
    )
    xr.testing.assert_identical(one, other)
    one, other = pipeline.margin(ds, "500 N", "100 cm/s"), pipeline.margin(ds, 500.0, 1.0)
    xr.testing.assert_identical(one, other)
