import numpy as np
import pytest

from tribo import QUANTILES
from tribo.thermal import contact_quantiles, failed_share, rise_exceeded


def test_quantile_and_failed_share_are_one_criterion():
    random = np.random.default_rng(0)
    rise = random.gamma(4.0, 20.0, size=(60, 50))
    contact = random.uniform(size=rise.shape) < 0.5
    quantiles = contact_quantiles(rise, contact)
    for share in (0.05, 0.1, 0.2):
        limit = quantiles[QUANTILES.index(1 - share)]
        # 1500 nodes: one of them is 0.07 % of the area.
        assert np.mean(rise[contact] > limit) == pytest.approx(share, abs=7e-4)
        assert failed_share(quantiles, limit) == pytest.approx(share, abs=1e-12)


@pytest.mark.parametrize("nodes", [1, 2, 3, 1000])
def test_quantiles_are_those_of_numpy(nodes):
    rise = np.random.default_rng(nodes).gamma(4.0, 20.0, size=(1, nodes))
    expected = np.quantile(rise, QUANTILES)
    assert contact_quantiles(rise, rise > 0) == pytest.approx(expected, rel=1e-13)


def test_share_is_nothing_above_the_maximum_and_all_below_the_minimum():
    quantiles = np.linspace(10.0, 20.0, len(QUANTILES))
    assert failed_share(quantiles, 20.1) == 0.0
    assert failed_share(quantiles, 9.9) == 1.0


@pytest.mark.parametrize(("share", "rise"), [(0.75, 10.0), (0.625, 15.0), (0.25, 40.0)])
def test_shares_at_the_ends_of_a_selection_have_its_first_and_last_quantile(share, rise):
    rises = np.array([[10.0, 20.0, 40.0]])
    assert rise_exceeded(rises, share, (0.25, 0.5, 0.75)) == pytest.approx([rise])


def test_a_selection_of_one_quantile_has_its_rise():
    with np.errstate(all="raise"):
        assert rise_exceeded(np.array([[30.0]]), 0.1, (0.9,)).tolist() == [30.0]
