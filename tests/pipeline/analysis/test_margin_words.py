"""Words, ends and tables of margins at numbers that are given."""

import math
from dataclasses import dataclass

import numpy as np
import pandas as pd
import pytest
import xarray as xr

import pipeline
from pipeline.analysis.margin import (
    _bounded,
    error_band,
    percent,
    probabilities_alone,
    told,
    verdict_between,
)
from pipeline.analysis.margin_frame import (
    LONG,
    _passed_on,
    counts_in_words,
    row_labels,
)
from pipeline.analysis.rise_error import RiseError
from pipeline.analysis.transition import (
    ABOVE,
    CROSSES,
    MILD,
    SEVERAL,
    SEVERE,
    UNKNOWN,
    Transitions,
)
from pipeline.scene.along import OperatingPoints, Place
from tests.helpers import synthetic
from tribo import InputError

NONE = RiseError(0.0, 0.0, 0.0)


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
    assert told(probability) == pytest.approx(number, rel=1e-12)


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
    ("lowest", "probability", "highest", "misfit", "verdict", "by_model"),
    [
        (0.0, 0.01, 0.02, "", "mild", False),
        (0.0, 0.01, 0.5, "", "not decided", False),
        (0.2, 0.3, 0.5, "", "not decided", True),
        (0.0, 0.01, 0.02, "tests contradict it", "not decided", True),
    ],
)
def test_what_the_model_leaves_open_is_told_from_the_numerical_error(
    here, lowest, probability, highest, misfit, verdict, by_model
):
    found = changed(here, lowest=lowest, probability=probability, highest=highest, misfit=misfit)
    assert (found.verdict, found.is_open_by_model) == (verdict, by_model)


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


def test_plain_data_have_the_answers_and_the_values_of_entries(here):
    found = changed(here, probability=0.0, highest=1.0, entries={"pin.radius": 2e-3})
    plain = found.as_dict()
    assert "entries" not in plain
    assert plain["pin.radius"] == 2e-3
    assert (plain["probability"], plain["highest"]) == (1e-4, 1 - 1e-4)
    assert plain["verdict"] == "not decided"
    assert plain["velocity_factor"] == found.critical_velocity / 1.4
    assert plain["load_factor"] == found.critical_load / 400.0
    assert plain["temperature_error"] == found.error.total
    assert plain["sentence"] == found.sentence


def test_a_margin_has_its_place_ranges_and_counts(here):
    assert (here.load, here.velocity) == (400.0, 1.4)
    assert here.velocity_range == (0.5, 4.0)
    assert here.load_range == (200.0, 750.0)
    assert (here.members, here.counts_inputs, here.intervals) == (1, False, {})
    assert (here.is_computed, here.is_continued) == (False, False)
    assert pipeline.margin(synthetic.sweep(), 400.0, 1.5).is_computed
    assert here.critical_temperature == pytest.approx(418.15)
    critical = synthetic.critical_velocity(400.0, synthetic.limit())
    assert here.critical_velocity == pytest.approx(critical, rel=1e-9)
    assert here.lowest < here.probability < here.highest


def transitions_of(*codes, places=()):
    """Transitions of members with these outcomes, from 0.5 to 4 m/s or N."""
    ends = {MILD: math.inf, ABOVE: math.inf, SEVERE: -math.inf, UNKNOWN: math.nan}
    first = np.array([ends.get(code, 2.0) for code in codes])
    ends = np.array([0.5]), np.array([4.0])
    turns = np.array([places]) if places else np.empty((0, 0))
    return Transitions(np.array(codes)[:, None], first[:, None], ends, turns)


@pytest.mark.parametrize(
    ("codes", "said"),
    [
        ((MILD, MILD), "mild throughout"),
        ((SEVERE,), "severe throughout"),
        ((ABOVE,), "mild at every load computed (to 4 N)"),
        ((SEVERAL, SEVERAL), "severe at some load and mild at a higher one"),
        ((MILD, SEVERE), "mild throughout on 1, severe throughout on 1 of 2"),
        ((CROSSES, CROSSES, MILD), "crosses on 2 of 3"),
        (
            (CROSSES, SEVERAL, CROSSES, MILD),
            "crosses on 2, severe at some load and mild at a higher one on 1 of 4",
        ),
    ],
)
def test_outcomes_are_one_or_on_how_many_members_wear_turns(codes, said):
    assert [*transitions_of(*codes).worded("load")] == [said]


def test_the_outcome_of_one_member_that_turns_several_times_is_its_ranges():
    found = transitions_of(SEVERAL, places=(2.0, 3.0, 3.5))
    assert [*found.worded("velocity")] == ["severe from 2 to 3 m/s and from 3.5 m/s on"]
    begun = found._replace(first=np.array([[-math.inf]]))
    assert [*begun.worded("velocity")] == ["severe up to 2 m/s and from 3 to 3.5 m/s"]


# Numerical errors


def test_a_quantity_is_bounded_by_the_shift_of_the_logarithm_of_the_rise():
    low, middle, high = _bounded(np.array, [RiseError(0.03, 0.04, 0.0)])
    assert (low[0], middle, high[0]) == pytest.approx((-math.log(1.05), 0.0, math.log(1.05)))
    unknown = _bounded(lambda shift: 0 * shift + 0.3, [RiseError(0.1, None, 0.0)])
    assert unknown == ([0.0], [0.3], [1.0])


@dataclass
class Normal:
    """A scatter that spreads evenly from -0.2 to 0.2."""

    worded: str = ""

    def below(self, distances):
        return np.clip((np.asarray(distances) + 0.2) / 0.4, 0.0, 1.0)


@pytest.mark.parametrize(
    ("rise", "limit", "expected"),
    [
        (100.0, 100.0, 0.5),
        (100.0, 100.0 * math.exp(0.1), 0.25),
        (100.0, 100.0 * math.exp(-0.1), 0.75),
        (0.0, 100.0, 0.0),
        (100.0, math.inf, 0.0),
    ],
)
def test_a_point_alone_is_severe_by_the_ratio_of_its_rise_to_the_limit(rise, limit, expected):
    found = probabilities_alone(rise, [limit], Normal(), NONE)
    assert found == pytest.approx((expected,) * 3, abs=1e-12)


def test_a_point_alone_turns_where_its_known_friction_turns_wear():
    """Beyond the point friction falls as 1/V², so that the rise has its top there."""
    found = probabilities_alone(99.0, [100.0], Normal(), NONE, lambda v: np.where(v > 1, v**-2, 1))
    assert found == pytest.approx((0.0,) * 3, abs=1e-12)
    found = probabilities_alone(110.0, [100.0], Normal(), NONE, lambda v: np.where(v > 1, v**-2, 1))
    below = [Normal().below(np.log(ratio)) for ratio in (100 / 110, 110 / 100)]
    assert found == pytest.approx((below[1] - below[0],) * 3, abs=2e-3)


class Even:
    """A field whose probabilities of severe wear rise evenly, with a numerical error by velocity.

    Its rises are larger by the total that a function gives for a velocity; None is unknown.
    """

    misfit, at_once = "", 1000

    def __init__(self, begin=1.0, end=3.0, total=lambda _: 0.0):
        self.begin, self.end, self.total = begin, end, total

    def probability(self, loads, velocities, scatter, shift):
        return np.clip((velocities - self.begin) / (self.end - self.begin) + shift, 0.0, 1.0)

    def errors(self, loads, velocities):
        totals = (self.total(velocity) for velocity in velocities.tolist())
        return [RiseError(0.0, one if one is None else math.expm1(one), 0.0) for one in totals]

    def band(self):
        return error_band(self, np.array([400.0]), VELOCITIES, Normal())[0]


VELOCITIES = np.linspace(0.5, 3.5, 301)


@pytest.mark.parametrize(
    ("begin", "end", "expected"),
    [
        (1.0, 3.0, (1.1, 2.9)),  # 5 and 95 %
        (4.0, 5.0, (math.inf, math.nan)),  # mild at all
        (0.0, 0.4, (math.nan, 0.0)),  # severe at all
        (0.4, 3.0, (0.53, 2.87)),
        (1.0, 3.9, (1.145, math.nan)),  # not severe at the highest
        (0.3, 5.0, (0.535, math.nan)),
        (0.0, 3.0, (math.nan, 2.85)),  # not mild at the lowest
        (1.0, 1 + 2.495 / 0.95, (1.131, 3.495)),  # severe at the highest alone
        (0.505 - 0.05, 1.455, (0.505, 1.405)),  # mild at the lowest alone
    ],
)
def test_wear_is_mild_below_and_severe_above_where_5_and_95_percent_are_crossed(
    begin, end, expected
):
    assert Even(begin, end).band() == pytest.approx(expected, abs=2e-3, nan_ok=True)


def test_an_end_between_two_velocities_is_interpolated_from_these_alone():
    """Shares of 0, 25, 75 and 100 % at 1, 1.01, 1.02 and 1.03 m/s."""
    assert Even(1.005, 1.025).band() == pytest.approx((1.002, 1.028), abs=1e-6)


def test_ends_of_the_error_band_have_the_error_that_is_there():
    assert Even(total=lambda _: 0.1).band() == pytest.approx((0.9, 3.1), abs=2e-3)
    found = Even(total=lambda v: 0.05 * v).band()
    # 0.05 = (v - 1)/2 + 0.05 v, 0.95 = (v - 1)/2 - 0.05 v
    assert found == pytest.approx((1.0, 1.45 / 0.45), rel=2e-3)


def test_neither_is_decided_where_the_numerical_error_is_unknown():
    assert np.isnan(Even(total=lambda _: None).band()).all()
    found = Even(total=lambda v: None if 0.7 < v < 3.3 else 0.0).band()
    # A step between two velocities, 0.01 m/s apart.
    assert found == pytest.approx((0.7, 3.3), abs=0.01)
    farther_on = Even(total=lambda v: None if v > 3.2 else 0.0)
    assert farther_on.band() == pytest.approx((1.1, 2.9), abs=2e-3)
    mild = Even(4.0, 5.0, lambda v: None if v > 3.0 else 0.0)
    assert mild.band()[0] == pytest.approx(3.0, abs=0.01)
    contradicted = Even()
    contradicted.misfit = "tests contradict it"
    assert np.isnan(contradicted.band()).all()


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


def test_further_columns_are_passed_on_for_each_scene_and_told_from_results():
    results = pd.DataFrame({"verdict": ["mild"] * 4, "distance [K]": [1.0] * 4})
    places = (Place(400.0, 1.0), Place(500.0, 1.0))
    others = {"test": ["a", "b"], "verdict": ["x", "y"], "distance": [3, 4]}
    found = _passed_on(OperatingPoints(places, others), results)
    assert {name: [*values] for name, values in found.items()} == {
        "test": ["a", "b"] * 2,
        "verdict (given)": ["x", "y"] * 2,
        "distance (given)": [3, 4] * 2,
    }
    one = _passed_on(OperatingPoints(places[:1], {"test": ["a"]}), results[:1])
    assert one["test"].tolist() == ["a"]
    assert _passed_on(None, results).empty


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


def test_a_note_says_why_a_place_is_not_known_before_it_doubts_a_condition():
    points = {"load": ["400 N"], "velocity": ["1 m/s"], "bulk temperature": ["333 degC"]}
    (note,) = pipeline.margin(synthetic.sweep(), points)["notes"]
    why, doubt = note.split(" | ")
    assert why.startswith("critical_temperature is 145 °C")
    assert doubt.endswith("the bulk temperature is 333 °C, where -50 °C to 250 °C are usual: check "
                         "its unit")  # fmt: skip


def test_a_place_is_given_whole():
    ds = synthetic.sweep()
    for given, missing in (
        ({"velocity": 1.0}, "velocity is given without a load"),
        ({"load": 400.0}, "load is given without a velocity"),
        ({"load": 400}, "load is given without a velocity"),
        ({}, "no operating point is given, and the rows have none of their own"),
    ):
        with pytest.raises(InputError, match=missing):
            pipeline.margin(ds, **given)


def test_over_two_surfaces_a_margin_has_medians_and_what_5_and_95_percent_stay_below():
    def hotter(*place):
        return 1.1 * synthetic.rise(*place)

    several = [synthetic.sweep(rise=rise) for rise in (synthetic.rise, hotter)]
    labels = xr.Variable("realization", [1, 2])
    found = pipeline.margin(xr.concat(several, labels, combine_attrs="override"), 400.0, 1.4)
    one, other = (pipeline.margin(ds, 400.0, 1.4) for ds in several)
    assert (found.members, found.counts_inputs) == (2, False)
    assert found.decisive_temperature == pytest.approx(
        (one.decisive_temperature + other.decisive_temperature) / 2
    )
    ends = {
        "decisive_temperature": (one.decisive_temperature, other.decisive_temperature),
        "distance": (other.distance, one.distance),
        "critical_velocity": (other.critical_velocity, one.critical_velocity),
    }
    for name, expected in ends.items():
        assert found.intervals[name] == pytest.approx(expected, rel=1e-9), name
    assert found.velocity_outcome == "crosses"
    table = pipeline.margin(
        xr.concat(several, labels, combine_attrs="override"), {"load": [400.0], "velocity": [1.4]}
    )
    low, high = table["distance low [K]"].item(), table["distance high [K]"].item()
    assert (low, high) == pytest.approx(found.intervals["distance"])
