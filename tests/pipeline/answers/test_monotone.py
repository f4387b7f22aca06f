"""What further points change of stated errors: random planes, in closed form."""

import numpy as np

from pipeline.answers.error import interpolation_errors
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
    return merged(loads, velocities, ln_rise[None], 0.02 * ones, 0 * ones.astype(int), ones)


def bound(one, loads, velocities):
    """Bound of the error of interpolation at places."""
    along, between = interpolation_errors(one, loads, velocities)
    return np.hypot(along.sum(axis=0), between)


def with_one_more(seeds):
    """Yield a load of random planes before and after a point within, and its velocity."""
    for seed in seeds:
        loads, velocities, y, rng = plane(seed)
        known = rng.uniform(size=velocities.shape) < rng.uniform(0.3, 0.9)
        known[rng.choice(len(velocities), 2, replace=False)] = True
        free = [j for j in np.flatnonzero(~known).tolist() if known[:j].any() and known[j:].any()]
        if free:
            more, j = known.copy(), free[rng.integers(len(free))]
            more[j] = True
            row = loads[:1], velocities, y[:1]
            yield *(specimen(*row, one[None]) for one in (known, more)), velocities[j]


def bound_at(one, velocities):
    return bound(one, np.full(len(velocities), one.field.loads[0]), velocities)


def test_a_point_within_or_beyond_the_bound_stated_there_changes_it_little_or_to_its_distance():
    """Within it by more than a tenth at 2 % of places, beyond it on both sides."""
    ratios, beyond = [], 0
    for before, after, velocity in with_one_more(range(150)):
        at, place = np.array([velocity]), (before.field.loads, np.array([velocity]))
        off = abs(before.field(*place)[0] - after.field(*place)[0])
        x = np.log(after.field.velocities[after.field.is_known[0]])
        if off <= bound_at(before, at)[0]:
            on = np.exp(np.linspace(x[0], x[-1], 41))
            earlier, later = bound_at(before, on), bound_at(after, on)
            ratios += (later[earlier > 1e-9] / earlier[earlier > 1e-9]).tolist()
        else:
            j = np.argmin(np.abs(x - np.log(velocity)))
            middles = np.exp(x[j - 1 : j + 1] + np.diff(x)[j - 1 : j + 1] / 2)
            assert (bound_at(after, middles) >= off * (1 - 1e-9)).all()
            beyond += 1
    assert len(ratios) > 2500
    assert (np.array(ratios) > 1.1).mean() < 0.02
    assert beyond > 15


def test_points_far_away_never_change_an_error():
    for seed in range(40):
        loads, velocities, y, rng = plane(seed)
        if len(velocities) < 8 or len(loads) < 8:
            continue
        known = np.zeros(y.shape, bool)
        known[1:7, 1:7] = True  # three on each side
        at = np.exp(rng.uniform(*np.log(loads[[3, 4]]), 9))
        on = np.exp(rng.uniform(*np.log(velocities[[3, 4]]), 9))
        few, more = (
            bound(specimen(loads, velocities, y, one), at, on)
            for one in (known, np.ones_like(known))
        )
        np.testing.assert_allclose(more, few, rtol=1e-9)


def test_a_plane_beyond_the_bounds_is_told_so():
    loads, velocities, y, _ = plane(3)
    steep = y + 3 * np.log(velocities) ** 2
    middle = np.sqrt(velocities[:1] * velocities[1])
    usual, bent = (
        bound(specimen(loads, velocities, one, np.ones(y.shape, bool)), loads[:1], middle)
        for one in (y, steep)
    )
    assert bent[0] > 2 * usual[0]
