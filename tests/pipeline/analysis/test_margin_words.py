"""Words, ends and tables of margins at numbers that are given."""

import numpy as np
import pandas as pd
import pytest

import pipeline
from pipeline.analysis.margin import (
    clipped,
    percent,
    verdict_between,
)
from pipeline.analysis.margin_frame import (
    LONG,
    counts_in_words,
    row_labels,
)
from pipeline.analysis.rise_error import RiseError
from tests.helpers import synthetic


@pytest.fixture(scope="module")
def here():
    return pipeline.margin(synthetic.sweep(), 400.0, 1.4)


# Verdicts and their words


@pytest.mark.parametrize(
    ("lowest", "highest", "verdict"),
    [
        (0.0, 0.05, "mild"),
        (0.0, 0.051, "not decided"),
        (0.949, 1.0, "not decided"),
        (0.95, 1.0, "severe"),
        (0.0, 1.0, "not decided"),
    ],
)
def test_a_verdict_is_given_with_95_percent_probability_at_the_worst_error(
    lowest, highest, verdict
):
    assert verdict_between(lowest, highest) == verdict


@pytest.mark.parametrize(
    ("probability", "words", "number"),
    [
        (0.0, "less than 0.01 %", 1e-4),
        (1e-4, "0.01 %", 1e-4),
        (0.0123, "1.2 %", 0.0123),
        (0.5, "50 %", 0.5),
        (0.9949, "99 %", 0.9949),
        (0.995, "99.5 %", 0.995),
        (0.9953, "99.53 %", 0.9953),
        (0.99987, "99.99 %", 0.99987),
        (1 - 1e-4, "99.99 %", 1 - 1e-4),
        (1.0, "more than 99.99 %", 1 - 1e-4),
    ],
)
def test_a_probability_is_told_as_near_to_0_and_1_as_is_known(probability, words, number):
    assert percent(probability) == words
    assert clipped(probability) == pytest.approx(number, rel=1e-12)


def changed(margin, **values):
    """A margin with some other values."""
    return type(margin)(
        **{name: getattr(margin, name) for name in type(margin).__dataclass_fields__} | values
    )


def test_the_sentence_tells_verdict_probability_and_distance(here):
    mild = changed(here, lowest=0.001, probability=0.01, highest=0.02, distance=28.43)
    assert mild.sentence == (
        "Mild: severe wear is 1 % likely (0.1 to 2 %), 28.4 K below the critical temperature"
    )
    severe = changed(
        here,
        lowest=0.99,
        probability=0.99,
        highest=0.99,
        distance=-5.0,
        counts_inputs=True,
        tested=("mild at 1 m/s", "severe at 2 m/s"),
    )
    assert severe.sentence == (
        "Severe: severe wear is 99 % likely, 5 K above the critical temperature; "
        "tested there: mild at 1 m/s, severe at 2 m/s"
    )
    assert "0 K below" in changed(here, distance=0.0).sentence


@pytest.mark.parametrize(
    ("error", "changes", "kind"),
    [
        ((1.0, 2.0, 0.0), {}, "a finer preset"),
        ((3.0, 2.0, 1.0), {}, "more points there"),
        ((0.0, 2.0, 2.5), {}, "what the warnings ask for"),
        ((3.0, 2.0, None), {}, "what the warnings ask for"),
        (
            (3.0, None, 1.0),
            {},
            "its numerical error, which irg run SCENE -o STORE --measure measures",
        ),
        ((None, 2.0, 1.0), {}, "more points there"),
        ((3.0, 2.0, 1.0), {"probability": 0.3}, "a test there"),
        (
            (3.0, 2.0, 1.0),
            {"probability": 0.3, "counts_inputs": True},
            "better known inputs, such as the critical temperature, or a test there",
        ),
        ((3.0, 2.0, 1.0), {"highest": 0.03}, None),  # mild
    ],
)
def test_what_is_not_decided_says_what_kind_of_thing_would_decide_it(here, error, changes, kind):
    open_ = {"lowest": 0.0, "probability": 0.02, "highest": 0.5, "error": RiseError(*error)}
    found = changed(here, **open_ | changes)
    assert found.decided_by == found.as_dict()["decided_by"] == kind


# Tables


def frame(*rows):
    names = ("sample", "load [N]", "velocity [m/s]", "verdict", "distance [K]")
    return pd.DataFrame([*rows], columns=names)


def test_verdicts_of_a_table_are_counted_and_the_least_margin_is_named():
    several = frame(
        (1, 400.0, 1.5, "mild", 30.0), (2, 600.0, 2.0, "severe", -12.345), (3, 1.0, 1.0, "mild", 9)
    )
    said = "2 mild, 1 severe; the least margin is -12.3 K, at 600 N and 2 m/s"
    assert counts_in_words(several) == said
    assert counts_in_words(several[:1]) == "1 mild"
    unknown = frame(*[(k, 400.0, 1.5, "not known", np.nan) for k in range(2)])
    assert counts_in_words(unknown) == "2 not known"
    beside = frame((1, 400.0, 1.5, "not known", None), (2, 500.0, 2.5, "mild", 8.0))
    assert counts_in_words(beside) == (
        "1 mild, 1 not known; the least margin is 8 K, at 500 N and 2.5 m/s"
    )
    assert row_labels(several) == ["sample", "load [N]", "velocity [m/s]"]


def test_a_table_of_points_has_an_answer_or_a_note_for_each():
    points = {"load": ["400 N", "600 N", "9 kN"], "velocity": ["1.4 m/s", "2.4 m/s", "1 m/s"]}
    found = pipeline.margin(synthetic.sweep(), points)
    assert [*found] == [
        *("load [N]", "velocity [m/s]", "verdict", "probability", "decisive temperature [°C]"),
        *("temperature error [K]", "distance [K]", "distance low [K]", "distance high [K]"),
        *("velocity factor", "critical velocity [m/s]", "velocity outcome", "load factor"),
        *("critical load [N]", "load outcome", "notes"),
    ]
    assert found["verdict"].tolist() == ["mild", "severe", "not known"]
    assert found["load [N]"].tolist() == [400.0, 600.0, 9000.0]
    one = pipeline.margin(synthetic.sweep(), 400.0, 1.4)
    first = found.iloc[0]
    assert first["decisive temperature [°C]"] == pytest.approx(one.decisive_temperature - 273.15)
    assert first["distance [K]"] == pytest.approx(one.distance)
    assert first["probability"] == pytest.approx(max(one.probability, 1e-4))
    assert first["critical load [N]"] == pytest.approx(one.critical_load)
    assert np.isnan(first["distance low [K]"])
    assert first["notes"] == " | ".join(one.caveats)
    assert "9000 N" in found.iloc[2]["notes"] or "9 kN" in found.iloc[2]["notes"]
    assert found.iloc[2, 3:-1].isna().all()
    assert {*LONG} < {*found}
