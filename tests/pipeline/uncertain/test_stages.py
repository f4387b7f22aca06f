"""Small forms of the campaigns on runs by stages, and on false alarms."""

import pytest

from tests.helpers.samples import fewer_draws
from tests.promises.laboratories import alarms
from tests.promises.stages import (
    KINDS,
    closed_form,
    closed_rigs,
    is_right,
    judged_rows,
    summarise,
    weigh_closed,
)


@pytest.fixture(scope="module")
def results():
    with pytest.MonkeyPatch.context() as patch, closed_form():
        fewer_draws(patch)
        rows = judged_rows(closed_rigs(24), 6, weigh_closed)
    return {kind: summarise(of_kind) for kind, of_kind in rows.items()}


@pytest.mark.parametrize("kind", KINDS)
def test_intervals_by_stages_hold_and_are_not_off(results, kind):
    assert is_right(results[kind], errors=2.0)  # of three kinds, by few truths


@pytest.mark.parametrize("has_long_tails", [False, True])
def test_no_test_of_a_few_sound_logs_is_called_an_outlier(has_long_tails):
    with closed_form():
        assert alarms(6, has_long_tails, 20)["logs with a test named"] == 0


@pytest.mark.parametrize(("held", "off"), [(0.5, 0.0), (0.9, 0.1), (1.0, 0.03)])
def test_a_campaign_of_stages_fails_where_too_few_hold_or_all_are_off(held, off):
    result = {"held": held, "its_error": 0.04, "off": off, "off_error": 0.005}
    assert not is_right(result)
