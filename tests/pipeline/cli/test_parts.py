"""Parts of the command: values, options together, output, and what a check says, row by row."""

import argparse
import json
import math
import sys
from argparse import ArgumentTypeError as Refused
from dataclasses import replace
from pathlib import Path
from types import SimpleNamespace

import numpy as np
import pandas as pd
import pytest

import pipeline
import tribo
from pipeline.cli import given, output, stores, values
from pipeline.cli.begin import new
from pipeline.cli.output import Result, _words_on, counted, failed_points, show
from pipeline.cli.stores import _stores_below
from pipeline.cli.studies import _critical_velocities
from pipeline.cli.sweeps import _cost, _film, _library, _meaning
from pipeline.run.vary import Variation, Variations
from pipeline.scene.facts import Span, facts_of
from pipeline.store.progress import FailedPoint
from pipeline.sweep.about import FromLibrary
from pipeline.sweep.stages import Progress
from pipeline.sweep.variants import surfaces
from pipeline.tradeoff.forecast import Estimate
from pipeline.uncertain.drawn import described
from pipeline.uncertain.samples import Design, Draw, drawn_rows
from pipeline.uncertain.unknown import Fixed, Unknown
from tests.helpers import synthetic, tiny
from tests.helpers.entries import placed_rows, rows
from tribo import InputError

# Values


@pytest.mark.parametrize(
    ("read", "text", "value"),
    [
        (values.count, "3", 3),
        (values.count, "1", 1),
        (lambda text: values.count(text, 0), "0", 0),
        (values.share, "99%", 0.99),
        (values.share, "0.02", 0.02),
        (values.friction, "0.12", 0.12),
        (values.criterion, "mean", "mean"),
        (values.word, "held=mild", ("held", "mild")),
        (values.setting, "a.b=[1, 2]", ("a.b", [1, 2])),
        (values.setting, "a=true", ("a", True)),
        (values.sides, "2 um", (2e-6, 2e-6)),
        (values.store, "s3://a/b.zarr", "s3://a/b.zarr"),
        (values.store, "a/b.zarr", Path("a/b.zarr")),
        (values.new_store, "a/b.zarr", Path("a/b.zarr")),
        (values.new_store, "out", Path("out")),
        (values.quantity("750 N"), "1 kN", 1000.0),
        (values.quantity("1 m/s", is_signed=True), "-2 m/s", -2.0),
    ],
)
def test_values_are_read_as_they_are_typed(read, text, value):
    found = read(text)
    assert found == value
    assert type(found) is type(value) or isinstance(found, Path)


@pytest.mark.parametrize(
    ("read", "text", "words"),
    [
        (values.count, "0", '"0": give a whole number of at least 1'),
        (values.count, "1.5", "give a whole number"),
        (lambda text: values.count(text, 5), "4", "of at least 5"),
        (values.share, "0", "give a share between 0 and 1, such as 2%"),
        (values.share, "100%", "give a share between 0 and 1"),
        (values.share, "x", "give a share between 0 and 1"),
        (values.friction, "x", '"x": give a number such as 0.12'),
        (values.criterion, "laws:own", "give one of share, highest, mean"),
        (values.word, "held=well", '"well" is no outcome; give held=mild or held=severe'),
        (values.pair, "a=", "has no name and value; give both, like"),
        (values.pair, "=a", "has no name and value"),
        (values.bulk, "pin=60 degC", 'give one like "25 degC", or "pin=60 degC, disk=25 degC"'),
        (values.new_store, "a.toml", 'ends like a file of another kind; .* like "a.zarr"'),
        (values.new_store, "a.PNG", "ends like a file of another kind"),
        (values.quantity("750 N"), "0 N", '"0 N" is not above 0; give one like "750 N"'),
        (values.quantity("750 N"), "-1 N", "is not above 0"),
        (values.quantity("750 N"), "1 m", 'converted to N; give one like "750 N"'),
    ],
)
def test_what_is_no_such_value_is_told_what_to_give(read, text, words):
    with pytest.raises(Refused, match=words):
        read(text)


def test_a_folder_that_is_there_may_be_called_as_a_file(tmp_path):
    (tmp_path / "a.csv").mkdir()
    assert values.new_store(str(tmp_path / "a.csv")) == tmp_path / "a.csv"


# Options together


def options(**named):
    usual = {"points": None, "sheet": None, "load": None, "velocity": None, "realization": None}
    return argparse.Namespace(**usual | named)


def test_options_that_were_given_are_taken_and_no_others():
    asked = options(load=1.0, velocity=0.0, set=[], flag=False, name="")
    assert given.values_in(asked, "load", "velocity", "set", "flag", "name", "nowhere") == {
        "load": 1.0, "velocity": 0.0, "name": ""
    }  # fmt: skip
    assert given.flags_of(["bulk_temperature", "kept"]) == "--bulk-temperature, --store"
    assert given.beside(Path("a/b.zarr"), ".html") == Path("a/b.html")
    assert given.beside("s3://bucket/a/b.zarr", ".csv") == Path("b.csv")


def test_entries_are_given_once_and_fidelity_needs_no_prefix():
    read = given.settings_in(options(set=[("fidelity.increments", 7), ("pin.radius", "2 mm")]))
    assert read == {"increments": 7, "pin.radius": "2 mm"}
    with pytest.raises(InputError, match="--set: increments is given more than once; give it once"):
        given.settings_in(options(set=[("fidelity.increments", 7), ("increments", 8)]))


@pytest.mark.parametrize(
    ("asked", "words"),
    [
        ({}, "no operating point is given; give --load and --velocity, or --points"),
        ({"load": 1.0}, "no operating point is given"),
        ({"sheet": "one", "load": 1.0, "velocity": 1.0}, "--sheet names a sheet of --points; give"),
        ({"points": "a.csv", "load": 1.0}, "--points gives each load and velocity; leave out --lo"),
    ],
)
def test_an_operating_point_is_one_place_or_a_table(asked, words):
    with pytest.raises(InputError, match=words):
        given.operating_points_in(options(**asked))
    found = given.operating_points_in(options(load=400.0, velocity=2.0))
    assert [*found.places] == [(400.0, 2.0)]
    assert given.table_in(options(load=400.0, velocity=2.0)) is None


def test_conditions_of_several_frictions_are_a_tuple():
    def read(**named):
        return given.conditions_in(options(**named))

    assert read(friction=[0.1]) == {"friction": 0.1}
    assert read(friction=[0.1, 0.2]) == {"friction": (0.1, 0.2)}
    assert read(friction=0.0) == {"friction": 0.0}
    assert read(criterion="mean") == {"criterion": "mean"}


def test_an_accuracy_picks_all_numerical_choices_but_how_heat_acts():
    scene = options(
        scene="first_try", preset=None, accuracy=0.05,
        set=[("heat_model", "elapsed"), ("increments", 7), ("pin.radius", "2 mm")],
    )  # fmt: skip
    with pytest.raises(InputError, match=r"itself; leave out --set increments$"):
        given.scene_in(scene)
    scene.preset = "draft"
    with pytest.raises(InputError, match=r"leave out --preset, --set increments$"):
        given.scene_in(scene)
    plain = options(scene="first_try", preset="draft", set=[], friction=[0.2])
    read = given.scene_in(plain)
    assert (read.about.preset, read.conditions.friction) == ("draft", 0.2)
    assert read.scene.friction_heat is True
    assert given.selected(read) == {}


# Output


def test_things_are_counted_in_words():
    assert [counted(n, "load", "loads") for n in (0, 1, 2)] == ["0 loads", "1 load", "2 loads"]
    (failed,) = failed_points([FailedPoint(1.0, 2.0, "why", (("oil", "a"),))])
    assert failed == {"load": 1.0, "velocity": 2.0, "message": "why", "place": "", "oil": "a"}
    assert _words_on("reading", 12.0, Progress(done=0, total=9)) == "reading, 12 s so far"
    assert _words_on("reading", 12.0, Progress(done=3, total=9)) == (
        "reading: 3 of 9 done, 12 s so far, 24 s to go"
    )


def printed(capsys, result, **named):
    show(argparse.Namespace(**{"json": False, "output": None} | named), result)
    return capsys.readouterr().out


def test_a_document_has_null_where_nothing_is_known_and_no_control_characters(capsys):
    held = {"a": math.nan, "b": [1.0, math.inf], "c": {"d": (True, None)}, "e": "x\x9by"}
    text = printed(capsys, Result(held, ["text"]), json=True)
    assert json.loads(text) == {
        "a": None,
        "b": [1.0, None],
        "c": {"d": [True, None]},
        "e": "x\x9by",
    }
    assert "\x9b" not in text
    assert text.startswith('{\n  "a": null')


def test_text_and_frames_are_lines_of_a_terminal(capsys):
    frame = pd.DataFrame({"load [N]": [200.0, 400.0], "outcome": ["mild", "severe"]})
    lines = printed(capsys, Result({}, ["first\x1b[31m", frame, "x" * 2001])).splitlines()
    assert lines[0] == "first\\x1b[31m"
    assert lines[1].split() == ["load", "[N]", "outcome"]
    assert lines[2].split() == ["200", "mild"]
    assert lines[-1] == "x" * 2000 + " …"
    assert printed(capsys, Result({}, ["x" * 2000])) == "x" * 2000 + "\n"
    assert printed(capsys, Result({}, [])) == ""


@pytest.mark.parametrize(("name", "entry"), [("a.csv", "table"), ("a.png", "figure")])
def test_a_table_or_a_figure_is_written_by_the_ending(capsys, tmp_path, monkeypatch, name, entry):
    saved = []
    monkeypatch.setattr("pipeline.figures.style.save_figure", lambda f, out: saved.append(f) or out)
    frame = pd.DataFrame({"load [N]": [200.0]})
    result = Result({}, ["text"], frames=[frame], draw=lambda: "drawn")
    out = tmp_path / name
    text = printed(capsys, result, output=out)
    assert text.splitlines()[-1] == (f"table: {out}" if entry == "table" else str(out))
    assert saved == ([] if entry == "table" else ["drawn"])
    document = json.loads(printed(capsys, result, output=out, json=True))
    assert document == {entry: str(out)}
    own = printed(capsys, replace(result, draw=None, out=tmp_path / "own.csv"))
    assert own.splitlines()[-1] == f"table: {tmp_path / 'own.csv'}"
    assert printed(capsys, replace(result, frames=(), draw=None), output=out) == "text\n"


def test_notes_are_for_stderr_and_quiet_users_have_none(capsys):
    output.tell("a note\nof two lines")
    assert capsys.readouterr().err == "irg: a note\nof two lines\n"
    output.QUIET.set()
    try:
        output.tell("a note")
        output.complain("an error")
    finally:
        output.QUIET.clear()
    assert capsys.readouterr().err == "irg: an error\n"


def test_an_error_needs_no_progress_line(capsys, monkeypatch):
    monkeypatch.delitem(sys.modules, "tqdm", raising=False)
    output.complain("an error")
    assert capsys.readouterr().err == "irg: an error\n"
    assert "tqdm" not in sys.modules


# What a check says


def meaning(sweep, **facts):
    return dict(_meaning(sweep, replace(facts_of(sweep), **facts)))


def test_a_check_says_the_contact_the_window_the_motion_and_the_heat():
    span = {
        "hertz_pressure": Span(1e9, 2e9), "hertz_half_width": Span(1e-5, 2e-5),
        "contact_width": Span(3e-5, 3e-5), "window": (1e-4, 2e-4), "greatest_load": 12345.0,
        "duration": Span(1.0, 4.0), "sliding_distance": Span(0.5, 6.0),
        "wear_depth": Span(1e-7, 2e-6), "peclet_number": Span(1.5, 11.25),
    }  # fmt: skip
    plain = meaning(tiny.sweep(), **span)
    assert plain["contact"] == (
        "Hertz: 1 to 2 GPa, half-width 10 to 20 µm; worn and rough: 30 µm wide at the end"
    )
    assert plain["window"] == (
        "100 × 200 µm, carries at most 12.3 kN on the pin, with all of it at the hardness"
    )
    assert plain["motion"] == "1 to 4 s and 0.5 to 6 m until the end"
    assert plain["wear"] == "0.1 to 2 µm deep at the end"
    assert plain["heat"] == "Péclet number 1.5 to 11.2: V a/(2 κ), a the half-width of Hertz"
    assert "corrections" not in plain
    assert "oil" not in plain
    smooth = tiny.sweep(roughness=None, wear=None, friction_heat=False)
    soft = meaning(smooth, **span | {"wear_depth": None, "greatest_load": math.inf})
    assert "; unworn and smooth: " in soft["contact"]
    assert soft["window"].endswith(", elastic at any load")
    assert (soft["surface"], soft["wear"]) == ("smooth", "none")
    assert soft["heat"] == "none, since there is no friction"
    rolling = tiny.sweep(motion=tribo.Motion(slide_roll_ratio=0.5, track_length=0.1))
    rolls = meaning(rolling, pin_velocity=Span(1.0, 2.0), pin_turns=Span(3.0, 3.0),
                    disk_velocity=Span(2.0, 4.0))  # fmt: skip
    assert rolls["motion"].endswith(
        "; the pin rolls at 1 to 2 m/s, 3 turns, the disk at 2 to 4 m/s"
    )
    assert ": of the disk u a/(2 κ), a" in rolls["heat"]
    bent = tribo.Corrections(film_resistance=1e-8)
    conditions = replace(tiny.sweep().conditions, corrections=bent)
    assert meaning(tiny.sweep(conditions=conditions))["corrections"] == bent.worded


def test_a_check_says_the_film_or_what_is_missing_for_it():
    oil = synthetic.OIL
    said = [*_film(tiny.sweep(oil=oil))]
    assert said[0] == (
        "oil", f"{1e3 * oil.viscosity(298.15):.3g} mPa s at the bulk temperature"
    )  # fmt: skip
    assert said[1][1].startswith("Λ ")
    assert said[1][1].endswith("lubrication")
    assert [*_film(tiny.sweep())] == []
    smooth = [*_film(tiny.sweep(oil=oil, roughness=None))]
    assert smooth[1] == ("film", "not known without a rough disk")
    bare = [*_film(tiny.sweep(oil=replace(oil, pressure_coefficients=None)))]
    assert bare[1] == ("film", "not known without pressure_viscosity_coefficient")


def test_values_of_the_library_have_a_line_for_each_table_and_source():
    sources = (
        FromLibrary("materials.steel.density", "7800 kg/m^3", "a book"),
        FromLibrary("materials.steel.specific_heat", "470 J/(kg K)", "a book"),
        FromLibrary("materials.steel.hardness", "62 HRC", "a sheet"),
    )
    assert [*_library(tiny.sweep(sources=sources))] == [
        ("library", "materials.steel: density 7800 kg/m^3, specific heat 470 J/(kg K)"),
        ("", "from a book"),
        ("library", "materials.steel: hardness 62 HRC"),
        ("", "from a sheet"),
    ]


CRITICAL = Unknown("temperature.critical", "normal", (418.15, 8.0), "K")
RATE = Unknown("wear.specific_wear_rate", "log-normal", (1.2e-15, 1.5), "m2 N-1")
FIXED = Unknown("friction.coefficient", "uniform", (0.09, 0.12))


def samples(count, per_contact=2):
    design = Design((RATE,), ("wear rate",), (0.5, 4.0), 7, per_contact)
    draw = Draw((CRITICAL, RATE), design, (Fixed(FIXED, 0.1),))
    return tiny.sweep(variants=drawn_rows(draw, count))


def in_words(sweep):
    return described(sweep.variants.draw, len(sweep.variants))


def test_a_check_says_which_inputs_are_simulated_and_whether_more_samples_help():
    said, document = in_words(samples(8))
    assert said == [
        ("unknown", f"{CRITICAL}; applied afterwards, at no cost"),
        ("unknown", str(RATE)),
        ("fixed", "friction.coefficient is fixed at 0.1"),
        ("samples",
         "8 of a scrambled Sobol' sequence, seed 7, from 0.5 to 4 m/s; more can be added"),
        ("", "2 share each contact; heat is computed for each"),
    ]  # fmt: skip
    assert [one["simulated"] for one in document["unknown"]] == [False, True]
    assert document["fixed"] == {"friction.coefficient": 0.1}
    assert (document["samples"], document["samples_per_contact"]) == (8, 2)
    assert document["sample_seed"] == 7
    enough, _ = in_words(samples(64))
    assert enough[3][1].endswith("; more would share their contacts")
    assert len(in_words(samples(8, per_contact=1))[0]) == 4


@pytest.mark.parametrize(
    ("changes", "words"),
    [
        ({}, "12: 3 loads, 3 velocities"),
        ({"loads": (250.0,), "velocities": (1.0,)}, "12: 1 load, 1 velocity"),
        ({"variants": surfaces((1, 2))}, "12: 3 loads, 3 velocities, 2 surfaces"),
        ({"variants": rows("pin.radius", {6e-3: {}, 7e-3: {}})},
         "12: 3 loads, 3 velocities, 2 values of pin.radius"),
        ({"variants": rows("test", {0: {}, 1: {}}, velocities=[0.5, 1.5])},
         "12: 3 loads, 2 velocities, 2 values of test"),
        ({"variants": placed_rows((250.0, 0.5), (600.0, 1.5))},
         "12: 2 rows, each at its own load and velocity"),
    ],
)  # fmt: skip
def test_a_check_says_what_the_points_are(changes, words):
    cost = Estimate(12, 34, 56, 7, 1, 90.0, 1e8, 0.9e6)
    said = dict(_cost(tiny.sweep(**changes), cost, searched=False))
    assert said == {
        "points": words,
        "steps": "34 contacts and 56 temperatures to solve",
        "tasks": "7, which do not wait for each other: more workers would be idle",
        "time": "roughly 2 min on 1 worker, if the machine is idle",
        "disk": "less than 1 MB",
    }
    larger = replace(cost, disk_bytes=2.4e6, workers=3)
    searched = dict(_cost(tiny.sweep(**changes), larger, searched=True))
    assert searched["points"].startswith("about 12: the boundary is sought between ")
    assert "tasks" not in searched
    assert searched["time"].endswith("on 3 workers, if the machine is idle")
    assert searched["disk"] == "about 2 MB"
    assert _cost_of_samples() == "12: 3 loads, 8 velocities, 8 samples"


def _cost_of_samples():
    cost = Estimate(12, 34, 56, 7, 1, 90.0, 1e8, 1e6)
    said = dict(_cost(samples(8), cost, searched=False))
    assert said["disk"] == "about 1 MB"
    return said["points"]


# Studies, stores and beginnings


def test_the_table_of_variations_has_a_row_for_each_value_and_load():
    crosses, nan = ("crosses", "crosses"), math.nan
    base = Variation("", "", (2.0, 1.0), crosses)
    others = (
        Variation("pin.radius", "3 mm", (2.2, nan), ("crosses", "mild throughout")),
        Variation("friction.coefficient", "0.2", (1.0, 0.5), crosses),
    )
    made = Variations("A scene", (200.0, 600.0), base, others, 12, 5)
    frame = _critical_velocities(made)
    assert frame["entry"].tolist() == [
        "unchanged", "unchanged", "friction.coefficient", "friction.coefficient", "pin.radius",
        "pin.radius",
    ]  # fmt: skip
    np.testing.assert_allclose(frame["change [%]"], [nan, nan, -50.0, -50.0, 10.0, nan])
    assert frame["load [N]"].tolist() == [200.0, 600.0] * 3
    assert frame["outcome"].tolist()[-1] == "mild throughout"


def test_folders_are_searched_but_for_links_and_what_is_hidden(tmp_path):
    for folder in ("a", "b/c", ".hidden/d"):
        (tmp_path / folder).mkdir(parents=True)
        (tmp_path / folder / "zarr.json").write_text("{}")
    (tmp_path / "a" / "array").mkdir()
    (tmp_path / "a" / "array" / "zarr.json").write_text("{}")
    (tmp_path / "link").symlink_to(tmp_path / "b")
    found = [str(path.relative_to(tmp_path)) for path in _stores_below(tmp_path)]
    assert found == ["a", "b/c"]


def test_a_new_scene_is_named_with_the_commands_that_follow(tmp_path, monkeypatch):
    copies = [tmp_path / "s.toml", tmp_path / "scan.csv"]
    monkeypatch.setattr(pipeline, "new_scene", lambda *_: copies)
    made = new(SimpleNamespace(list=False, file=copies[0], like="first_try", full=False))
    assert [*made.text] == [
        f"{copies[0]} is written, {copies[1]} copied",
        f"its meaning and cost: irg check {copies[0]}",
        f"its points: irg run {copies[0]}",
    ]
    assert made.document == {"file": str(copies[0]), "copies": [str(copies[1])]}
    with pytest.raises(InputError, match="no file is named; give one to write, such as: irg new"):
        new(SimpleNamespace(list=False, file=None))


@pytest.mark.parametrize(
    ("counts", "words"),
    [
        ((0, 9, 0, None), "done"),
        ((2, 7, 0, None), "7 of 9 done"),
        ((2, 6, 1, None), "6 of 9 done, 1 failed"),
        ((0, 8, 1, "process 1"), "done, 1 failed, running now"),
    ],
)
def test_the_state_of_a_store_counts_what_is_done_and_failed(monkeypatch, counts, words):
    pending, done, failed, running = counts
    state = SimpleNamespace(
        pending=pending, done=done, total=9, failed=failed * ("point",), running=running, title="T"
    )
    monkeypatch.setattr(stores, "summary", lambda path: state)
    monkeypatch.setattr(
        stores, "read_sweep", lambda path: SimpleNamespace(about=SimpleNamespace(preset="fine"))
    )
    assert stores._store_status(Path("a.zarr")) == {
        "state": words, "preset": "fine", "title": "T"
    }  # fmt: skip
