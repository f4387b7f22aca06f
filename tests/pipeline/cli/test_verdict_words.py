"""Lines of the command on margins, at numbers that are given."""

import argparse

import pytest

import pipeline
from pipeline.analysis.margin_frame import judged
from pipeline.analysis.rise_error import RiseError
from pipeline.cli.verdicts import (
    _deciding_lines,
    _error_lines,
    _margin_lines,
    _place_lines,
    _table_lines,
)
from pipeline.scene.along import OperatingPoints, Place
from tests.helpers import synthetic


@pytest.fixture(scope="module")
def found():
    points = OperatingPoints((Place(400.0, 1.4), Place(600.0, 2.4), Place(9000.0, 1.0)), {})
    return [*judged(synthetic.sweep(), points)]


@pytest.fixture(scope="module")
def here(found):
    return found[0].known()


def changed(margin, **values):
    """A margin with some other values."""
    fields = type(margin).__dataclass_fields__
    return type(margin)(**{name: getattr(margin, name) for name in fields} | values)


@pytest.mark.parametrize(
    ("changes", "origin"),
    [
        ({}, "interpolated between computed points"),
        ({"is_computed": True, "is_continued": True}, "computed there"),
        (
            {"is_continued": True, "members": 3},
            "extrapolated beyond the computed points, as a power of the velocity",
        ),
        ({"members": 2}, "that of 2 surfaces"),
        ({"members": 3, "counts_inputs": True}, "that of 3 samples"),
    ],
)
def test_the_temperature_that_decides_has_its_origin_and_its_error(here, changes, origin):
    error = RiseError(1.5, 2.0, 0.0)
    sentence, numerical, model, *_ = _margin_lines(changed(here, error=error, **changes))
    assert sentence.startswith("Mild: ")
    assert numerical == (
        "  numerical error  ± 2.5 K: interpolation 1.5 K, preset 2 K; the decisive temperature is "
        f"{origin}"
    )
    assert model == f"  the model's own  {here.model_error}"


def test_inputs_have_their_interval_of_draws_or_of_surfaces(here):
    interval = {"decisive_temperature": (373.15, 393.15)}
    draws = changed(here, members=64, counts_inputs=True, intervals=interval)
    assert _margin_lines(draws)[2] == "  inputs           100 to 120 °C with 90 %"
    several = changed(here, members=5, intervals=interval)
    assert _margin_lines(several)[2] == "  surfaces         100 to 120 °C with 90 %"


def test_lines_along_velocity_and_load_tell_what_is_known_beyond_the_outcome(here):
    assert "warning" not in " ".join(_margin_lines(here))
    misfit = changed(here, misfit="the tests contradict the model")
    assert "warning: the tests contradict the model" in _margin_lines(misfit)
    mild = changed(
        here,
        velocity_outcome="mild at every velocity computed (to 4 m/s)",
        load_outcome="severe at every load computed (from 200 N)",
    )
    assert _margin_lines(mild)[3:] == [
        "in velocity: mild at every velocity computed (to 4 m/s)",
        "in load: severe at every load computed (from 200 N)",
    ]
    assert _margin_lines(changed(mild, velocity_outcome="mild throughout"))[3:] == [
        "in load: severe at every load computed (from 200 N)"
    ]
    twice = changed(here, velocity_outcome="severe from 1 to 2 m/s")
    assert "in velocity: severe from 1 to 2 m/s" in _margin_lines(twice)


def test_a_place_that_is_not_known_has_its_reason(found):
    ds = synthetic.sweep()
    document, text = _place_lines(ds, found[:1])
    assert document["verdict"] == "mild"
    assert text == _margin_lines(found[0].known())
    document, text = _place_lines(ds, found[2:])
    assert [*document] == ["note"]
    assert text == [document["note"]] == [found[2].reason]
    documents, text = _place_lines(ds, found)
    assert [one.get("verdict") for one in documents["scenes"]] == ["mild", "severe", None]


def test_a_table_has_its_verdicts_counted_and_what_they_rest_on(found):
    ds = synthetic.sweep()
    points = OperatingPoints.read(
        {"load": ["400 N", "600 N", "9 kN"], "velocity": ["1.4 m/s", "2.4 m/s", "1 m/s"]}
    )
    frame = pipeline.margin(ds, points)
    document, (said, *rest) = _table_lines(argparse.Namespace(output=None), frame, points)
    assert document["verdicts"] == {"mild": 1, "severe": 1, "not known": 1}
    assert len(document["margins"]["verdict"]) == 3
    assert "columns_not_used" not in document
    assert said.startswith("3 operating points: 1 mild, 1 not known, 1 severe; the least margin is")
    assert rest[0] == ""
    assert rest[1]["verdict"].tolist() == ["mild", "severe", "not known"]
    _, written = _table_lines(argparse.Namespace(output="a.csv"), frame, None)
    assert all(isinstance(line, str) and line for line in written)
    unused = OperatingPoints(points.places, {}, (), ("remark",))
    document, lines = _table_lines(argparse.Namespace(output="a.csv"), frame, unused)
    assert document["columns_not_used"] == ["remark"]
    assert lines[-1] == "columns not used: remark"


def test_errors_of_a_table_are_told_once(found):
    known = found[:2]
    assert _error_lines(known) == [f"the model's own error: {known[0].margin.model_error}"]
    assert _error_lines([]) == []
    misfit = [one._replace(margin=changed(one.margin, misfit="contradicted")) for one in known]
    assert _error_lines(misfit)[1:] == ["warning: contradicted"]
    other = known[1]._replace(margin=changed(known[1].margin, model_error="another"))
    assert _error_lines([known[0], other])[0].endswith(" or another")


def test_what_would_decide_verdicts_is_told_by_its_kind_and_counted(found):
    numerical = changed(found[0].margin, lowest=0.01, probability=0.02, highest=0.5)
    by_model = changed(numerical, lowest=0.3, probability=0.4)
    between = changed(numerical, error=RiseError(3.0, 2.0, 0.0))
    at_point = changed(numerical, error=RiseError(0.0, 2.0, 0.0))

    def lines(*margins):
        return _deciding_lines([found[0]._replace(margin=one) for one in margins])

    assert lines(found[0].margin) == []
    assert lines(found[0].margin, between) == ["would decide it: more points there"]
    assert lines(at_point) == ["would decide it: a finer preset"]
    assert lines(between, by_model, by_model) == [
        "would decide them: a test there (2), more points there (1)"
    ]
