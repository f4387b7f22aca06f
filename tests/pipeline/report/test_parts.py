"""Sections of a report, by the words, tables and numbers in them."""

import math
import re
from types import SimpleNamespace

import numpy as np
import pandas as pd
import pytest
import xarray as xr
from matplotlib.figure import Figure

import pipeline
import tribo
from pipeline.analysis.dataset import stored_sweep
from pipeline.report.report import (
    _answer,
    _drawn,
    _each,
    _fidelity,
    _html,
    _inputs,
    _meaning,
    _operating_points,
    _or_reason,
    _question,
    _question_of_samples,
    _versions,
    _warnings,
)
from pipeline.scene.along import OperatingPoints
from pipeline.sweep.about import FromLibrary
from pipeline.sweep.laws import LawError
from pipeline.sweep.variants import Column, Variants
from tests.helpers import synthetic
from tribo import InputError

PLANE = [200.0, 400.0, 750.0], [0.5, 1.0, 2.0, 4.0]


def critical(load):
    return synthetic.critical_velocity(load, synthetic.limit())


def over_surfaces(*factors, **changes):
    parts = [
        synthetic.sweep(*PLANE, rise=lambda *at, k=k: k * synthetic.rise(*at), **changes)
        for k in factors
    ]
    labels = xr.Variable("realization", range(len(factors)))
    return xr.concat(parts, labels, combine_attrs="override")


def answer(ds):
    return _answer(pipeline.boundary(ds))


def test_the_answer_is_the_velocity_at_the_lowest_and_at_the_highest_load():
    low, high = critical(200.0), critical(750.0)
    assert answer(synthetic.sweep(*PLANE)) == (
        f"wear is severe from {low:.3g} m/s on at 200 N; severe from {high:.3g} m/s on at 750 N"
    )
    alone = synthetic.sweep([400.0], PLANE[1])
    assert answer(alone) == f"wear is severe from {critical(400.0):.3g} m/s on at 400 N"
    never, always = (
        answer(synthetic.sweep(*PLANE, conditions=synthetic.CONDITIONS | {"friction": friction}))
        for friction in (1e-3, 5.0)
    )
    loads = [f"{load:g}" for load in PLANE[0]]
    assert never == f"wear is mild throughout at {', '.join(loads)} N"
    assert always == f"wear is severe throughout at {', '.join(loads)} N"
    hot = synthetic.sweep(PLANE[0], [1.3, 2.0, 4.0])
    assert answer(hot) == (
        f"wear is severe from {low:.3g} m/s on at 200 N; severe from "
        f"{critical(400.0):.3g} m/s on at 400 N; severe throughout at 750 N"
    )


def test_the_answer_over_surfaces_is_that_of_half_of_them():
    three = over_surfaces(1.0, 1.1, 0.95)
    low, high = critical(200.0), critical(750.0)
    assert answer(three) == (
        f"wear is severe from {low:.3g} m/s on at 200 N; severe from {high:.3g} m/s on at 750 N, "
        "on half of 3 surfaces"
    )
    # At half the rise the two lower loads have no transition, so that one of two is no majority.
    cold = synthetic.critical_velocity(750.0, 2 * synthetic.limit())
    assert answer(over_surfaces(1.0, 0.5)) == (
        f"wear is severe from {(high + cold) / 2:.3g} m/s on at 750 N, on half of 2 surfaces; "
        "severe from some velocity on or mild throughout at 200, 400 N"
    )
    # Of three, the second to turn is half of them.
    assert answer(over_surfaces(1.0, 0.5, 1.0)).startswith(f"wear is severe from {low:.3g} m/s on")
    assert answer(over_surfaces(1.0, 1e-3, 1e-3)) == (
        "wear is severe from some velocity on or mild throughout at 200, 400, 750 N"
    )


def test_the_question_says_what_was_examined_and_how_much_of_it_is_there():
    whole = [*_question(synthetic.sweep(*PLANE))]
    assert whole[0].endswith(
        "? Examined: 3 loads from 200 to 750 N, 4 velocities from 0.5 to 4 m/s"
    )
    assert whole[1] == (
        "severe wear: more than 10 % of the contact above 145 °C; friction 0.1, bulk 25 °C"
    )
    assert whole[2].startswith("Answer: wear is severe from ")
    assert len(whole) == 3
    part = [*_question(synthetic.sweep(*PLANE, status={(200.0, 1.0): 2, (400.0, 2.0): 0}))]
    assert part[1] == (
        "The sweep is not finished: 10 of 12 points are done, 1 failed. What follows rests on "
        "those that are done."
    )


def test_an_entry_with_several_values_has_them_in_turn_or_their_ends():
    def each(*values):
        held = xr.DataArray(np.array(values), dims="pin.radius", attrs={"units": "m"})
        return _each(held.rename("pin.radius"))

    assert each(2e-3, 3e-3).startswith("in turn ")
    assert each(2e-3, 3e-3).count(",") == 1
    assert "in turn" not in each(2e-3)
    twelve = [k * 1e-3 for k in range(1, 13)]
    assert each(*twelve).startswith("in turn ")
    many = each(*twelve, 0.5e-3)
    first, last = (text.split()[0] for text in (each(0.5e-3), each(12e-3)))
    assert re.fullmatch(rf"13 values, from {re.escape(first)}.* to {re.escape(last)}.*", many)


def sections(ds):
    return [*_inputs(ds, stored_sweep(ds))]


def test_inputs_are_entries_with_their_meanings_and_their_sources():
    sources = (FromLibrary("disk.density", "7800 kg/m^3", "a handbook"),)
    surface, table, library, source = sections(synthetic.sweep(*PLANE, sources=sources))
    assert re.match(r"Surface of the disk: random: Ra 0\.2[67]\d? µm, Rq 0\.3\d* µm, ", surface)
    rows = table.set_index("entry")
    assert rows.loc["pin.radius", "value"] == "2 mm"
    assert rows.loc["pin.radius", "meaning"] == _meaning("pin.radius") != ""
    assert rows.loc["friction.coefficient", "value"] == "0.1"
    assert not [path for path in rows.index if path.startswith(("fidelity", "measured"))]
    assert library.to_numpy().tolist() == [["disk.density", "7800 kg/m^3", "a handbook"]]
    assert source == "Source: other values from the scene synthetic.toml."
    smooth = sections(synthetic.sweep(*PLANE, roughness=None))
    assert isinstance(smooth[0], pd.DataFrame)
    assert smooth[-1] == "Source: all values from the scene synthetic.toml."
    assert len(smooth) == 2


def test_inputs_that_differ_between_scenes_have_all_their_values():
    radii = (1e-3, 2e-3)
    column = Column("pin.radius", radii, "m")
    table = Variants((column,), ({"pin.radius": "1 mm"}, {"pin.radius": "2 mm"}))
    labels = xr.DataArray([*radii], dims="pin.radius", name="pin.radius", attrs={"units": "m"})
    parts = [synthetic.sweep(*PLANE, variants=table) for _ in radii]
    ds = xr.concat(parts, labels, combine_attrs="override")
    (entries,) = (part for part in sections(ds) if isinstance(part, pd.DataFrame))
    values = dict(zip(entries["entry"], entries["value"], strict=True))
    assert values["pin.radius"] == "in turn 1 mm, 2 mm"
    assert values.keys().isdisjoint({"load", "velocity", "step", "time"})


def test_meanings_are_the_first_sentence_of_the_reference():
    assert _meaning("pin.material.density") == _meaning("disk.material.density") != ""
    assert _meaning("no.entry") == ""
    assert not {"`", ";"} & {*_meaning("wear.pattern")}


def test_numerical_choices_have_no_name_of_a_preset():
    sweep = stored_sweep(synthetic.sweep(*PLANE, preset="draft", fidelity=tribo.PRESETS["draft"]))
    (table,) = _fidelity(sweep)
    rows = dict(table.to_numpy().tolist())
    assert "preset" not in rows
    assert rows["increments"] == "4"
    assert rows["pixels_per_element"] == "2"


def test_warnings_and_versions_are_told_line_by_line():
    ds = synthetic.sweep(*PLANE)
    assert [*_warnings(ds)] == ["No computed point carries a warning"]
    dated = ds.assign_attrs(history="computed by a\ngone on with b")
    first, second, scene, written = _versions(dated, stored_sweep(ds))
    assert (first, second) == ("computed by a", "gone on with b")
    assert re.fullmatch(r"Scene [0-9a-f]{64} \(SHA-256 of its inputs\)\.", scene)
    assert re.fullmatch(r"This report was written at \d{4}-\d\d-\d\d \d\d:\d\d UTC\.", written)


@pytest.mark.parametrize(
    ("part", "markup"),
    [
        ("a sentence", "<p>A sentence.</p>"),
        ("a < b.", "<p>A &lt; b.</p>"),
        ("Rq", "<p>Rq.</p>"),
    ],
)
def test_sentences_begin_with_a_capital_and_end_with_one_point(part, markup):
    assert _html(part, "Inputs") == markup


def test_the_diagram_of_a_report_has_the_width_of_its_page_and_no_title_of_its_own(monkeypatch):
    drawn = Figure()
    drawn.add_subplot(title="A scene")
    monkeypatch.setitem(_drawn.__globals__, "diagram", lambda ds: drawn)
    (figure,) = _drawn(synthetic.sweep(*PLANE))
    assert figure.get_size_inches()[0] == pytest.approx(17 / 2.54)  # of A4 between its margins
    assert [axes.get_title() for axes in figure.axes] == [""]


def test_pictures_are_described_by_their_heading():
    figure = Figure(figsize=(1.0, 1.0))
    figure.add_subplot()
    drawn = _html(figure, "Transition diagram")
    assert drawn.startswith('<figure role="img" aria-label="Transition diagram"><svg')
    assert drawn.endswith("</figure>")


def test_why_a_section_has_no_more_is_its_last_part():
    def section(error):
        yield "first"
        raise error

    assert _or_reason(section(InputError("why"))) == ["first", "Not in this report: why"]
    assert _or_reason(["one", "two"]) == ["one", "two"]
    with pytest.raises(LawError):
        _or_reason(section(LawError("code")))


def test_a_report_has_no_sections_that_nothing_was_asked_for(tmp_path):
    page = pipeline.report(synthetic.sweep(*PLANE, measured=()), tmp_path / "report.html")
    text = page.read_text(encoding="utf-8")
    headings = re.findall("<h2>(.*)</h2>", text)
    assert "Tests" not in headings
    assert "Operating points" not in headings
    assert headings[0] == "Question and answer"
    assert "<h1>White oil on ground steel</h1>" in text


def samples_field(misfit=""):
    ensemble = SimpleNamespace(inputs=range(64))
    return SimpleNamespace(ensemble=ensemble, ends={"velocity": (0.5, 4.0)}, misfit=misfit)


def samples_boundary(quantiles, loads=(200.0, 400.0, 750.0)):
    columns = {"critical_velocity_quantile": (("load", "share"), quantiles)}
    return xr.Dataset(columns, {"load": list(loads)})


def test_samples_are_answered_at_the_lowest_and_the_highest_load_with_their_interval():
    quantiles = [[1.25, 2.0, 3.0], [0.6, 0.9, 1.3], [0.0, math.inf, math.inf]]
    lines = samples_boundary(quantiles)
    question, said = _question_of_samples(samples_field(), lines, ", before any test")
    assert question.endswith(
        ", with inputs that are not known exactly? 64 samples of them were simulated"
    )
    assert said == (
        "Answer, before any test: the next run is, likelier than not, severe from 2 m/s on at "
        "200 N (turns severe at 1.25 m/s to 3 m/s with 90 % probability); mild throughout at 750 N "
        "(turns severe at below 0.5 m/s to beyond 4 m/s with 90 % probability)"
    )
    _, once = _question_of_samples(samples_field(), lines.isel(load=[1]), "")
    assert once == (
        "Answer: the next run is, likelier than not, severe from 0.9 m/s on at 400 N "
        "(turns severe at 0.6 m/s to 1.3 m/s with 90 % probability)"
    )


def test_a_misfit_of_samples_is_said_before_the_answer():
    lines = samples_boundary([[0.6, 0.8, 3.7], [0.0] * 3], (200.0, 750.0))
    _, contradicted, said = _question_of_samples(samples_field("it does not fit"), lines, "")
    assert contradicted == "it does not fit"
    assert said == (
        "Answer: the next run is, likelier than not, severe from 0.8 m/s on at 200 N (turns severe "
        "at 0.6 m/s to 3.7 m/s with 90 % probability); severe throughout at 750 N"
    )


def test_operating_points_have_their_table_remarks_and_the_meaning_of_factors():
    given = {"load": ["400 N", "9 kN"], "velocity": ["1.4 m/s", "1 m/s"], "shift": ["a", "b"]}
    points = OperatingPoints.read(given)
    table, *notes, factors = _operating_points(synthetic.sweep(*PLANE), points)
    assert table["verdict"].tolist() == ["mild", "not known"]
    assert "critical velocity [m/s]" not in table
    assert any("9000 N" in note or "9 kN" in note for note in notes)
    assert factors.startswith("A factor is the critical velocity or load over that of the point: ")
