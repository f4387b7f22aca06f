import numpy as np
import pytest

from tribo import Grid, Wear
from tribo.contact import ElasticHalfSpace, solve_contact
from tribo.wear.archard import WEAR_SCHEMES, Stage

GRID = Grid((12, 10), (1e-6, 1e-6))


def test_swept_wear_is_uniform_along_y_and_local_wear_follows_the_pressure():
    pressure = 1e9 * np.random.default_rng(0).uniform(size=GRID.shape)
    swept, local = (Wear(1e-15, pattern).depth(pressure, 1.0) for pattern in ("swept", "local"))
    assert np.ptp(swept, axis=1).max() == 0
    assert local == pytest.approx(1e-15 * pressure * 1.0)  # Archard: h = kpS
    assert swept.mean(axis=1) == pytest.approx(local.mean(axis=1))


@pytest.mark.parametrize("pattern", ["local", "swept"])
def test_yielding_solid_displaces_by_elasticity_and_wear(pattern):
    solid = ElasticHalfSpace(GRID, 115e9)
    wear = Wear(1.2e-15, pattern)
    pressure = 1e9 * np.random.default_rng(1).uniform(size=GRID.shape)
    expected = solid(pressure) + wear.depth(pressure, 0.0625)
    assert wear.yielding(solid, 0.0625)(pressure) == pytest.approx(expected, rel=1e-12)


@pytest.mark.parametrize("scheme", WEAR_SCHEMES.values(), ids=WEAR_SCHEMES)
def test_a_load_that_falls_to_nothing_wears_at_its_mean_and_ends_without_wear(scheme):
    first, last = scheme.stages((80.0, 0.0), mean_load=400.0, distance=3.0)
    assert first == Stage(400.0, 3.0, 3.0 if scheme.implicitness else 0.0)
    assert last == Stage(0.0, 0.0, 0.0)


def test_implicit_step_ends_where_the_worn_shape_carries_the_pressure():
    solid = ElasticHalfSpace(GRID, 115e9)
    z = 1e-7 * np.random.default_rng(2).uniform(size=GRID.shape)
    wear, distance = Wear(1.2e-15, "swept"), 0.0625
    stepped = solve_contact(wear.yielding(solid, distance), z, 0.02, 6.6e9, tolerance=1e-10)
    worn = z + wear.depth(stepped.pressure, distance)
    resolved = solve_contact(solid, worn, 0.02, 6.6e9, tolerance=1e-10)
    assert resolved.pressure == pytest.approx(stepped.pressure, abs=1e-7 * 6.6e9)


@pytest.mark.parametrize("scheme", WEAR_SCHEMES.values(), ids=WEAR_SCHEMES)
def test_a_step_that_carries_no_load_wears_nothing(scheme):
    for stage in scheme.stages((0.0, 0.0), mean_load=0.0, distance=3.0):
        assert stage == Stage(0.0, 0.0, 0.0)
