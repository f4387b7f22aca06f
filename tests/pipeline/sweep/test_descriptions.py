"""Sweeps, points and answers as users read them, line by line."""

import math
from dataclasses import dataclass, field, replace
from types import SimpleNamespace

import numpy as np
import pandas as pd
import pytest

import tribo
from pipeline.sweep import stages
from pipeline.sweep.about import Measurement, judged_by, oils_of, own_tests
from pipeline.sweep.remarks import Remark
from pipeline.sweep.selection import Choice, Selection
from pipeline.sweep.shown import shown
from pipeline.sweep.stages import Progress, duration
from pipeline.sweep.surface import SurfaceFacts, surface_facts, surface_words
from pipeline.uncertain.unknown import Unknown, without
from tests.helpers import synthetic, tiny
from tribo import PRESETS

BENT = tribo.Corrections(friction=tribo.Friction(by_velocity=((1.0, 1.2), (4.0, 0.8))))
RECORD = tribo.MeasuredLoad(np.array([0.0, 1.0, 3.0]), np.array([0.0, 80.0, 750.0]))


def test_conditions_of_several_are_said_once_each_and_what_is_drawn_as_that():
    own = tiny.sweep().conditions
    warm = replace(own, critical_temperature=438.15)
    bent = replace(warm, corrections=BENT)
    assert judged_by([own]) == (
        "severe wear: more than 10 % of the contact above 145 °C; friction 0.1, bulk 25 °C"
    )
    assert judged_by([own, warm, warm]) == (
        "severe wear: more than 10 % of the contact above 145 °C or more than 10 % of the contact "
        "above 165 °C; friction 0.1, bulk 25 °C"
    )
    assert judged_by([bent]).endswith(f"above 165 °C; friction 0.1, bulk 25 °C; {BENT.worded}")
    assert judged_by([own, bent]).endswith(f"no correction or {BENT.worded}")
    every = ("friction.coefficient", "temperature.bulk", "temperature.critical")
    assert judged_by([own], every) == (
        "severe wear: more than 10 % of the contact above the critical temperature of each sample; "
        "friction of each sample, bulk of each sample"
    )
    assert judged_by([own], ("temperature.failing_share",)).startswith(
        "severe wear: more than the share of each sample of its contact above 145 °C;"
    )
    assert "bulk of each sample" in judged_by([own], ("temperature.bulk.pin",))


def test_tests_are_of_the_scene_s_oil_if_they_name_none_or_the_first_by_name():
    plain, mineral, ester = (
        Measurement(400.0, velocity, oil=oil)
        for velocity, oil in ((1.0, None), (2.0, "mineral"), (3.0, "ester"))
    )
    assert oils_of(test.oil for test in (mineral, plain, ester)) == ["", "ester", "mineral"]
    assert own_tests((mineral, plain, ester)) == (plain,)
    assert own_tests((mineral, ester)) == own_tests((ester, mineral)) == (ester,)
    assert own_tests(()) == ()
    assert Measurement.of({"load": 400.0, "velocity": 1.0, "number": 7, "run": None}) == (
        Measurement(400.0, 1.0, number="7")
    )
    assert plain.as_dict() == {"normal_load": 400.0, "velocity": 1.0, "friction": None}


@shown
@dataclass
class Values:
    title: str = "two oils"
    velocity: float = 1.23456
    unknown: float = math.nan
    nothing: None = None
    hidden: int = field(default=7, repr=False)
    few: tuple = (1.0, 2.0, 3.0, 4.0, 5.0, 6.0)
    many: tuple = tuple(range(8))
    table: pd.DataFrame = field(default_factory=lambda: pd.DataFrame({"a <b": [1.0]}))
    by_name: dict = field(default_factory=lambda: {"draft": 0.08, "fine": 0.01})
    array: np.ndarray = field(default_factory=lambda: np.array([[1.0, np.nan, -2.0, 3.0]] * 2))
    short: np.ndarray = field(default_factory=lambda: np.array([1.0, 2.5]))
    lines: str = "first\nsecond"
    long: str = "word " * 30


def test_an_answer_shows_each_of_its_values_in_a_line():
    answer = Values()
    assert repr(answer).splitlines() == [
        "Values: two oils",
        "  velocity  1.235",
        "  unknown   not known",
        "  few       1, 2, 3, 4, 5, 6",
        "  many      0, 1, 2, 3, 4, 5 and 2 more",
        "  table     1 row",
        "  by_name   draft: 0.08, fine: 0.01",
        "  array     array of shape (2, 4), -2 to 3",
        "  short     1, 2.5",
        "  lines     first",
        f"  long      {'word ' * 15}…"[:88],
    ]
    html = answer._repr_html_()
    assert "<caption>Values: two oils</caption>" in html
    assert "<tr><th>few</th><td>1, 2, 3, 4, 5, 6</td></tr>" in html
    assert html.count("a &lt;b") == 2  # as one of its values, and as its table
    assert "hidden" not in html
    assert "<th>0</th>" not in html  # no numbers of rows


@pytest.mark.parametrize(
    ("seconds", "words"),
    [
        (59.4, "59 s"),
        (60.0, "1 min"),
        (119.4 * 60, "119 min"),
        (120 * 60, "2.0 h"),
        (99.9 * 365.25 * 24 * 3600, "875723.4 h"),
        (100 * 365.25 * 24 * 3600, "more than 100 years"),
    ],
)
def test_durations_change_their_unit_at_a_minute_two_hours_and_a_century(seconds, words):
    assert duration(seconds) == words


def test_stages_say_which_begins_and_the_time_that_the_rest_will_take(monkeypatch):
    """By the weight of what is done: 4 s for 1 of 10 are 36 s for 9; none in the first 2 s."""

    def go(items, times, *names, **weights):
        said = []
        monkeypatch.setattr(stages, "time", SimpleNamespace(monotonic=iter(times).__next__))
        assert list(stages.staged(items, said.append, *names, **weights)) == list(items)
        return said

    weights = {"a": 0.5, "b": 0.5, "c": 9.0}
    assert go("abc", (0.0, 0.0, 1.9, 4.0), weight=weights.get) == [
        Progress("1 of 3: a", 0, 3, elapsed=0.0),
        Progress("2 of 3: b", 1, 3, elapsed=1.9),
        Progress("3 of 3: c (about 36 s to go)", 2, 3, elapsed=4.0, time_to_go=36.0),
    ]
    assert go("ab", (10.0, 10.0, 12.0), str.upper) == [
        Progress("1 of 2: A", 0, 2, elapsed=0.0),
        Progress("2 of 2: B (about 2 s to go)", 1, 2, elapsed=2.0, time_to_go=2.0),
    ]
    assert go("a", (0.0, 3.5)) == [Progress("a", 0, 1, elapsed=3.5)]
    monkeypatch.undo()
    assert list(stages.staged("ab", stages.silent)) == ["a", "b"]


@pytest.mark.parametrize(
    ("progress", "words"),
    [
        (Progress("the probe", 1, 2, failed=1, elapsed=3.0), "the probe"),
        (Progress(done=1, total=8), "1 of 8 done"),
        (Progress(done=1, total=8, failed=0), "1 of 8 points done, 0 failed"),
        (Progress(done=1, total=8, elapsed=0.0), "1 of 8 done, 0 s so far"),
        (Progress(done=1, total=8, elapsed=3.0, time_to_go=90.0),
         "1 of 8 done, 3 s so far, 2 min to go"),
    ],
)  # fmt: skip
def test_progress_says_what_is_known_of_it(progress, words):
    assert str(progress) == words


def test_a_long_list_is_cut_within_its_line_and_says_how_many_more():
    answer = Values(many=("a word or two of text",) * 20)
    (line,) = [line for line in repr(answer).splitlines() if line.startswith("  many")]
    assert line.endswith(" … and 14 more")
    assert 60 < len(line.removeprefix("  many      ")) <= 76


@pytest.mark.parametrize(
    ("facts", "words"),
    [
        (SurfaceFacts(False, 0.27e-6, 0.338e-6), "random: Ra 0.27 µm, Rq 0.338 µm, no lay"),
        (
            SurfaceFacts(False, 0.27e-6, 0.338e-6, lay=89.7, slope=0.123),
            "random: Ra 0.27 µm, Rq 0.338 µm, rms slope 0.12, grooves at 90° to sliding",
        ),
        (
            SurfaceFacts(True, 1e-7, 2e-7, 1e-13, (1e-13, -1.9e-13)),
            "measured: Ra 0.1 µm, Rq 0.2 µm, no lay; level",
        ),
        (
            SurfaceFacts(True, 1e-7, 2e-7, 0.0, (0.0, -3e-6), lay=0.0),
            "measured: Ra 0.1 µm, Rq 0.2 µm, grooves at 0° to sliding; mean plane at 0 µm, rising "
            "by 0 µm along x and -3 µm along y over the window",
        ),
        (
            SurfaceFacts(True, 1e-7, 2e-7, 5e-6),
            "measured: Ra 0.1 µm, Rq 0.2 µm, no lay; mean plane at 5 µm, rising by 0 µm along x "
            "and 0 µm along y over the window",
        ),
    ],
)
def test_a_surface_is_said_by_its_heights_its_lay_and_its_level(facts, words):
    assert facts.words == words


def test_facts_of_a_surface_have_their_units():
    facts = SurfaceFacts(True, 1e-7, 2e-7, 5e-6, (1e-6, 2e-6), (0.06, math.inf), lay=45.0)
    assert facts.as_dict() == {
        "kind": "measured",
        "ra": {"value": 1e-7, "unit": "m"},
        "rq": {"value": 2e-7, "unit": "m"},
        "mean_height": {"value": 5e-6, "unit": "m"},
        "rise": {"x": 1e-6, "y": 2e-6, "unit": "m"},
        "radii": {"x": 0.06, "y": math.inf, "unit": "m"},
        "lay": {"value": 45.0, "unit": "degree"},
    }
    assert SurfaceFacts(False, 1e-7, 2e-7).as_dict()["lay"] == "none"
    assert SurfaceFacts(False, 1e-7, 2e-7).as_dict()["kind"] == "random"


def test_slopes_are_taken_along_sliding_and_notes_on_a_scan_are_added():
    """A plane wave of one period along x: rms slope 2π a / (L √2)."""
    place = np.arange(64)[:, None] - 31.5  # even about the middle, so that it does not lean
    wave = 1e-7 * np.cos(2 * np.pi * place / 64) * np.ones((1, 32))
    waved = tribo.MeasuredRoughness(wave)
    pixels = tribo.Grid((64, 32), (13e-6, 15e-6))
    notes = Remark("disk.roughness", "note", "cut"), Remark("wear", "note", "no")
    sweep = tiny.sweep(roughness=waved, pixels=pixels, notes=notes)
    slope = surface_facts(sweep).slope
    assert slope == pytest.approx(2 * np.pi * 1e-7 / (64 * 13e-6) / 2**0.5, rel=0.01)
    assert surface_words(sweep) == f"{surface_facts(sweep).words}; disk.roughness: cut"
    assert surface_words(tiny.sweep(roughness=None)) is None
    single = tribo.MeasuredRoughness(wave[:1])
    alone = tiny.sweep(roughness=single, pixels=replace(pixels, shape=(1, 32)))
    assert surface_facts(alone).slope is None
    assert surface_facts(alone).lay is None


@pytest.mark.parametrize(
    ("lengths", "lay"),
    [((8e-6, 4e-6), 0.0), ((4e-6, 8e-6), 90.0), ((7.9e-6, 4e-6), None), ((4e-6, 7.9e-6), None)],
)
def test_a_large_random_surface_has_the_lay_of_lengths_that_differ_by_two(lengths, lay):
    rough = tribo.SelfAffineRoughness(0.27e-6, 0.8, lengths, seed=0)
    facts = surface_facts(
        tiny.sweep(roughness=rough, pixels=tribo.Grid((1001, 1000), (1e-6, 1e-6)))
    )
    assert (facts.lay, facts.slope, facts.ra) == (lay, None, 0.27e-6)
    assert facts.rq == pytest.approx(0.27e-6 * math.sqrt(math.pi / 2))
    assert (facts.mean_height, facts.rise) == (0.0, (0.0, 0.0))


def test_a_choice_says_what_was_asked_for_and_what_it_errs():
    choices = tuple(
        Choice(name, PRESETS[name], (error / 2,), error / 2, error, 1.5)
        for name, error in (("draft", 0.09), ("fine", 0.0123))
    )
    picked = synthetic.selection(
        error=0.0123, choices=choices, seconds=12.34, points=((600.0, 1.5),)
    )
    assert str(picked) == (
        "accuracy 2 %: picked fine; boundary velocities err by at most 1.2 % at any load"
    )
    own = replace(picked, accuracy=None, name="the scene's own fidelity")
    assert str(own) == (
        "the scene's own fidelity; boundary velocities err by at most 1.2 % at any load"
    )
    assert "more than asked for" not in str(replace(picked, error=0.02))
    assert "at any load, more than asked for" in str(replace(picked, error=0.021))
    assert isinstance(picked, Selection)


def test_inputs_say_their_distribution():
    first = Unknown("a", "normal", (418.15, 8.0), "K", "°C")
    second = Unknown("b", "uniform", (1.0, 2.0), correlated=(("a", 0.5), ("c", 0.1)))
    assert str(first) == "a: normal, mean 145 °C, sd 8 K"
    assert (
        str(second) == "b: uniform from 1 to 2, correlated by 0.5 with a, correlated by 0.1 with c"
    )
    assert str(replace(second, varies=True)).endswith("with c, from part to part")
    assert str(Unknown("d", "list", (3.0, 5.0), varies=True)) == "d: one of 3, 5"
    assert [one.correlated for one in without((first, second), {"a"})] == [(("c", 0.1),)]
    assert first.as_dict()["written"] == "°C"
    assert second.as_dict() == {
        "path": "b", "kind": "uniform", "parameters": (1.0, 2.0), "unit": "1",
        "correlated": (("a", 0.5), ("c", 0.1)),
    }  # fmt: skip
    assert not first.is_relative
    assert Unknown("r", "log-normal", (1.0, 1.5)).is_relative
