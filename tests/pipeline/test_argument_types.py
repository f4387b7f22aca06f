"""Values, scenes, datasets and paths of a wrong type as arguments: each is refused in a line."""

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
WORDS = {
    "path": "path", "out": "path", "source": "path",
    "sweep": "a scene is of type", "scene": "a scene is of type", "ds": "ds is of type",
}  # fmt: skip
"""What the refusal of an argument says, if not its name."""
READ = {
    *WORDS, *CONDITIONS, "load", "velocity", "realization", "workers", "accuracy", "width",
    "text",
}  # fmt: skip
"""Arguments that are read by a kind, or of which there is a path; Python refuses the others."""
SKIPPED = {
    ("margin", "load"): "a mapping is a table of operating points",
    ("plot", "out"): "the suffix of its text is refused",
    ("report", "out"): "the suffix of its text is refused",
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
    assert name in message, (function.__name__, name, message)
    assert "\n" not in message


@pytest.mark.parametrize("function", FUNCTIONS, ids=lambda function: function.__name__)
def test_an_argument_of_a_wrong_type_is_refused_by_its_name(function, valid):
    names = [*arguments_of(function)]
    left_out = {"out"} if function in (pipeline.plot, pipeline.report) else set()
    needed = {name: valid[name] for name in names if name in valid.keys() - left_out}
    for name in names:
        for value in WRONG:
            if name in READ and (function.__name__, name) not in SKIPPED:
                refused(function, needed | {name: value}, WORDS.get(name, name))


OUT_OF_RANGE = {"load": (0.0, -1.0, "-1 N", np.nan, np.inf), "velocity": (-1.0, np.nan, np.inf)}


@pytest.mark.parametrize("function", [pipeline.run_point, pipeline.plot])
def test_a_point_out_of_range_is_refused_by_its_load_or_velocity(function, valid):
    subject = {"ds": valid["ds"]} if function is not pipeline.run_point else {"sweep": SCENE}
    point = {name: valid[name] for name in OUT_OF_RANGE}
    for name, values in OUT_OF_RANGE.items():
        for value in values:
            refused(function, subject | point | {name: value}, name)


def test_a_misspelt_argument_is_refused_by_words(valid):
    with pytest.raises(tribo.InputError, match="autor is not a condition"):
        pipeline.report(valid["ds"], autor="A. Smith")
    with pytest.raises(tribo.InputError, match="velocity is missing; give both a load and a vel"):
        pipeline.margin(valid["ds"], "400 N")


def test_the_inverse_of_wear_refuses_arguments_by_their_names():
    valid = {"contact_width": 2e-4, "normal_load": 100.0, "velocity": 1.0}
    for name in ("scene", *valid):
        for value in (None, object(), "2 mm", float("nan"), -1.0):
            refused(inverse.specific_wear_rate, {"scene": SCENE.scene, **valid, name: value}, name)
