"""Which temperature decides, and in which words (tribo/thermal/criterion.py)."""

import numpy as np
import pytest

from tribo import QUANTILES
from tribo.errors import InvariantError
from tribo.thermal import Criterion, Rule

EVEN = 100.0 * np.array(QUANTILES)
"""Rises spread evenly over the contact from 0 to 100 K."""
COLUMNS = {"rise_quantile": EVEN, "mean_rise": 40.0}
LOWEST = Rule("rise_quantile", lambda rises, *_: rises[..., 0], "lowest", "all above")
UPPER = Rule("rise_quantile", lambda rises, share, _: rises[..., -1], "of {share:g} %", "own")


@pytest.mark.parametrize(
    ("criterion", "rise", "temperature", "severe"),
    [
        (Criterion(), 90.0, "exceeded on 10 % of the contact",
         "more than 10 % of the contact above"),
        (Criterion(share=0.25), 75.0, "exceeded on 25 % of the contact",
         "more than 25 % of the contact above"),
        (Criterion(share=0.0), 100.0, "maximum", "any of the contact above"),
        (Criterion("highest"), 100.0, "maximum", "any of the contact above"),
        (Criterion("mean"), 40.0, "mean of the contact", "the mean of the contact above"),
        (Criterion("mean", 0.0), 40.0, "mean of the contact", "the mean of the contact above"),
        (Criterion("own", rule=LOWEST), 0.0, "lowest", "all above"),
        (Criterion("own", 0.2, UPPER), 100.0, "of 20 %", "own"),
    ],
)  # fmt: skip
def test_a_criterion_decides_by_one_temperature_and_says_which(
    criterion, rise, temperature, severe
):
    assert criterion.rise(COLUMNS) == pytest.approx(rise)
    assert (criterion.temperature, criterion.severe) == (temperature, severe)


def test_a_share_stands_for_its_criterion_and_quantiles_may_be_few():
    few = {"rise_quantile": np.array([10.0, 20.0, 40.0]), "quantile": np.array([0.5, 0.8, 1.0])}
    assert Criterion(share=0.2).rise(few) == pytest.approx(20.0)
    assert Criterion("highest").rise(few) == pytest.approx(40.0)


def test_at_its_limit_wear_is_mild_and_what_is_not_known_is_not_severe():
    rises = np.array([99.0, 100.0, 101.0, np.nan])
    assert Criterion.is_severe(rises, 100.0).tolist() == [False, False, True, False]


@pytest.mark.parametrize(
    ("rises", "fault"),
    [
        ([[10.0, 50.0], [0.0, 5.0]], None),  # lowest rise at one point, highest at the other
        ([[10.0 - 4e-8, 0.0], [0.0, 5.0]], None),  # rounding: 1e-9 of the highest rise, 50 K
        ([[10.0, 50.0 + 4e-8], [0.0, 5.0]], None),
        ([[10.0 - 6e-8, 0.0], [0.0, 5.0]], "beyond the lowest and highest"),
        ([[10.0, 50.0 + 6e-8], [0.0, 5.0]], "beyond the lowest and highest"),
        ([[np.nan, 0.0], [0.0, 5.0]], "or is not a number"),
        ([[10.0, np.nan], [0.0, 5.0]], None),  # at a point without contact
        ([10.0, 0.0], r"shape \(2,\); they must have \(2, 2\), one for each row"),
    ],
)
def test_a_rise_of_ones_own_lies_within_its_contact(rises, fault):
    contacts = [(10.0, 50.0), (0.0, 50.0), (0.0, 50.0), (5.0, 50.0)]
    stored = np.array([np.linspace(low, high, len(QUANTILES)) for low, high in contacts])
    stored = stored.reshape(2, 2, -1)
    if fault is None and np.isnan(rises).any():
        stored[np.isnan(rises)] = np.nan
    own = Criterion("own", rule=Rule("rise_quantile", lambda *_: np.array(rises), "own", "own"))
    if fault:
        with pytest.raises(InvariantError, match=f"criterion own: .*{fault}"):
            own.rise({"rise_quantile": stored})
        return
    assert np.array_equal(own.rise({"rise_quantile": stored}), rises, equal_nan=True)


def test_a_mean_of_ones_own_has_no_quantiles_to_lie_within():
    own = Criterion("own", rule=Rule("mean_rise", lambda mean, *_: 3 * mean, "own", "own"))
    assert own.rise({"mean_rise": np.array([40.0, np.nan])})[0] == 120.0
