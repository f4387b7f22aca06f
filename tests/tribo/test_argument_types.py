"""Arguments of a wrong type: each is refused by its name."""

import inspect

import numpy as np
import pytest

import tribo
from tests.helpers.scenes import STEEL, small_scene
from tribo import analytic

SCENE = small_scene()
CONDITIONS = tribo.Conditions(0.1, 298.0, 418.0)
STATES = list(tribo.simulate(SCENE, 300.0, 1.0))

CALLS = {
    tribo.Material: {name: getattr(STEEL, name) for name in STEEL.__dataclass_fields__},
    tribo.contact_modulus: {"first": STEEL, "second": STEEL},
    tribo.Cylinder: {"radius": 2e-3, "length": 3e-3, "material": STEEL},
    tribo.Ball: {"radius": 2e-3, "material": STEEL},
    tribo.Crowned: {"radius": 2e-3, "crown_radius": 0.1, "material": STEEL},
    tribo.Grid: {"shape": (4, 4), "spacing": (1e-6, 1e-6), "periodic": (False, True)},
    tribo.SelfAffineRoughness: {
        "ra": 1e-7, "hurst_exponent": 0.8, "correlation_length": (4e-6, 4e-6), "seed": 1,
    },
    tribo.MeasuredRoughness: {"array": np.ones((4, 4))},
    tribo.Ramp: {"rate": 150.0, "reference_load": 750.0, "hold": 1.0},
    tribo.Stages: {"loads": (1.0, 2.0), "hold_times": (1.0, 1.0), "rate": 1.0},
    tribo.MeasuredLoad: {
        "times": [0.0, 1.0], "loads": [0.0, 1.0], "reference_load": 1.0,
    },
    tribo.Motion: {
        "slide_roll_ratio": 1.0, "pin_track_length": 1.0, "disk_track_length": 1.0,
    },
    tribo.Wear: {"specific_wear_rate": 1e-15, "pattern": "swept"},
    tribo.Fidelity: {
        "pixels_per_element": 2, "increments": 6, "fewest_elements": 0, "imprint": 0.1,
        "contact_tolerance": 1e-6,
    },
    tribo.Scene: {
        name: getattr(SCENE, name)
        for name in ("pin", "disk", "pixels", "loading", "roughness", "wear", "fidelity")
    } | {"motion": tribo.Motion(slide_roll_ratio=1.0)},
    tribo.simulate: {"scene": SCENE, "normal_load": 300.0, "velocity": 1.0},
    tribo.measures: {"scene": SCENE, "state": STATES[-1]},
    tribo.warnings: {"scene": SCENE, "state": STATES[-1], "conditions": CONDITIONS},
    tribo.Conditions: {
        "friction": 0.1, "bulk_temperature": 298.0, "critical_temperature": 418.0,
        "added_rise_fraction": 0.0, "critical_area_fraction": 0.1,
        "corrections": tribo.Corrections(),
    },
    tribo.judge: {"scene": SCENE, "load": 300.0, "velocity": 1.0, "conditions": CONDITIONS},
    tribo.Disc: {"diameter": 0.1, "width": 0.01},
    tribo.Oil: {"viscosities": (32e-6, 5e-6), "density": 866.0, "pressure_coefficient": 20e-9},
    tribo.lubrication_regime: {"film_parameter": 1.0},
    analytic.hertz_line_half_width: {
        "load_per_length": 1e5, "radius": 2e-3, "contact_modulus": 1e11,
    },
    analytic.hertz_point_radius: {"normal_load": 1.0, "radius": 2e-3, "contact_modulus": 1e11},
    analytic.hertz_ellipse: {
        "normal_load": 1.0, "radius_x": 2e-3, "radius_y": 4e-3, "contact_modulus": 1e11,
    },
    analytic.hertz_contact: {"normal_load": 1.0, "contact_modulus": 1e11, "radius": 2e-3},
    analytic.hertz_line_peak_pressure: {
        "load_per_length": 1e5, "radius": 2e-3, "contact_modulus": 1e11,
    },
    analytic.hertz_point_peak_pressure: {
        "normal_load": 1.0, "radius": 2e-3, "contact_modulus": 1e11,
    },
    analytic.hertz_pressure: {"contact_radius": 1e-4, "peak_pressure": 1e9},
    analytic.rolling_sliding_rise: {
        "friction": 0.1, "load_per_length": 1e5, "width": 2e-4, "velocities": (1.0, 2.0),
        "thermal_effusivity": 1e4,
    },
    tribo.Corrections: {"track": None, "pin_track": None, "motion": None},
    tribo.Track: {
        "length": 0.3, "width": 3e-3, "aspect": 1.0, "thermal_diffusivity": 1e-5,
        "heat_capacity": 4e6,
    },
    analytic.worn_line_width: {"worn_area": 1e-10, "radius": 2e-3},
    analytic.worn_point_width: {"worn_volume": 1e-14, "radius": 2e-3},
}  # fmt: skip
"""Valid arguments of public functions and classes."""

WRONG = ["2 mm", object(), {}, [], [1.0, 2.0], 1j, None]
OPTIONAL = (
    "conditions", "critical_temperature", "motion", "roughness", "wear", "corrections",
    "track", "pin_track", "reference_load", "pin_track_length", "disk_track_length",
    "pressure_coefficient", "width",
)  # fmt: skip
"""Arguments that may be None."""


def wrong_values(name, valid):
    """Values of a wrong type for an argument; pairs and texts are right where they are valid."""
    for value in WRONG:
        is_optional = value is None and name in OPTIONAL
        is_pair = isinstance(value, list) and np.shape(valid) == np.shape(value)
        if not (is_optional or is_pair or (isinstance(value, str) and isinstance(valid, str))):
            yield value


def call(function, **arguments):
    if function is analytic.hertz_pressure:
        return function(0.0, **arguments)
    result = function(**arguments)
    return list(result) if function is tribo.simulate else result


@pytest.mark.parametrize("function", CALLS, ids=lambda function: function.__name__)
def test_an_argument_of_a_wrong_type_is_refused_by_its_name(function):
    arguments = CALLS[function]
    assert {*arguments} <= {*inspect.signature(function).parameters}
    for name, valid in arguments.items():
        for value in wrong_values(name, valid):
            with pytest.raises(tribo.InputError) as error:
                call(function, **arguments | {name: value})
            assert name in str(error.value), (name, value)
            assert len(str(error.value).splitlines()) == 1


CLOSED_FORMS = [function for function in CALLS if function.__module__ == analytic.__name__]


@pytest.mark.parametrize("function", CLOSED_FORMS, ids=lambda function: function.__name__)
def test_a_closed_form_refuses_sizes_and_loads_that_are_negative_or_no_number(function):
    for name, valid in CALLS[function].items():
        for value in (-1.0, np.nan, np.inf):
            wrong = (1.0, value) if isinstance(valid, tuple) else value
            with pytest.raises(tribo.InputError, match=f"{name} is {value!r}"):
                call(function, **CALLS[function] | {name: wrong})
