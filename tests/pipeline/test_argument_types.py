"""Arguments of a wrong type of public functions: each is refused in a line, by its name."""

import inspect

import numpy as np
import pytest

import pipeline
import tribo
from tribo import inverse

SCENE = pipeline.load_scene("first_try")
CONDITIONS = "friction", "bulk_temperature", "critical_temperature", "critical_area_fraction"
PUBLIC = [getattr(pipeline, name) for name in pipeline.__all__]
FUNCTIONS = [function for function in PUBLIC if inspect.isfunction(function)]
WRONG = [object(), {"a": 1}, [1, [2]], b"x", 1j]
SKIPPED = {
    ("margin", "load"): "a mapping is a table of operating points",
    ("report", "points"): "a mapping is a table of operating points",
    ("load_scene", "overrides"): "a mapping is right",
    ("run_sweep", "patience"): "is compared when workers are lost",
    ("run_sweep", "client"): "is a client of any kind",
    ("trade", "accuracies"): "is a list",
}
"""Arguments that are not tried, each with the reason."""


@pytest.fixture
def valid(tiny_store, tmp_path):
    """Valid arguments by name."""
    return {
        "path": tmp_path / "a.toml", "out": tmp_path / "a.zarr", "sweep": SCENE, "scene": SCENE,
        "ds": tiny_store,
        "load": "300 N", "velocity": "2 m/s", "text": "1 N", "like": "1 N", "workers": 1,
    }  # fmt: skip


def arguments_of(function):
    """Names of the arguments of a function, with conditions in place of further ones."""
    for name, parameter in inspect.signature(function).parameters.items():
        if parameter.kind is not parameter.VAR_KEYWORD:
            yield name
        elif name == "conditions" and function is not pipeline.infer:
            yield from CONDITIONS


def refused(function, arguments, name):
    with pytest.raises(tribo.TriboError) as error:
        function(**arguments)
    message = str(error.value)
    assert name in message.replace(" ", "_"), (function.__name__, name, message)
    assert "\n" not in message


@pytest.mark.parametrize("function", FUNCTIONS, ids=lambda function: function.__name__)
def test_an_argument_of_a_wrong_type_is_refused_by_its_name(function, valid):
    names = [*arguments_of(function)]
    left_out = {"out"} if function in (pipeline.plot, pipeline.report) else set()
    needed = {name: valid[name] for name in names if name in valid.keys() - left_out}
    for name in names:
        for value in WRONG:
            if (function.__name__, name) not in SKIPPED:
                refused(function, needed | {name: value}, name)


OUT_OF_RANGE = {"load": (0.0, -1.0, "-1 N", np.nan, np.inf), "velocity": (-1.0, np.nan, np.inf)}


@pytest.mark.parametrize("function", [pipeline.run_point, pipeline.plot])
def test_a_point_out_of_range_is_refused_by_its_load_or_velocity(function, valid):
    subject = {"ds": valid["ds"]} if function is not pipeline.run_point else {"sweep": SCENE}
    point = {name: valid[name] for name in OUT_OF_RANGE}
    for name, values in OUT_OF_RANGE.items():
        for value in values:
            refused(function, subject | point | {name: value}, name)


@pytest.mark.parametrize(
    ("name", "argument"),
    [("changed", "path"), ("case", "name"), ("judge", "changes"), ("with_fidelity", "preset")],
)
def test_an_argument_of_a_method_is_refused_by_its_name(name, argument):
    method = getattr(SCENE, name)
    valid = {"value": 1, "fidelity": SCENE.scene.fidelity}
    names = inspect.signature(method).parameters
    for value in (3.0, object(), [1], b"x"):
        arguments = {key: valid[key] for key in names if key in valid}
        refused(method, arguments | {argument: value}, argument)


def test_the_inverse_of_wear_refuses_arguments_by_their_names():
    valid = {"contact_width": 2e-4, "normal_load": 100.0, "velocity": 1.0}
    for name in ("scene", *valid):
        for value in (None, object(), "2 mm", float("nan"), -1.0):
            refused(inverse.specific_wear_rate, {"scene": SCENE.scene, **valid, name: value}, name)
