"""What a person typed is printed as typed, and called unusual at each entry point."""

import pytest

import pipeline
from pipeline.answers.answer_frames import complete_frame
from pipeline.answers.scene_wording import warning_lines
from tests.helpers import synthetic

TABLE = """load [N],velocity [m/s],critical temperature [degC],bulk temperature [degC],friction
312.345,1.23456,145,62.55,0.0875512
500.125,2.00001,148.253,25,0.1
"""
UNUSUAL = "friction.coefficient: 12 is unusual (0 to 1 is common): check number and unit"


def test_a_table_of_points_is_printed_with_all_typed_digits(tiny_store, irg, tmp_path):
    (tmp_path / "own.csv").write_text(TABLE, encoding="utf-8")
    printed = irg("margin", tiny_store, "--points", tmp_path / "own.csv", "--all")
    rows = [line.split() for line in printed.splitlines()]
    for line in TABLE.splitlines()[1:]:
        typed = {*line.split(",")}
        assert any(typed <= {*row} for row in rows), printed


def test_the_headline_and_conditions_have_all_typed_digits(tiny_store, irg):
    printed = irg(
        "margin", tiny_store, "--load", "312.345 N", "--velocity", "1.23456 m/s",
        "--friction", "0.0875512", "--critical-area-fraction", "0.123456",
        "--critical-temperature", "145.253 degC",
    )  # fmt: skip
    printed = " ".join(printed.split())
    for typed in ("at 312.345 N and 1.23456 m/s", "friction 0.0875512", "145.253 °C", "12.3456 %"):
        assert typed in printed


@pytest.mark.parametrize("suffix", ["txt", "csv"])
def test_several_conditions_of_a_boundary_have_their_unit(tiny_store, irg, tmp_path, suffix):
    file = tmp_path / f"boundary.{suffix}"
    several = [
        word for text in ("145.5 degC", "155 degC") for word in ("--critical-temperature", text)
    ]
    printed = irg("boundary", tiny_store, *several, *(["-o", file] if suffix == "csv" else []))
    text = file.read_text("utf-8") if suffix == "csv" else " ".join(printed.split())
    assert "[°C]" in text
    assert "145.5" in text
    assert "155" in text
    assert "418.6" not in text


def test_lists_of_conditions_are_coordinates_with_units_and_long_names():
    ds = synthetic.sweep((200.0, 400.0, 750.0), (1.0, 2.0, 4.0))
    lists = {
        "friction": [0.09, 0.1], "bulk_temperature": ["25 degC"],
        "critical_temperature": ["145 degC", "155 degC"], "critical_area_fraction": [0.1],
        "added_rise_fraction": [0.0, 0.06],
    }  # fmt: skip
    for answer in (pipeline.boundary(ds, **lists), pipeline.margin(ds, 300.0, 1.5, **lists)):
        for name, values in lists.items():
            assert answer[name].dims == (name,)
            assert answer.sizes[name] == len(values)
            assert answer[name].attrs["units"] in ("1", "K")
            assert answer[name].attrs["long_name"]


@pytest.mark.parametrize("command", [
    ("margin", "--load", "300 N", "--velocity", "1.5 m/s", "--friction", "12"),
    ("margin", "--load", "300 N", "--velocity", "1.5 m/s", "--friction", "0.1", "--friction", "12"),
    ("boundary", "--friction", "12"),
    ("boundary", "--at", "friction.coefficient=12"),
    ("boundary", "--by", "test", "--friction", "12"),
])  # fmt: skip
def test_commands_call_an_unusual_condition_unusual(tiny_store, irg, command):
    verb, *options = command
    code = 2 if "test" in options else 0
    printed = " ".join(irg(verb, tiny_store, *options, code=code).split())
    assert (f"warning: {UNUSUAL}" in printed) == (code == 0)


def test_a_table_of_points_calls_an_unusual_condition_unusual(tiny_store, irg, tmp_path):
    (tmp_path / "own.csv").write_text(TABLE.replace("0.0875512", "12"), encoding="utf-8")
    printed = irg("margin", tiny_store, "--points", tmp_path / "own.csv")
    assert f"warning: {UNUSUAL}" in " ".join(printed.split())


UNUSUAL_CONDITIONS = {
    "friction": (12.0, UNUSUAL),
    "bulk_temperature": (221.0, "temperature.bulk: -52.1 °C is unusual (-50 to 250 °C is common)"),
    "critical_temperature": ("45 degC", "temperature.critical: 45 °C is unusual (50 to 800 °C is"),
    "added_rise_fraction": (0.8, "model.rise: 0.8 is unusual (0 to 0.5 is common)"),
}


@pytest.mark.parametrize("name", UNUSUAL_CONDITIONS)
def test_answers_in_python_call_an_unusual_condition_unusual(name):
    ds, (value, text) = synthetic.sweep(), UNUSUAL_CONDITIONS[name]
    usual = {"friction": 0.1, "critical_temperature": 400.0}.get(name, 0.2)
    for condition in (value, [value]):
        for answer in (
            pipeline.margin(ds, 300.0, 1.5, **{name: condition}),
            pipeline.boundary(ds, **{name: condition}),
        ):
            assert f"warning: {text}" in answer.attrs["notes"]
    if name != "bulk_temperature":
        assert "unusual" not in pipeline.boundary(ds, **{name: usual}).attrs["notes"]


def test_answers_do_not_repeat_a_warning_of_the_scene_itself():
    ds = synthetic.sweep(conditions=synthetic.CONDITIONS | {"friction": 12.0})
    assert "unusual" not in pipeline.margin(ds, 300.0, 1.5, friction=12.0).attrs["notes"]
    assert "13 is unusual" in pipeline.margin(ds, 300.0, 1.5, friction=13.0).attrs["notes"]


def test_a_column_place_of_a_table_is_printed_with_its_words():
    table = {"place": ["nose", "base"], "load [N]": [300, 500], "velocity [m/s]": [1.5, 2.0]}
    frame = complete_frame(pipeline.margin(synthetic.sweep(), table))
    assert frame["place"].tolist() == ["nose", "base"]
    assert frame["load [N]"].tolist() == [300, 500]
    assert {"conditions", "model_error", "not_included", "notes"} < {*frame}


def test_of_many_warnings_of_a_scene_an_answer_has_the_first_three_and_counts_the_others():
    entries = {"friction.coefficient": 1.5, "without": ["friction.band"], "pin.radius": "2 m"}
    entries |= {"materials.steel.hardness": "50 GPa", "temperature.critical": "900 degC"}
    sweep = pipeline.load_scene("first_try", overrides=entries)
    first, count = [f"warning: {w.text}" for w in sweep.all_warnings[:3]], len(sweep.all_warnings)
    assert warning_lines(sweep) == [*first, f"{count - 3} more warnings: irg check first_try"]
    assert count > 4
