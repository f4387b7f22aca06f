"""The deciding rise of one moment (tribo/thermal/criterion.py)."""

import numpy as np
import pytest

from tribo import BULK_RATIOS, QUANTILES, Criterion
from tribo.simulation import Heat
from tribo.thermal import with_bulk_ratio

RISE = np.linspace(100.0, 400.0, len(QUANTILES))


@pytest.mark.parametrize("ratio", [200.0, -1000.0])
def test_a_uniform_response_moves_every_criterion_alike(ratio):
    unequal = np.array([RISE + 0.75 * kept for kept in BULK_RATIOS])
    heat = Heat(
        rise=np.zeros((1, 1)),
        rise_quantile=RISE,
        max_rise=400.0,
        mean_rise=250.0,
        pin_heat_share=0.2,
        mean_bulk_response=0.75,
        bulk_rise_quantile=unequal,
    )
    equal = heat.columns
    moved = with_bulk_ratio(equal | {"max_rise": 400.0}, ratio)
    assert moved["max_rise"] == pytest.approx(400.0 + 0.75 * ratio)
    for criterion in (Criterion(), Criterion("highest"), Criterion("mean")):
        expected = criterion.rise(equal) + 0.75 * ratio
        assert criterion.rise(moved) == pytest.approx(expected)
