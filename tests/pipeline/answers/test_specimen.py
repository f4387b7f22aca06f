"""Several realizations of one specimen: their mean, missing points and surface sampling error."""

import math

import numpy as np
import pytest
import xarray as xr
from scipy.stats import t

import pipeline
from pipeline.answers.error import PARTS
from pipeline.answers.facts import fact_lines, point_lines
from pipeline.answers.specimen import mean_of_realizations
from pipeline.constants import CORRELATION_LENGTHS, RISE_EXPONENT
from pipeline.store.schema import FAILED, PENDING
from tests.helpers import synthetic
from tests.helpers.answer_at import asked
from tests.helpers.entries import bare_test
from tribo import QUANTILES, WarningKind

LIFTS = (1.0, 1.1, 0.9, 1.05, 0.97)
LOADS, VELOCITIES = (200.0, 400.0, 600.0), (0.5, 1.0, 2.0, 4.0)
HOTTEST_TENTH = QUANTILES.index(0.9)


def realizations(lifts=LIFTS, states=None, sampling=0.0, growth=0.0, **options):
    """Sweep of several realizations, hotter by the factors `lifts`; `states` sets the statuses."""
    sweeps = []
    for seed, lift in enumerate(lifts):
        dataset = synthetic.sweep(
            LOADS,
            VELOCITIES,
            rise=lambda F, V, q=1.0, k=lift, seed_offset=seed: (
                k * (F / 400.0) ** (growth * seed_offset) * synthetic.rise(F, V, q)
            ),
            status=(states or {}).get(seed),
            **{"tests": ()} | options,
        )
        deviations = np.full(dataset["rise_realization_std"].shape, sampling)
        dataset["rise_realization_std"] = dataset["rise_realization_std"].dims, deviations
        sweeps.append(dataset)
    seeds = xr.Variable("realization", np.arange(len(lifts)))
    return xr.concat(sweeps, seeds, coords="minimal", compat="override", combine_attrs="override")


def only(*points, state=PENDING):
    """Statuses of a realization that is done only at these points."""
    return {(F, V): state for F in LOADS for V in VELOCITIES if (F, V) not in points}


def factor(ds, **conditions):
    """Rise of the specimen at each load over that of the closed form, from its boundary."""
    critical_velocity = pipeline.boundary(ds, **conditions)["critical_velocity"].values
    share = 0.0 if conditions else 0.1
    closed_form = synthetic.critical_velocity(np.array(LOADS), synthetic.limit(), share)
    return (closed_form / critical_velocity) ** synthetic.VELOCITY_EXPONENT


def mean(lifts):
    return math.exp(np.log(lifts).mean())


def sparse():
    """Realizations of which only the first has several points at a load."""
    points = [(F, 2.0) for F in LOADS]
    return realizations(states={k: only(*points) for k in range(1, len(LIFTS))})


def growing(*loads):
    """Two realizations; the second rises faster with load, and has one point at these loads."""
    return realizations((1.0, 1.1), {1: only(*((F, 2.0) for F in loads))}, growth=0.2)


NO_400 = {0: {(400.0, V): PENDING for V in VELOCITIES}}
FAILED_THERE = {3: {(600.0, 4.0): FAILED}}
GROWING = np.sqrt(1.1 * (np.array(LOADS) / 400.0) ** 0.2).tolist()
SPECIMENS = {  # sweep, and ratio of its rise at each load to the closed form
    "the mean of realizations": (realizations, mean(LIFTS)),
    "a point a load tells of all velocities": (sparse, mean(LIFTS)),
    "a load between loads of several": (lambda: growing(200.0, 600.0), GROWING),
    "beyond the loads of several": (lambda: growing(400.0, 600.0), [1.0, *GROWING[1:]]),
    "a load that the first lacks": (lambda: realizations((1, 1.1), NO_400), math.sqrt(1.1)),
    "a first without a point": (lambda: realizations(states={0: only()}), mean(LIFTS[1:])),
    "one alone": (lambda: realizations().sel(realization=[2]), [np.nan, LIFTS[2], LIFTS[2]]),
    "one failed at a point": (lambda: realizations(states=FAILED_THERE), mean(LIFTS)),
}


@pytest.mark.parametrize("name", SPECIMENS)
def test_a_boundary_is_that_of_the_mean_of_realizations(name):
    make, expected = SPECIMENS[name]
    np.testing.assert_allclose(factor(make()), np.broadcast_to(expected, 3), rtol=1e-12)


def test_where_the_highest_temperature_decides_the_hottest_realization_does():
    factors = factor(realizations(), critical_area_fraction=0.0)
    np.testing.assert_allclose(factors, max(LIFTS), rtol=1e-12)


def test_at_a_load_without_a_point_realizations_differ_as_at_the_loads_beside():
    lacks_400 = realizations((1.0, 1.1), {k: only((200.0, 2.0), (600.0, 2.0)) for k in (0, 1)})
    margin = asked(lacks_400, 400.0, 2.0)
    nearby_margin = asked(lacks_400, 200.0, 2.0)
    assert margin.realizations == nearby_margin.realizations == 2


def test_a_failed_realization_stays_where_it_alone_has_points():
    sparse = {k: only((400.0, 2.0)) for k in range(1, len(LIFTS))}
    first_failed = realizations(states=sparse | {0: {(600.0, 4.0): FAILED}})
    assert asked(first_failed, 400.0, 2.0).realizations == len(LIFTS)


@pytest.mark.parametrize("count", [1, 2, 5])
def test_the_surface_is_a_bound_by_the_realizations_own_estimates_and_their_spread(count):
    margin = asked(realizations(LIFTS[:count], sampling=0.03), 400.0, 2.0)
    levels = np.log(LIFTS[:count])
    spread = np.sum((levels - levels.mean()) ** 2)
    scale = (7 + spread / 0.03**2) / (6 + count)  # equal at all loads
    deviation = math.sqrt((7 * scale * 0.03**2 + spread) / (6 + count))
    expected = t(6 + count).ppf(0.975) * deviation / math.sqrt(count)
    rise = margin.governing_temperature - synthetic.CONDITIONS["bulk_temperature"]
    assert margin.temperature_error_surface / rise == pytest.approx(expected, rel=1e-12)
    parts = [getattr(margin, f"temperature_error_{part}") for part in PARTS]
    assert margin.temperature_error == pytest.approx(math.hypot(*parts), rel=1e-12)


def test_loads_share_their_realizations_and_the_ratio_of_spread_to_what_these_state():
    """The two realizations at 400 N are hotter than the mean of the five at 200 N."""
    levels = np.array([0.075, 0.025, -0.025, -0.075, 0.0])
    sparse = {k: only(*((200.0, V) for V in VELOCITIES)) for k in range(2, 5)}
    ds = realizations(np.exp(levels), sparse, sampling=0.03)
    is_high = (ds["load"] > 200.0).drop_attrs()
    stored_std = ds["rise_realization_std"]
    ds["rise_realization_std"] = (stored_std / (1 + 2 * is_high)).assign_attrs(stored_std.attrs)
    spread = np.array([np.square(levels).sum(), 0.05**2 / 2])
    stated = np.array([0.03, 0.01, 0.01])
    ratios = spread / np.square(stated[:2])
    scale = (7 + 4 * (ratios[0] + 2 * ratios[1]) / 6) / 11  # 400 and 600 N count as one load
    degrees = 7 + np.array([4, 1, 1])
    deviations = np.sqrt((7 * scale * np.square(stated) + spread[[0, 1, 1]]) / degrees)
    known = np.array([[True, k < 2, k < 2] for k in range(5)])
    means, variances = least_squares(levels[:, None] / deviations, known)
    bounds = t(degrees).ppf(0.975) * deviations * np.sqrt(variances)
    for load, expected in zip(LOADS, bounds, strict=True):
        margin = asked(ds, load, 2.0)
        rise = margin.governing_temperature - synthetic.CONDITIONS["bulk_temperature"]
        assert margin.temperature_error_surface / rise == pytest.approx(expected, rel=1e-9)
    np.testing.assert_allclose(factor(ds), np.exp(deviations * means), rtol=1e-9)
    assert 0 < np.log(factor(ds)[1]) < 0.05  # between the mean of all and that of two


def least_squares(values, known):
    """Mean at each load and its variance, by one covariance matrix of all values."""
    realization, load = np.nonzero(known)
    design, y = np.eye(known.shape[1])[load], values[realization, load]
    x = np.log(LOADS)[load]

    def fit(covariance):
        weighted = np.linalg.solve(covariance, design)
        variance = np.linalg.inv(design.T @ weighted)
        mean = variance @ weighted.T @ y
        residuals = y - design @ mean
        freedom = len(y) - len(mean)
        squares = residuals @ np.linalg.solve(covariance, residuals) / freedom
        determinants = np.linalg.det(covariance) * np.linalg.det(design.T @ weighted)
        return mean, np.diag(variance), squares ** (-freedom / 2) / math.sqrt(determinants)

    is_same = realization[:, None] == realization
    covariances = [
        np.where(is_same, np.exp(-np.abs(x[:, None] - x) / length), 0.0)
        for length in CORRELATION_LENGTHS
    ]
    weights = np.array([fit(covariance)[2] for covariance in covariances])
    return fit(np.tensordot(weights / weights.sum(), covariances, 1))[:2]


@pytest.mark.parametrize("correlation", [0.0, 0.65, 0.9])
@pytest.mark.parametrize("counts", [(16, 4, 4, 2, 2), (8, 2, 2)])
def test_means_at_loads_of_few_realizations_keep_their_bounds(counts, correlation):
    """Of 120 specimens, 95 % by the stated bound, at each load of few realizations."""
    generator, trials = np.random.default_rng(3), 120
    loads = np.geomspace(200, 750, len(counts))
    distance = np.abs(np.subtract.outer(np.log(loads), np.log(loads))) / np.log(3.75)
    matrix = correlation**distance if correlation else np.eye(len(loads))
    deviations, held = np.geomspace(0.022, 0.0068, len(loads)), np.zeros(len(loads))
    for _ in range(trials):
        normal = generator.standard_normal((max(counts), len(loads)))
        levels = normal @ np.linalg.cholesky(matrix).T * deviations
        differences = levels - levels[0]
        differences[np.arange(max(counts))[:, None] >= np.array(counts)] = np.nan
        sampling = [np.sqrt(np.mean(generator.chisquare(7, count)) / 7) for count in counts]
        stated = (deviations * sampling)[:, None]
        freedom = np.full(len(loads), 7.0)
        mean = mean_of_realizations(loads, differences[..., None], stated, freedom, False)
        held += np.abs(mean.offset[:, 0] + levels[0]) <= mean.bound[:, 0]
    assert held.min() >= 0.89 * trials  # 0.95 less three standard deviations of a count
    assert held.mean() >= 0.925 * trials


@pytest.mark.parametrize("freedom", [1.0, 3.3])
def test_the_fewer_degrees_of_freedom_a_realization_has_the_more_others_count(freedom):
    def bound_of(lifts, stated, freedom):
        differences = np.subtract(lifts, lifts[0])[:, None, None]
        arguments = np.full((1, 1), stated), np.array([freedom]), False
        return mean_of_realizations(np.array([200.0]), differences, *arguments).bound.item()

    single_bound = bound_of([0.0], 0.02, freedom)
    assert single_bound == pytest.approx(t(freedom).ppf(0.975) * 0.02, rel=1e-12)
    lifts = 0.06 * math.sqrt(15 / 16) * np.tile([1.0, -1.0], 8)  # realizations that differ by 6 %
    squares = 15 * 0.06**2
    # The stated deviation is first scaled to the spread of the realizations.
    scaled = (freedom * 0.01**2 + squares) / (freedom + 15)
    deviation = math.sqrt((freedom * scaled + squares) / (freedom + 15))
    expected = t(freedom + 15).ppf(0.975) * deviation / 4
    bound = bound_of(lifts, 0.01, freedom)
    assert bound == pytest.approx(expected, rel=1e-12)
    assert bound > bound_of(lifts, 0.01, 7.0)


def without_deviations(lifts, **options):
    """Realizations of which a single one does not state how realizations differ."""
    ds = realizations(lifts, sampling=np.inf, **options)
    return ds.assign(rise_realization_freedom=0.0 * ds["rise_realization_freedom"].drop_attrs())


@pytest.mark.parametrize("velocity", [0.6, 3.9])
def test_no_verdict_rests_on_a_single_realization_that_does_not_state_how_others_differ(velocity):
    known, unknown = realizations((1.0,), sampling=0.01), without_deviations((1.0,))
    assert asked(known, 400.0, velocity).verdict == ("mild" if velocity < 1 else "severe")
    answer = asked(unknown, 400.0, velocity)
    assert answer.verdict == "undecided"
    assert (answer.probability_low, answer.probability_high) == (0.0, 1.0)
    assert np.isnan([answer.temperature_error, answer.temperature_error_surface]).all()
    text = "\n".join(point_lines(answer.answer))
    assert "unknown, because a part is unknown: surface sampling" in text
    assert "to decide it, simulate more surface realizations" in text
    boundary = pipeline.boundary(unknown)
    for name in ("velocity_error", "mild_velocity", "severe_velocity"):
        assert boundary[name].isnull().all()
    assert boundary["critical_velocity"].notnull().all()
    assert fact_lines(boundary, "numerical error (95 %)") == [
        "numerical error (95 %): unknown at 3 of 3, because a part is unknown: surface sampling "
        "(one surface realization has too few independent grooves; simulate several, "
        "sweep.realizations)"
    ]


def test_two_realizations_that_state_nothing_have_the_error_of_their_difference():
    margin = asked(without_deviations((1.0, 1.02)), 400.0, 0.6)
    assert margin.verdict == "mild"
    deviation = math.log(1.02) / math.sqrt(2)
    rise = margin.governing_temperature - synthetic.CONDITIONS["bulk_temperature"]
    expected = t(1).ppf(0.975) * deviation / math.sqrt(2)
    assert margin.temperature_error_surface / rise == pytest.approx(expected, rel=1e-9)


def test_the_boundary_states_its_error_and_the_part_of_the_surface():
    ds = realizations(sampling=0.03)
    boundary = pipeline.boundary(ds).sel(load=400.0)
    margin = asked(ds, 400.0, boundary["critical_velocity"].item())
    rise = margin.governing_temperature - synthetic.CONDITIONS["bulk_temperature"]
    parts = np.array([getattr(margin, f"temperature_error_{part}") for part in PARTS])
    parts = parts / rise / synthetic.VELOCITY_EXPONENT
    parts[1] = margin.temperature_error_discretization / rise / RISE_EXPONENT
    assert boundary["velocity_error_surface"].item() == pytest.approx(parts[4], rel=1e-9)
    assert boundary["velocity_error"].item() == pytest.approx(math.hypot(*parts), rel=1e-9)


def test_the_highest_of_realizations_is_as_uncertain_as_one_of_them():
    relative = []
    for share in (0.1, 0.0):
        margin = asked(realizations(), 400.0, 2.0, critical_area_fraction=share)
        relative.append(margin.temperature_error_surface / (margin.governing_temperature - 298.15))
    assert relative[1] / relative[0] == pytest.approx(math.sqrt(len(LIFTS)), rel=1e-9)


def test_a_test_is_computed_on_the_first_realization_and_stands_on_the_level_of_the_specimen():
    tests = {"tests": (bare_test(400.0, 2.0),)}
    several = realizations((1.0, 1.21), **tests)
    hotter = realizations((1.1,), **tests)
    both = [asked(ds, 600.0, 1.5).probability for ds in (several, hotter)]
    assert both[0] == pytest.approx(both[1], rel=1e-9)
    plain = asked(realizations((1.0,), **tests), 600.0, 1.5, friction=0.11).probability
    assert both[0] != pytest.approx(plain, rel=1e-2)


def test_the_specimen_of_realizations_that_differ_a_lot_is_decided_by_more_realizations():
    margin = asked(realizations((1.0, 1.4), sampling=0.1), 400.0, 1.9)
    assert margin.verdict == "undecided"
    assert margin.temperature_error_surface == max(
        getattr(margin, f"temperature_error_{part}") for part in PARTS
    )


def test_points_at_far_velocities_leave_the_surface_part_of_an_error_as_it_is():
    ds = synthetic.sweep()
    rough = 0.02 + 0.06 * (ds["velocity"] > 2.5)  # stated by the points themselves
    ds = ds.assign(rise_realization_std=(ds["rise_realization_std"] + rough).drop_attrs())
    few = ds.isel(velocity=ds["velocity"].values <= 2.0)
    parts = [asked(dataset, 425.0, 1.2).temperature_error_surface for dataset in (few, ds)]
    assert parts[0] == pytest.approx(parts[1], rel=1e-12)
    assert asked(ds, 425.0, 3.2).temperature_error_surface > 2 * parts[0]


def test_an_error_that_one_realization_does_not_know_decides_nothing():
    ds = synthetic.sweep(tests=(), preset="standard")
    too_wide = ds.copy(deep=True)
    too_wide["warning_flags"][:] = int(WarningKind.BEYOND_SHAPE)
    assert asked(ds, 400.0, 0.75).verdict == "mild"
    for surfaces in ([ds, too_wide], [too_wide, ds]):
        both = xr.concat(surfaces, xr.Variable("realization", range(2)), combine_attrs="override")
        margin = asked(both, 400.0, 0.75)
        assert np.isnan(margin.temperature_error)
        assert margin.verdict == "undecided"
