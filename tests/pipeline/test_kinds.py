"""Refusals of single values: what causes each at every door; tests/kept has what it says."""

import io
from contextlib import redirect_stderr

import pytest

from pipeline import load_scene, run_point
from pipeline.cli import main
from pipeline.condition_kinds import BULK, FRICTION, OperatingPoints
from pipeline.kinds import LOAD, SPEED, WORKERS
from tests.helpers.refusals import refusal_tests
from tribo import TriboError


def entry(path, value):
    return lambda: load_scene("first_try", overrides={path: value})


def scan(unit, **more):
    roughness = {"file": "a.npy", "height_unit": unit} | more
    overrides = {"without": ["disk.roughness"], "disk.roughness": roughness}
    return lambda: load_scene("first_try", overrides=overrides)


def transition(step):
    test = {"load": "4 N", "velocity": "1 m/s", "outcome": "transition", "step": step}
    return entry("tests", [test])


REFUSALS = {
    "empty text": entry("title", ""),
    "control": entry("title", "a\0"),
    "choice": entry("pin.shape", "cylindr"),
    "number": entry("materials.steel.poisson_ratio", 0.6),
    "no number": entry("materials.steel.poisson_ratio", "0.3"),
    "large": entry("disk.roughness.seed", 2**63),
    "no unit": lambda: LOAD.value(400.0),
    "zero": lambda: SPEED.value("0 m/s"),
    "far": lambda: BULK.argument("bulk", 25),
    "in SI": lambda: BULK.argument("bulk", "25 C"),
    "a list": lambda: FRICTION.argument("friction", [0.1, 0.2]),
    "count": lambda: WORKERS.argument("workers", 0),
    "step": transition("3 mm"),
    "step without a unit": transition(3),
    "height unit": scan("parsnip"),
    "flag": scan("um", mirror="yes"),
}  # fmt: skip

refusals, test_each_is_one_line, test_all_read_as_they_are_kept, test_all_are_here = refusal_tests(
    "kinds.py", REFUSALS
)


@pytest.mark.parametrize(
    ("value", "problem"),
    [
        ("400", "has no unit"),
        ("-4 N", '"-4 N" is outside the allowed range'),
        ("4 kg", '"4 kg" cannot be converted to N'),
        ("1e30 N", '"1e30 N" is outside the allowed range, which is 1e-9 N to 1e9 N'),
    ],
)
def test_a_load_is_refused_by_the_same_words_at_every_door(value, problem):
    printed = io.StringIO()
    with redirect_stderr(printed), pytest.raises(SystemExit):
        main(["margin", "a.zarr", f"--load={value}", "--velocity=1 m/s"])
    messages = [printed.getvalue()]
    for read in (
        entry("sweep.loads", [value]),
        lambda: OperatingPoints.read({"load": [value], "velocity": ["1 m/s"]}),
        lambda: run_point("first_try", value, "1 m/s"),
    ):
        with pytest.raises(TriboError) as error:
            read()
        messages.append(str(error.value))
    for message in messages:
        assert f"{problem}; give a load above 0, such as" in message
