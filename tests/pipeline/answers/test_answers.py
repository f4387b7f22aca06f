"""Curves, likelihood, errors and dominance of answers, against independent references."""

import math

import numpy as np
import pytest
from scipy.interpolate import PchipInterpolator
from scipy.special import ndtr
from scipy.stats import norm as normal
from scipy.stats import t as student

from pipeline.answers.error import (
    PRESET,
    curve_errors,
    interpolation_errors,
    rise_errors,
    velocity_errors,
    warned_errors,
)
from pipeline.answers.pchip import Pchip
from pipeline.answers.posterior import Outcome, Prior, update
from pipeline.answers.specimen import merge_realizations
from pipeline.constants import ROUGHNESS_DEVIATION
from tribo import WarningKind

LOADS, VELOCITIES = np.array([200.0, 300, 400, 600, 750]), np.array([0.5, 1, 1.5, 2.5, 4, 5])


def field():
    """A specimen with some curvature and roughness."""
    f, v = np.log(LOADS)[:, None], np.log(VELOCITIES)
    y = 0.8 * f + 0.62 * v - 0.04 * v**2 + 0.01 * np.sin(9 * f + 5 * v)
    unit = np.ones(y.shape)
    return merge_realizations(LOADS, VELOCITIES, y[None], 0.02 * unit, unit.astype(int), unit)


def errors(specimen, loads, velocities):
    along, between = interpolation_errors(specimen, specimen.field.at(loads, velocities))
    return np.hypot(along.sum(axis=0), between)


def test_curves_are_those_of_scipy():
    rng = np.random.default_rng(1)
    for n in (2, 3, 4, 9):
        x, y = np.sort(rng.uniform(0, 3, n)), rng.normal(size=(n, 5))
        at = rng.uniform(x[0], x[-1], 40)
        ours = Pchip(x, y).at(at[:, None], np.arange(5))
        assert ours == pytest.approx(PchipInterpolator(x, y)(at), abs=1e-12)


SETS = {
    "none": [],
    "one severe, far": [Outcome(severe=-0.75)],
    "five severe": [Outcome(severe=-0.3)] * 5,
    "ten mild": [Outcome(mild=0.1)] * 10,
    "twenty mild, far": [Outcome(mild=-1.0)] * 20,
    "severe among mild": [Outcome(severe=-0.3), *[Outcome(mild=-0.3)] * 20],
    "twenty severe": [Outcome(severe=-0.02 * k / 19) for k in range(20)],
    "transitions": [Outcome(y, y) for y in (0.059, 0.008, -0.088, 0.024)],
    "a slip": [Outcome(severe=-2.0), *[Outcome(y, y) for y in (0.05, 0.0)]],
    "one transition, far": [Outcome(-2.0, -2.0)],
    "a step": [Outcome(0.1, -0.1)],
    "contradicting": [Outcome(-0.1, 0.2), Outcome(mild=0.3)],
}


@pytest.mark.parametrize("results", SETS.values(), ids=SETS)
def test_probability_is_that_of_brute_force(results):
    u, v = np.linspace(-7, 7, 3001), np.linspace(math.log(0.003), math.log(60), 181)
    bias, scatter = 0.03 * np.sinh(u)[:, None], np.exp(v)
    logs = student.logpdf(bias / 0.15, 4) + np.log(np.cosh(u))[:, None]
    logs = logs - 4 * v - 2 * 0.055**2 / scatter**2
    for result in results:
        logs = logs + result.log_likelihood(bias, scatter)
    weights = np.exp(logs - logs.max())
    weights /= weights.sum()
    y = np.array([-2.1, -2.03, -1.9, -0.5, -0.1, 0.0, 0.1, 0.4])
    exact = [(weights * ndtr((ratio + bias) / scatter)).sum() for ratio in y]
    posterior = update(tuple(results), Prior())
    assert posterior.probability(y) == pytest.approx(exact, abs=1e-4)
    assert posterior.probability(np.array([posterior.level(0.05)])) == pytest.approx(0.05, abs=1e-9)


def test_without_tests_severe_wear_is_5_and_95_percent_probable_at_these_ratios():
    posterior = update((), Prior())
    assert [posterior.level(share) for share in (0.05, 0.95)] == pytest.approx(
        [-0.345, 0.345], abs=0.001
    )


def test_a_specimen_that_contradicts_itself_is_a_transition_as_uncertain_as_a_uniform_interval():
    """Mild up to 0.2 and severe from −0.1: at 0.05, with the variance 0.3²/12."""
    log_likelihood = Outcome(-0.1, 0.2).log_likelihood(np.array([0.02]), np.array([0.055]))
    variance = 0.055**2 + 0.3**2 / 12
    assert log_likelihood == pytest.approx(normal.logpdf(0.07, scale=math.sqrt(variance)), rel=1e-9)


def test_errors_are_0_at_points_and_continuous():
    specimen = field()
    f, v = (a.ravel() for a in np.meshgrid(LOADS, VELOCITIES, indexing="ij"))
    assert errors(specimen, f, v) == pytest.approx(0, abs=1e-12)
    inner = LOADS[1:-1]
    for offset in (-1e-12, 1e-12):
        nearby_errors = errors(specimen, inner * (1 + offset), np.full(3, 1.7))
        assert nearby_errors == pytest.approx(errors(specimen, inner, np.full(3, 1.7)), abs=1e-6)


def straight(slope=0.6):
    """A specimen of a power law, with three loads and three velocities half a unit apart."""
    loads, velocities = 400 * np.exp([0.0, 0.5, 1.0]), np.exp([0.0, 0.5, 1.0])
    y = 0.6 * np.log(loads)[:, None] + slope * np.log(velocities)
    unit = np.ones(y.shape)
    return merge_realizations(loads, velocities, y[None], 0.02 * unit, 0 * unit.astype(int), unit)


def test_the_bounds_between_points_are_these_numbers():
    """For a straight line: 0.1 gap²/8 for curvature, and 0.8 or 3 % of the gap for roughness."""
    x = np.array([0.0, 0.4, 0.8])
    within = math.hypot(0.1 * 0.4**2 / 8, 0.008 * 0.4)
    assert curve_errors(x, 0.6 * x, np.array([0.2, 0.6])) == pytest.approx([within] * 2, rel=1e-9)
    unseen = math.hypot(0.25 * 0.4**2 / 8, 0.008 * 0.4)  # two points show no curvature
    assert curve_errors(x[:2], 0.6 * x[:2], np.array([0.2])) == pytest.approx([unseen], rel=1e-9)
    specimen = straight()
    at = specimen.field.at(np.array([400 * math.exp(0.25)]), np.array([math.exp(0.5)]))
    along, between = interpolation_errors(specimen, at)
    assert between == pytest.approx([math.hypot(0.1 * 0.5**2 / 8, 0.03 * 0.5)], rel=1e-9)
    # The exponents 0.6 of load and of velocity are equal: so are the changes along a boundary.
    x = np.log(specimen.field.velocities)
    sides = curve_errors(x, 0.6 * x, np.array([0.75, 0.25]))
    assert along[:, 0] == pytest.approx(sides / 2, rel=1e-9)


@pytest.mark.parametrize(("spread", "least", "most"), [(0.0, 0.0095, 0.01), (0.02, 0.0, 0.001)])
def test_a_load_off_the_line_of_others_is_an_error_unless_its_realizations_scatter_so(
    spread, least, most
):
    """Eight realizations at five loads; the mean at the middle one is 1 % hotter than the line."""
    x, velocities = np.linspace(6.0, 6.4, 5), np.exp(np.linspace(0.0, 1.0, 41))
    lifts = np.random.default_rng(1).normal(0.0, spread, (8, 5))
    y = 0.6 * x + lifts - lifts.mean(axis=0) + [0.0, 0.0, 0.01, 0.0, 0.0]
    y = y[..., None] + 0.6 * np.log(velocities)
    unit = np.ones(y.shape[1:])
    specimen = merge_realizations(np.exp(x), velocities, y, 0 * unit, 0 * unit.astype(int), unit)
    at = specimen.field.at(np.exp(x[1:3] + 0.05), np.exp([0.5, 0.5]))
    _, between = interpolation_errors(specimen, at)
    assert ((least <= between) & (between <= most)).all()


@pytest.mark.parametrize(("slope", "factor"), [(0.8, 1.0), (0.5, 1.3), (0.25, 2.6), (0.1, 6.5)])
def test_the_error_by_a_preset_is_its_promise_or_that_of_the_rise_over_a_flatter_exponent(
    slope, factor
):
    specimen, at = straight(slope), (np.array([400.0]), np.array([math.exp(0.25)]))
    parts = rise_errors(specimen, 0.015, specimen.field.at(*at))
    assert parts[PRESET] == pytest.approx([0.65 * 0.015], rel=1e-9)
    preset_error = velocity_errors(specimen.field, parts, *at)[PRESET]
    assert preset_error == pytest.approx([0.015 * factor], rel=1e-6)


@pytest.mark.parametrize(("count", "least", "most"), [(1, 0.0015, 0.003), (4, 0.0, 0.0014)])
def test_a_velocity_off_the_line_is_an_error_unless_it_is_within_the_roughness_of_a_mean(
    count, least, most
):
    x = np.linspace(0.0, 0.4, 9)
    y = np.broadcast_to(0.6 * x + 0.8 * ROUGHNESS_DEVIATION * (x == x[4]), (count, 2, 9))
    unit = np.ones((2, 9))
    specimen = merge_realizations(LOADS[:2], np.exp(x), y, 0 * unit, 0 * unit.astype(int), unit)
    at = specimen.field.at(LOADS[:1], np.exp(x[3:4] + 0.025))
    along, _ = interpolation_errors(specimen, at)
    assert least <= along.sum() <= most


def test_the_error_by_present_heat_falls_with_the_duration_and_of_two_the_larger_counts():
    heat, few = int(WarningKind.PRESENT_HEAT), int(WarningKind.FEW_STEPS)  # 10 %
    flags, times = np.array([heat, heat, heat, heat | few, few, 0]), [1e-4, 1e-2, 1.0, 1.0, 1.0, 0]
    assert warned_errors(flags, np.array(times)).tolist() == [0.25, 0.11, 0.05, 0.1, 0.1, 0.0]
    durations = np.array([1e-3, 10**-2.5, 10**-1.5, 0.1])
    errors = warned_errors(np.full(4, heat), durations)
    assert errors.tolist() == pytest.approx([0.25, 0.18, 0.08, 0.05])


# How further points change the stated errors, on random planes


def random_plane(seed, bend=0.07, rough=0.001):
    """ln(rise/limit) of a random plane, no more bent and rough than `BENT` and `ROUGH` say."""
    rng = np.random.default_rng(seed)
    loads = np.sort(rng.uniform(100, 1000, rng.integers(4, 13)))
    velocities = np.sort(rng.uniform(0.2, 6, rng.integers(5, 20)))
    x, f = np.log(velocities / 1.5), np.log(loads / 400)[:, None]
    y = 0.58 * f + rng.uniform(0.4, 0.9) * x + rng.uniform(-bend, bend) * x**2
    return loads, velocities, y + rng.normal(0, rough, y.shape), rng


def specimen_of(loads, velocities, y, known):
    unit = np.ones(y.shape)
    ln_rise = np.where(known, np.log(1200.0) + y, np.nan)
    return merge_realizations(
        loads, velocities, ln_rise[None], 0.02 * unit, 0 * unit.astype(int), unit
    )


def with_one_more(seeds):
    """Yield a load of random planes before and after a point within, and its velocity."""
    for seed in seeds:
        loads, velocities, y, rng = random_plane(seed)
        known = rng.uniform(size=velocities.shape) < rng.uniform(0.3, 0.9)
        known[rng.choice(len(velocities), 2, replace=False)] = True
        free = [j for j in np.flatnonzero(~known).tolist() if known[:j].any() and known[j:].any()]
        if free:
            more, j = known.copy(), free[rng.integers(len(free))]
            more[j] = True
            row = loads[:1], velocities, y[:1]
            yield *(specimen_of(*row, is_known[None]) for is_known in (known, more)), velocities[j]


def bound_at(specimen, velocities):
    return errors(specimen, np.full(len(velocities), specimen.field.loads[0]), velocities)


def test_a_point_within_or_beyond_the_bound_stated_there_changes_it_little_or_to_its_distance():
    """A point within the bound rarely raises it by over 10 %; one beyond it raises both sides."""
    ratios, beyond = [], 0
    for before, after, velocity in with_one_more(range(150)):
        at, point = np.array([velocity]), (before.field.loads, np.array([velocity]))
        off = abs(before.field(*point)[0] - after.field(*point)[0])
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


def test_a_plane_beyond_the_bounds_is_told_so():
    loads, velocities, y, _ = random_plane(3)
    steep = y + 3 * np.log(velocities) ** 2
    middle = np.sqrt(velocities[:1] * velocities[1])
    usual, bent = (
        errors(specimen_of(loads, velocities, ln_rise, np.ones(y.shape, bool)), loads[:1], middle)
        for ln_rise in (y, steep)
    )
    assert bent[0] > 2 * usual[0]
