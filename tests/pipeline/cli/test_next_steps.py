"""The next command that a result calls for."""

import shlex
from types import SimpleNamespace

import pytest

from pipeline.analysis.at import at
from pipeline.analysis.dataset import read_conditions, stored_sweep
from pipeline.analysis.margin_frame import margin
from pipeline.cli.next_steps import (
    after_boundary,
    command_that_decides,
    lines_on,
    more_of_boundary,
    point_that_decides,
)
from pipeline.cli.parser import parse
from pipeline.store.schema import DONE, FAILED, PENDING
from pipeline.sweep.conditions import Conditions
from pipeline.sweep.model import Point
from pipeline.sweep.samples import Design, Draw
from pipeline.sweep.unknown import Unknown
from pipeline.sweep.variants import drawn_rows, rows
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


def place(distance, interpolation, preset=2.0, load=410.0, velocity=2.2, entries=()):
    """What the next command takes of a margin, 100 K above a bulk at 25 °C."""
    return SimpleNamespace(
        load=load, velocity=velocity, distance=distance, entries=dict(entries),
        error=SimpleNamespace(interpolation=interpolation, preset=preset),
        decisive_temperature=398.15,
    )  # fmt: skip


BULK = {"bulk_temperature": 298.15}
EVERYWHERE = "irg run s.toml --accuracy={}% -o look_accurate.zarr"
THERE = "irg point s.toml '--load=410 N' '--velocity=2.2 m/s' --accuracy={}%"


@pytest.mark.parametrize(
    ("preset", "margin", "command"),
    [
        # The preset errs by 8 % of the velocity, and by 2 K here: 5 % are 1.25 K.
        ("draft", place(1.3, 1.0), EVERYWHERE.format(5)),
        ("draft", place(-1.2, 2.0), EVERYWHERE.format(2)),
        ("fine", place(1.3, 1.0), None),
        # Interpolation errs by more: 8 % of the rise are 8 K, 5 % are 5 K.
        ("draft", place(5.1, 2.1), THERE.format(5)),
        ("draft", place(4.9, None), THERE.format(2)),
        (None, place(9.0, 0.5, None), THERE.format(2)),
        (None, place(9.0, 0.0, None), EVERYWHERE.format(2)),
        ("fine", place(9.0, 3.0), THERE.removesuffix(" --accuracy={}%")),
    ],
)
def test_the_larger_part_of_the_error_is_lowered_until_it_decides(preset, margin, command):
    ds = synthetic.sweep(preset=preset, arguments=("s.toml",))
    assert command_that_decides(ds, "look.zarr", margin, BULK) == command


def test_a_rise_is_above_the_colder_body():
    """Above 25 °C the rise is 100 K and errs by 8 K, above 75 °C it would err by 4 K."""
    bulks = {"bulk_temperature": 348.15, "disk_temperature": 298.15}
    unequal = Conditions(**synthetic.CONDITIONS | bulks)
    ds = synthetic.sweep(preset="draft", arguments=("s.toml",), conditions=unequal)
    decides = command_that_decides(ds, "look.zarr", place(4.9, 3.0), bulks)
    assert decides == THERE.format(2)
    other = command_that_decides(ds, "look.zarr", place(4.9, 3.0), bulks | BULK)
    assert other == f"{THERE.format(2)} '--set=temperature.bulk.pin=25 degC'"
    both = command_that_decides(ds, "look.zarr", place(2.0, 3.0), {"bulk_temperature": 323.15})
    assert both.endswith(
        "'--set=temperature.bulk.pin=50 degC' '--set=temperature.bulk.disk=50 degC'"
    )


@pytest.mark.parametrize(("preset", "accuracy"), [("draft", 5), ("standard", 2), (None, 5)])
def test_samples_are_decided_by_the_next_better_accuracy(preset, accuracy):
    rate = Unknown("wear.specific_wear_rate", "log-normal", (1.2e-15, 1.5), "m2 N-1")
    draw = Draw((rate,), Design((rate,), ("wear rate",), (0.5, 4.0), 7, 1), ())
    ds = synthetic.sweep(preset=preset, arguments=("s.toml",), variants=drawn_rows(draw, 8))
    assert command_that_decides(ds, "look.zarr", None, {}) == EVERYWHERE.format(accuracy)
    finest = synthetic.sweep(preset="fine", variants=drawn_rows(draw, 8))
    assert command_that_decides(finest, "look.zarr", None, {}) is None


def test_a_row_is_decided_by_its_own_scene_and_one_made_by_hand_in_python():
    by_file = {"arguments": ("s.toml", "--set=pin.radius=3 mm")}
    table = rows("pin.radius", {2e-3: by_file, 3e-3: {}})
    ds = synthetic.sweep(preset="draft", arguments=("s.toml",), variants=table)
    told, by_hand = (
        command_that_decides(ds, "look.zarr", place(4.9, 3.0, entries=name), BULK)
        for name in table.names
    )
    assert told == THERE.format(2).replace("s.toml", "s.toml '--set=pin.radius=3 mm'")
    assert by_hand.startswith("410 N, 2.2 m/s")
    assert by_hand.endswith(", more accurately, in Python, since no scene file has this row")


def test_conditions_of_a_boundary_replace_those_that_its_scene_was_read_with():
    given = ("s.toml", "--own-laws", "--set=friction.coefficient=0.2", "--set=sweep.fields=1")
    ds = synthetic.sweep(arguments=given)
    judged = synthetic.CONDITIONS | {"friction": 1.5, "criterion": "laws:own"}
    assert shlex.split(more_of_boundary(ds, "a.zarr", judged)) == [
        *["irg", "run", "s.toml", "--set=sweep.fields=1", "-o", "a.zarr", "--boundary-only"],
        *["--set=friction.coefficient=1.5", "--set=temperature.criterion=laws:own", "--own-laws"],
    ]
    few = synthetic.sweep(arguments=("s.toml",), chosen=(),
                          status={(400.0, 2.0): PENDING})  # fmt: skip
    assert more_of_boundary(few, "a.zarr", {}) == "irg run s.toml -o a.zarr --boundary-only"


@pytest.mark.parametrize(
    ("given", "words"),
    [
        ((), []),
        (("friction",), ["--set=friction.coefficient=0.1"]),
        (("share",), ["--set=temperature.failing_share=0.1"]),
        (("bulk_temperature",), ["--set=temperature.bulk=25 degC"]),
    ],
)
def test_a_point_that_decides_has_the_conditions_that_were_given_and_its_surface(given, words):
    sweep = stored_sweep(synthetic.sweep(preset="draft", arguments=("s.toml", "--preset=draft")))
    here = sweep, Point(1234567.0, 0.123456), 3, 1.0, 100.0, given
    (command,) = point_that_decides(*here)
    start = ["irg", "point", "s.toml", "--realization=3", "--load=1.23457e+06 N"]
    assert shlex.split(command) == [*start, "--velocity=0.123456 m/s", "--accuracy=1%", *words]
