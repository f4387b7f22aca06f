"""The next command that a result calls for."""

import shlex

import pytest

from pipeline.analysis.at import at
from pipeline.analysis.dataset import read_conditions, stored_sweep
from pipeline.analysis.margin_frame import margin
from pipeline.cli.next_steps import (
    after_boundary,
    command_that_decides,
    lines_on,
    more_of_boundary,
)
from pipeline.cli.parser import parse
from pipeline.store.schema import DONE, FAILED, PENDING
from tests.helpers import synthetic

DRAFT = {
    "preset": "draft",
    "arguments": ("my scene.toml", "--preset=draft", "--set=sweep.fields=1"),
}

EXACT = {"model_scatter": 0.0, "measured": ()}
"""A model without an error of its own."""


def commands(lines):
    return [shlex.split(line.partition("next: ")[2])[1:] for line in lines]


def test_a_boundary_at_draft_is_followed_by_one_of_known_accuracy():
    draft = stored_sweep(synthetic.sweep(**DRAFT))
    (command,) = commands(after_boundary(draft, "out/look.zarr"))
    options = parse(command)
    assert str(options.scene) == "my scene.toml"
    assert options.preset is None
    assert options.accuracy == 0.02
    assert str(options.output) == "out/look_accurate.zarr"
    picked = synthetic.selection(accuracy=0.02, error=0.07)
    for changes in ({"preset": "standard"}, {"selection": picked}):
        assert not list(after_boundary(draft.changed(**changes), "look.zarr"))


def deciding(ds, load, velocity, **conditions):
    ds = at(ds, **conditions)
    near = margin(ds, load, velocity)
    assert (near.verdict, near.is_open_by_model) == ("not decided", False)
    judged = read_conditions(ds).as_dict()
    decided = command_that_decides(ds, "look.zarr", near, judged)
    return [shlex.split(decided)[1:]] if decided else []


@pytest.mark.parametrize(("velocity", "accuracy"), [(1.25, 0.01), (1.165, 0.05)])
def test_a_margin_within_the_error_of_its_preset_is_decided_by_a_better_one(velocity, accuracy):
    ds = synthetic.sweep(**DRAFT | EXACT)
    (command,) = deciding(ds, 750.0, velocity)
    options = parse(command)
    assert str(options.output) == "look_accurate.zarr"
    assert options.accuracy == accuracy


def test_what_the_models_own_error_leaves_open_is_decided_by_a_test_and_by_no_computation():
    near = margin(synthetic.sweep(preset="reference"), 400.0, 2.1)
    assert (near.verdict, near.is_open_by_model) == ("not decided", True)
    (line,) = lines_on(["irg point …"], by_model=True)
    assert line.startswith("no computation decides this, because of the model's own error: test")


@pytest.mark.parametrize(("status", "retry"), [(PENDING, False), (FAILED, True)])
def test_a_margin_at_a_point_that_is_not_done_is_decided_by_running_it(status, retry):
    jagged = synthetic.jagged(0.1)
    missing = {(400.0, 2.25): status}
    ds = synthetic.sweep(rise=jagged, status=missing, arguments=("edge.toml",), **EXACT)
    (command,) = deciding(ds, 400.0, 2.25)
    options = parse(command)
    assert (str(options.output), options.retry_failed) == ("look.zarr", retry)


def test_a_margin_between_coarse_points_is_decided_by_computing_the_place():
    told = {"arguments": ("edge.toml",), "preset": "standard"} | EXACT
    ds = synthetic.sweep(rise=synthetic.jagged(0.1), **told)
    (command,) = deciding(ds, 410.0, 2.2, friction=0.099)
    options = parse(command)
    assert (command[0], options.load, options.velocity) == ("point", 410.0, 2.2)
    assert dict(options.set) == {"friction.coefficient": 0.099}


@pytest.mark.parametrize(
    ("status", "friction", "words"),
    [
        (DONE, 0.12, ["--boundary-only", "--set=friction.coefficient=0.12"]),
        (PENDING, 0.12, []),
        (FAILED, 0.1, ["--retry-failed"]),
    ],
)
def test_missing_points_come_before_those_of_other_conditions(status, friction, words):
    ds = synthetic.sweep(status={(600.0, 2.0): status}, arguments=("edge.toml", "--preset=draft"))
    command = more_of_boundary(ds, "edge.zarr", synthetic.CONDITIONS | {"friction": friction})
    assert shlex.split(command) == [
        *["irg", "run", "edge.toml", "--preset=draft", "-o", "edge.zarr"],
        *words,
    ]
