"""The next command that a result calls for."""

import shlex

import pytest

from pipeline.analysis.dataset import stored_sweep
from pipeline.analysis.decisive import conditions_of
from pipeline.analysis.margins import margins
from pipeline.cli.next_steps import (
    after_boundary,
    commands_that_decide,
    more_of_boundary,
    next_tests,
)
from pipeline.cli.parser import parse
from pipeline.store.schema import DONE, FAILED, PENDING
from tests.helpers import synthetic

DRAFT = {
    "preset": "draft",
    "arguments": ("my scene.toml", "--preset=draft", "--set=sweep.fields=1"),
}


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
    near = margins(ds, load, velocity, **conditions)
    assert [here.verdict for here in near] == ["not decided"]
    judged = conditions_of(ds, **conditions).as_dict()
    return [shlex.split(line)[1:] for line in commands_that_decide(ds, "look.zarr", near, judged)]


@pytest.mark.parametrize(("velocity", "accuracy"), [(1.25, 0.01), (1.165, 0.05)])
def test_a_margin_within_the_error_of_its_preset_is_decided_by_a_better_one(velocity, accuracy):
    ds = synthetic.sweep(**DRAFT)
    (command,) = deciding(ds, 750.0, velocity)
    options = parse(command)
    assert str(options.output) == "look_accurate.zarr"
    assert options.accuracy == accuracy


@pytest.mark.parametrize(("status", "retry"), [(PENDING, False), (FAILED, True)])
def test_a_margin_at_a_point_that_is_not_done_is_decided_by_running_it(status, retry):
    jagged = synthetic.jagged(0.1)
    ds = synthetic.sweep(rise=jagged, status={(400.0, 2.25): status}, arguments=("edge.toml",))
    (command,) = deciding(ds, 400.0, 2.25)
    options = parse(command)
    assert (str(options.output), options.retry_failed) == ("look.zarr", retry)


def test_a_margin_between_coarse_points_is_decided_by_computing_the_place():
    ds = synthetic.sweep(rise=synthetic.jagged(0.1), arguments=("edge.toml",), preset="standard")
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


def test_tests_are_ranked_for_all_stores_as_they_were_weighed():
    stores = ["my rig.zarr", "other.zarr"]
    at = {"pin.radius": "2 mm"}
    options = parse(shlex.split(next_tests(stores, 0.08, at, "temperature.critical"))[1:])
    assert list(map(str, options.scene)) == stores
    assert options.at == [*at.items()]
    assert (options.next, options.target, options.scatter) == (1, "temperature.critical", 0.08)
