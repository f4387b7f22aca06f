"""Quantities as text with units, wherever the command takes them."""

import pytest
import xarray as xr

import pipeline
from tests.helpers import synthetic, tiny
from tribo import InputError


def test_a_point_is_the_same_from_text_as_from_numbers():
    text = pipeline.run_point(tiny.sweep(), "0.25 kN", "3.6 km/h")
    number = pipeline.run_point(tiny.sweep(), 250.0, 1.0)
    assert text.point == number.point
    assert (text.state.pressure == number.state.pressure).all()


def test_a_boundary_and_a_margin_take_text():
    ds = synthetic.sweep()
    text = pipeline.at(ds, bulk_temperature="40 degC", share="20%")
    number = pipeline.at(ds, bulk_temperature=313.15, share=0.2)
    xr.testing.assert_identical(pipeline.boundary(text), pipeline.boundary(number))
    text, number = pipeline.margin(ds, "500 N", "100 cm/s"), pipeline.margin(ds, 500.0, 1.0)
    assert repr(text) == repr(number)  # with NaN, which is not equal to itself


@pytest.mark.parametrize(
    ("use", "words"),
    [
        (lambda: pipeline.run_point(tiny.sweep(), "600", "1 m/s"), '^load: "600" has no unit'),
        (lambda: pipeline.run_point(tiny.sweep(), 600.0, "1 N"), "^velocity: .*such as "),
        (lambda: pipeline.margin(synthetic.sweep(), "600 kg", 1.0), "^load: .*converted to N"),
        (lambda: pipeline.at(synthetic.sweep(), share="ten"), '^"ten": give a share'),
        (lambda: pipeline.plot(synthetic.sweep(), "ramp", load="6 m"), "^load: "),
    ],
)
def test_text_that_is_no_such_quantity_is_refused(use, words):
    with pytest.raises(InputError, match=words):
        use()
