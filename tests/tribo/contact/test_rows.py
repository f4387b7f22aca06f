"""The metric of soft rows (tribo/contact/rows.py)."""

import numpy as np
import pytest

from tribo import Grid, InputError, Wear
from tribo.contact import ElasticHalfSpace, solve_contact
from tribo.contact.rows import SoftRows
from tribo.surface import self_affine


@pytest.mark.parametrize("softness", [1.0, 1e8])
@pytest.mark.parametrize("hardness", [np.inf, 3e9])
def test_iterations_do_not_grow_with_the_wear_of_a_step(softness, hardness):
    grid = Grid((64, 64), (2e-6, 2e-6))
    solid = ElasticHalfSpace(grid, 115e9)
    z = grid.coordinates(0)[:, None] ** 2 / 4e-3 - self_affine(grid, 0.2e-6, 0.8, 6e-6, 0)
    rate = softness * solid.self_influence * grid.shape[1]
    worn = Wear(rate, "swept").yielding(solid, 1.0)
    contact = solve_contact(worn, z, 0.02 * 6.6e9 * grid.area, hardness, tolerance=1e-6)
    assert contact.residual <= 1e-6
    # 21 to 33; without the metric up to 88 at a softness of 1, and none from 100 on
    assert contact.iterations < 60


def test_rows_are_refused_as_soon_as_rounding_loses_more_than_ten_tolerances():
    grid, tolerance = Grid((32, 16), (2e-6, 2e-6)), 1e-6
    solid = ElasticHalfSpace(grid, 115e9)

    def worn(softness):
        return Wear(softness * solid.self_influence, "swept").yielding(solid, 1.0)

    unit = SoftRows.of(worn(1e9)).coupling / solid.self_influence / 1e9
    soft = worn(20 * tolerance / (solid.rounding * unit))  # rounding loses 20 tolerances
    with pytest.raises(InputError, match="take shorter steps"):
        solve_contact(soft, np.zeros(grid.shape), 0.02 * 6.6e9 * grid.area, tolerance=tolerance)
