"""Values of options: what could mean two things is refused."""

import re
from argparse import ArgumentTypeError as Refused

import pytest

import pipeline
import tribo
from pipeline.cli import values
from pipeline.cli.given import conditions_in
from pipeline.cli.options import CRITERION, PRESET
from pipeline.cli.parser import parse
from tests.helpers import synthetic


@pytest.mark.parametrize(("text", "share"), [("10%", 0.1), ("0.1", 0.1), ("0", 0.0)])
def test_a_failing_share_may_be_in_percent_or_nothing(text, share):
    assert values.failing_share(text) == share


def test_the_help_names_every_criterion_and_preset_that_ships():
    told = re.findall(r'"(\w+)"', CRITERION.settings["help"])
    assert told == [*tribo.CRITERIA]
    told = PRESET.settings["help"].rpartition(": ")[2].replace(" or ", ", ").split(", ")
    assert told == [*tribo.PRESETS]


def test_a_friction_may_be_repeated():
    def read(*words):
        return conditions_in(parse(["boundary", "out.zarr", *words])).get("friction")

    assert read() is None
    assert read("--friction", "0.1") == 0.1
    assert read("--friction", "0.1", "--friction", "0.2") == (0.1, 0.2)


def test_a_value_that_a_store_is_judged_at_has_its_unit(irg, monkeypatch):
    monkeypatch.setattr(pipeline, "open_sweep", lambda path: synthetic.sweep())

    def judged(*entries, **options):
        return irg("boundary", "out.zarr", *(f"--at={entry}" for entry in entries), **options)

    for entry in ("temperature.critical=150", "pin.radius=3"):
        path, _, number = entry.partition("=")
        said = judged(entry, code=2)
        assert f"--at: {path} is {number}, without a unit; give one such as" in said
    said = judged("pin.radius=3 mm", code=2)
    assert "run the scene with pin.radius = 3 mm into another store" in said
    said = judged("temperature.critical=150 degC", "friction.coefficient=0.12")
    assert "above 150 °C; friction 0.12, bulk 25 °C" in said
    same = irg("boundary", "out.zarr", "--critical-temperature=150 degC", "--friction=0.12")
    assert said == same
    assert "is given twice" in irg(
        "boundary", "out.zarr", "--at=friction.coefficient=0.1", "--friction=0.12", code=2
    )


def test_a_boundary_alone_is_computed_to_one_percent_unless_another_tolerance_is_given():
    def read(*words):
        return parse(["run", "first_try", *words]).boundary_only

    assert (read(), read("--boundary-only"), read("--boundary-only", "2%")) == (None, 0.01, 0.02)


def test_values_below_zero_reach_their_options():
    def read(*options):
        return parse(["boundary", "out.zarr", *options])

    assert read("--bulk-temperature", "-5degC").bulk_temperature == pytest.approx(268.15)
    assert read("--share", "-5%").share == -0.05
    assert read("--friction", "-.1", "-q").friction == [-0.1]
    assert read("--bulk-temperature", "-5 degC").bulk_temperature == pytest.approx(268.15)


@pytest.mark.parametrize(
    ("read", "text", "value"),
    [
        (values.sides, "0.8 um,0.9 um", (8e-7, 9e-7)),
        (values.bulk, "25 degC", 298.15),
        (values.bulk, "pin=60 degC, disk=25 degC", {"pin": 333.15, "disk": 298.15}),
        (values.setting, "wear.pattern=local", ("wear.pattern", "local")),
        (values.settings, "friction.coefficient=0.08,0.12", ("friction.coefficient", [0.08, 0.12])),
        (values.settings, "pin.radius=2 mm,+20%", ("pin.radius", ["2 mm", "+20%"])),
        (values.pair, "load=F_N / N", ("load", "F_N / N")),
    ],
)
def test_text_is_read_in_si_or_as_in_a_scene(read, text, value):
    assert read(text) == value


@pytest.mark.parametrize("text", ["20 degC", "68 degF"])
def test_a_margin_is_no_temperature(text):
    read = values.quantity("20 K")
    assert read("20 K") == read("20K") == 20.0
    with pytest.raises(Refused, match="is a temperature; give a difference"):
        read(text)
