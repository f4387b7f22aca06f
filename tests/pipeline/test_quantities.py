"""Quantities as text with units, wherever the command takes them."""

import pytest
import xarray as xr

import pipeline
from pipeline.analysis.scenes import heads_of, shown_label, value_text
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


@pytest.mark.parametrize(
    ("path", "unit", "value", "head", "text"),
    [
        ("oil.pressure_viscosity_coefficient", "m2 N-1", 15e-9, "1/GPa", "15 1/GPa"),
        ("wear.specific_wear_rate", "m2 N-1", 1.2e-15, "mm³/(N m)", "1.2e-06 mm³/(N m)"),
        ("oil.kinematic_viscosity", "m2 s-1", 46e-6, "mm²/s", "46 mm²/s"),
        ("materials.steel.thermal_conductivity", "W m-1 K-1", 45.0, "W/(m K)", "45 W/(m K)"),
        ("disk.roughness.ra", "m", 0.2e-6, "µm", "0.2 µm"),
        ("pin.radius", "m", 2e-3, "mm", "2 mm"),
        ("temperature.bulk", "K", 353.15, "°C", "80 °C"),
        ("housing", "Pa", 2e9, "GPa", "2 GPa"),  # a column of one's own
        ("window.pixels", "1", 128.0, None, "128"),
        ("variant", "", 3.0, None, "3"),
    ],
)
def test_labels_of_rows_have_the_unit_of_their_entry_and_not_of_its_dimension(
    path, unit, value, head, text
):
    axis = xr.DataArray([value], dims=[path], coords={path: [value]}, attrs={"units": unit})
    axis.name = path
    assert heads_of(xr.Dataset({path: axis}), [path]) == {
        path: f"{path} [{head}]" if head else path
    }
    assert value_text(axis, value) == text
    assert shown_label(axis, value) == pytest.approx(float(text.split()[0]))
