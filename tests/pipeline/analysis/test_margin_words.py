"""Words, ends and tables of margins at numbers that are given."""

import pytest

import pipeline
from pipeline.analysis.margin import percent
from pipeline.analysis.margin_frame import LONG
from pipeline.analysis.rise_error import RiseError
from tests.helpers import synthetic


@pytest.fixture(scope="module")
def here():
    return pipeline.margin(synthetic.sweep(), 400.0, 1.4)


# Verdicts and their words


@pytest.mark.parametrize(
    ("probability", "words"),
    [
        (0.0, "less than 1 %"),
        (0.0099, "less than 1 %"),
        (0.0123, "1.2 %"),
        (0.5, "50 %"),
        (0.9849, "98 %"),
        (0.991, "more than 99 %"),
        (1.0, "more than 99 %"),
    ],
)
def test_a_probability_is_told_no_finer_than_it_is_known(probability, words):
    assert percent(probability) == words


def changed(margin, **values):
    """Copy of a margin with some other values."""
    return type(margin)(
        **{name: getattr(margin, name) for name in type(margin).__dataclass_fields__} | values
    )


def test_the_sentence_tells_verdict_probability_and_distance(here):
    mild = changed(here, lowest=0.001, probability=0.012, highest=0.02, distance=28.43)
    assert mild.sentence == (
        "Mild: severe wear is 1.2 % likely (at most 2 %), 28.4 K below the critical temperature"
    )
    severe = changed(
        here,
        lowest=0.98,
        probability=0.98,
        highest=0.98,
        distance=-5.0,
        not_severe="",
        tested=("mild at 1 m/s", "severe at 2 m/s"),
    )
    assert severe.sentence == (
        "Severe: severe wear is 98 % likely, 5 K above the critical temperature; "
        "tested there: mild at 1 m/s, severe at 2 m/s"
    )
    high = changed(here, lowest=0.9, probability=0.97, highest=0.999)
    assert "97 % likely (at least 90 %)" in high.sentence
    assert "0 K below" in changed(here, distance=0.0).sentence


# Tables


def test_a_table_of_points_has_an_answer_or_a_note_for_each():
    points = {"load": ["400 N", "600 N", "9 kN"], "velocity": ["1.4 m/s", "2.4 m/s", "1 m/s"]}
    found = pipeline.margin(synthetic.sweep(), points)
    assert [*found] == [
        *("load [N]", "velocity [m/s]", "verdict", "probability", "deciding temperature [°C]"),
        *("temperature error [K]", "surface error [K]", "distance [K]", "velocity factor"),
        "critical velocity [m/s]",
        *("with tests [m/s]", "velocity outcome", "load factor", "critical load [N]"),
        *("load outcome", "conditions", "notes"),
    ]
    assert found["verdict"].tolist() == ["mild", "severe", "not known"]
    assert found["load [N]"].tolist() == [400.0, 600.0, 9000.0]
    one = pipeline.margin(synthetic.sweep(), 400.0, 1.4)
    first = found.iloc[0]
    assert first["deciding temperature [°C]"] == pytest.approx(one.deciding_temperature - 273.15)
    assert first["distance [K]"] == pytest.approx(one.distance)
    assert first["probability"] == pytest.approx(one.probability)
    assert first["critical load [N]"] == pytest.approx(one.critical_load)
    assert first["notes"] == " | ".join(one.caveats)
    assert "9000 N" in found.iloc[2]["notes"] or "9 kN" in found.iloc[2]["notes"]
    assert found.iloc[2, 3:-1].isna().all()
    assert {*LONG} < {*found}


@pytest.mark.parametrize(
    ("error", "changes", "kind"),
    [
        ((1.0, 2.0, 0.0), {}, "a finer preset"),
        ((3.0, 2.0, 1.0), {}, "more points near it"),
        ((0.0, 2.0, 2.5), {}, "what its warnings ask for"),
        ((3.0, 2.0, None), {}, "what its warnings ask for"),
        ((3.0, None, 1.0), {}, "its numerical error, which is known for a preset"),
        ((None, 2.0, 1.0), {}, "more points near it"),
        ((1.0, 2.0, 0.0, 3.0), {}, "more patches (sweep.realizations)"),
        ((3.0, 2.0, 1.0), {"probability": 0.3}, "a test at this point"),
        ((3.0, 2.0, 1.0), {"highest": 0.03}, None),  # mild
    ],
)
def test_what_is_not_decided_says_what_kind_of_thing_would_decide_it(here, error, changes, kind):
    open_ = {
        "lowest": 0.0,
        "probability": 0.02,
        "highest": 0.5,
        "error": RiseError(*error, *[0.0] * (4 - len(error))),
    }
    found = changed(here, **open_ | changes)
    assert found.decided_by == kind
