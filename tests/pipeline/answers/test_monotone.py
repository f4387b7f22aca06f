"""Further points never state a larger error of the boundary: 160 random planes, in closed form."""

import numpy as np
import pytest

from pipeline.answers.error import interpolation_errors, rise_errors, total, velocity_errors
from pipeline.answers.specimen import merged


def plane(seed, bend=0.07, rough=0.001):
    """ln(rise/limit) of a random plane, no more bent and rough than `BENT` and `ROUGH` say."""
    rng = np.random.default_rng(seed)
    loads = np.sort(rng.uniform(100, 1000, rng.integers(4, 13)))
    velocities = np.sort(rng.uniform(0.2, 6, rng.integers(5, 20)))
    x, f = np.log(velocities / 1.5), np.log(loads / 400)[:, None]
    y = 0.58 * f + rng.uniform(0.4, 0.9) * x + rng.uniform(-bend, bend) * x**2
    return loads, velocities, y + rng.normal(0, rough, y.shape), rng


def specimen(loads, velocities, y, known):
    ones = np.ones(y.shape)
    ln_rise = np.where(known, np.log(1200.0) + y, np.nan)
    return merged(loads, velocities, ln_rise[None], 0.02 * ones[:, 0], 0 * ones.astype(int), ones)


def interpolation(*plane, at, on):
    along, between = interpolation_errors(specimen(*plane), at, on)
    return np.hypot(along.sum(axis=0), between)


@pytest.mark.parametrize("seeds", range(2))
def test_further_points_beside_a_place_seldom_enlarge_its_error_of_interpolation(seeds):
    grown = count = 0
    for seed in range(80 * seeds, 80 * seeds + 80):
        loads, velocities, y, rng = plane(seed)
        known = np.zeros(y.shape, bool)
        known[:, rng.choice(len(velocities), 2, replace=False)] = True
        at = np.exp(rng.uniform(*np.log(loads[[0, -1]]), 9))
        on = np.exp(rng.uniform(*np.log(velocities[[0, -1]]), 9))
        at[:6] = rng.choice(loads, 6)
        before = np.full(9, 1e9)
        for share in (0.0, 0.2, 0.5, 1.0):
            known |= rng.uniform(size=y.shape) < share
            found = interpolation(loads, velocities, y, known, at=at, on=on)
            # More points show more of how the curve bends, which may be more than was taken.
            grown += (found > 1.25 * before + 5e-4).sum()
            count += len(found)
            before = np.minimum(found, before)
    assert grown < 0.02 * count


def test_points_far_away_never_change_an_error():
    for seed in range(40):
        loads, velocities, y, rng = plane(seed)
        if len(velocities) < 7 or len(loads) < 7:
            continue
        known = np.zeros(y.shape, bool)
        known[2:6, 2:6] = True
        at = np.exp(rng.uniform(*np.log(loads[[3, 4]]), 9))
        on = np.exp(rng.uniform(*np.log(velocities[[3, 4]]), 9))
        few = interpolation(loads, velocities, y, known, at=at, on=on)
        more = interpolation(loads, velocities, y, np.ones_like(known), at=at, on=on)
        np.testing.assert_allclose(more, few, rtol=1e-9)


def test_errors_of_critical_velocities_seldom_grow_as_their_slopes_are_known_better():
    larger = count = 0
    for seed in range(60):
        loads, velocities, y, rng = plane(seed)
        known = rng.uniform(size=y.shape) < 0.6
        before, after = (
            _of_boundary(specimen(loads, velocities, y, k)) for k in (known, np.ones_like(known))
        )
        is_known = np.isfinite(before) & np.isfinite(after)
        larger += (after > 1.02 * before + 1e-4)[is_known].sum()
        count += is_known.sum()
    assert count > 150
    assert larger < 0.07 * count


def _of_boundary(one):
    loads = one.field.loads
    critical = one.field.along_velocity(loads, np.full(len(loads), np.log(1200.0))).critical
    parts = rise_errors(one, 0.015, loads, critical)
    return total(velocity_errors(one.field, parts, 0.015, loads, critical))


def test_a_plane_beyond_the_bounds_is_told_so():
    loads, velocities, y, _ = plane(3)
    steep = y + 3 * np.log(velocities) ** 2
    middle = np.sqrt(velocities[:1] * velocities[1])
    usual, bent = (
        interpolation(loads, velocities, one, np.ones(y.shape, bool), at=loads[:1], on=middle)
        for one in (y, steep)
    )
    assert bent[0] > 2 * usual[0]
