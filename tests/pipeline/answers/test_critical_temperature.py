"""The critical temperature from tests, compared with a sum over all parameters on a grid."""

import math

import numpy as np
import pytest
import xarray as xr
from scipy.special import log_ndtr, ndtr
from scipy.stats import t as student

import pipeline
from pipeline.answers.posterior import Prior, update
from pipeline.store.schema import DONE, PENDING
from tests.helpers import synthetic
from tests.helpers.answer_at import named
from tests.helpers.entries import bare_test

POINTS = [(300.0, 1.2), (400.0, 2.0), (600.0, 2.6)]
BULK, WARM = 298.15, 343.15


def swept(*tests, critical=None, **options):
    conditions = {"friction": 0.1, "bulk_temperature": BULK, "critical_temperature": critical}
    return synthetic.sweep(
        (200.0, 400.0, 750.0), (0.5, 1.0, 2.0, 4.0), tests=tests, conditions=conditions,
        critical_from_tests=critical is None, **options,
    )  # fmt: skip


def heat(load, velocity):
    """Temperature rise at a friction of 0.1 [K]."""
    return 0.1 * float(synthetic.rise(load, velocity, 0.9))


def brute_force(tests, points, bias=0.15, scatter=0.055):
    """Median critical temperature without bias, spread with bias [K], and probabilities at points.

    Points are (load, velocity, bulk temperature).
    """
    u, w = np.linspace(-3, 3, 361)[:, None, None], np.linspace(-6.5, 6.5, 91)[:, None]
    b = bias * np.sinh(w)
    v = np.linspace(math.log(0.008), math.log(6), 40)
    critical, s = BULK + 120 * np.exp(u), np.exp(v)
    logs = student.logpdf(u, 4) - 4 * v - 2 * scatter**2 / s**2

    def y(load, velocity, bulk):
        above = np.maximum(critical - bulk, 1e-9)
        return math.log(heat(load, velocity)) - np.log(above)

    def likelihood(bias):
        log_likelihood = logs + 0 * bias
        for load, velocity, bulk, outcome in tests:
            x = (y(load, velocity, bulk) + bias) / s
            log_probability = {"severe": log_ndtr, "mild": lambda x: log_ndtr(-x)}.get(outcome)
            log_likelihood = log_likelihood + (
                log_probability(x) if log_probability else -(x**2) / 2 - np.log(s)
            )
        return log_likelihood

    def weights_of(logs):
        weights = np.exp(logs - logs.max())
        return weights / weights.sum()

    temperature_weights = weights_of(likelihood(0.0)).sum(axis=(1, 2))
    weights = weights_of(likelihood(b) + student.logpdf(np.sinh(w), 4) + np.log(np.cosh(w)))
    middle = np.interp(0.5, np.cumsum(temperature_weights) - temperature_weights / 2, u[:, 0, 0])
    posterior = weights.sum(axis=(1, 2))
    spread = math.sqrt(posterior @ np.square(u[:, 0, 0] - posterior @ u[:, 0, 0]))
    is_relevant = weights > 1e-12
    chances = [
        float((weights[is_relevant] * ndtr(((y(*point) + b) / s)[is_relevant])).sum())
        for point in points
    ]
    return BULK + 120 * math.exp(middle), 120 * math.exp(middle) * spread, chances


CASES = {
    "a bracket": [(400.0, 1.2, BULK, "mild"), (400.0, 1.9, BULK, "severe")],
    "transitions": [(300.0, 2.0, BULK, "transition"), (500.0, 1.6, BULK, "transition")],
    "another bulk temperature": [
        (400.0, 0.8, WARM, "mild"), (400.0, 1.4, WARM, "severe"),
    ],
    "two bulk temperatures": [
        (300.0, 2.0, BULK, "transition"), (500.0, 0.9, WARM, "transition"),
        (400.0, 0.6, WARM, "mild"),
    ],
    "two transitions, warm": [
        (300.0, 1.4, WARM, "transition"), (500.0, 1.0, WARM, "transition"),
    ],
}  # fmt: skip


@pytest.mark.parametrize("case", CASES)
def test_it_and_all_probabilities_are_those_of_brute_force(case):
    tests = CASES[case]
    specimen_tests = [
        bare_test(load, velocity, outcome=outcome, bulk_temperature=bulk)
        for load, velocity, bulk, outcome in tests
    ]
    ds = swept(*specimen_tests)
    bulks = (BULK, 320.0) if case == "a bracket" else np.linspace(312.0, 320.0, 4)  # between nodes
    points = [(*point, float(bulk)) for point in POINTS for bulk in bulks]
    critical, spread, chances = brute_force(tests, points)
    inference = pipeline.infer(ds)
    median = inference["critical_temperature"].item()
    assert median == pytest.approx(critical, abs=0.05)
    assert inference["spread_another_rig"].item() == pytest.approx(spread, rel=2e-3)
    loads, velocities, bulks = (
        xr.DataArray([*values], dims="place") for values in zip(*points, strict=True)
    )
    margin = pipeline.margin(ds, loads, velocities, bulk_temperature=bulks)
    assert margin["critical_temperature"].item() == pytest.approx(median, abs=1e-9)
    assert margin["probability"].values == pytest.approx(chances, abs=1e-5)


@pytest.mark.parametrize("celsius", [90.0, 145.0, 500.0])
def test_it_is_found_from_transitions_whatever_the_scene_says(celsius):
    """The limit of the rise is 900 K at four places: 90 K above the bulk temperature."""
    tests = [
        bare_test(load, float(synthetic.critical_velocity(load, 900.0)))
        for load in (200.0, 300.0, 400.0, 600.0)
    ]
    inference = pipeline.infer(swept(*tests, critical=273.15 + celsius))
    assert inference["critical_temperature"].item() == pytest.approx(BULK + 90.0, abs=1.0)
    assert np.isnan([inference["at_least"], inference["at_most"]]).all()
    spread = inference["spread_this_rig"].item()
    assert 2.0 < spread < 5.0
    bias = np.linspace(-30, 30, 60001)  # that and the critical temperature have Student's t
    weights = student.pdf(bias / 0.15, 4) * student.pdf(math.log(90 / 120) + bias, 4)
    of_bias = math.sqrt(np.average(np.square(bias), weights=weights))
    another = math.hypot(spread, 90.0 * of_bias)
    # to about 1 K in 90 K
    assert inference["spread_another_rig"].item() == pytest.approx(another, rel=0.01)


@pytest.mark.parametrize("outcome", ["mild", "severe"])
def test_tests_of_one_outcome_bound_it_on_one_side_and_decide_nothing(outcome):
    velocity = float(synthetic.critical_velocity(400.0, synthetic.limit()))
    test, known = bare_test(400.0, velocity, outcome=outcome), 273.15 + 145.0
    corners = pipeline.margin(swept(test), [200.0, 200.0, 750.0, 750.0], [0.5, 4.0, 0.5, 4.0])
    assert outcome not in named(corners["verdict"])
    inference = pipeline.infer(swept(test, critical=known))
    level = update((), Prior()).level(0.95)  # y at which a mild result has a probability of 5 %
    side, other, sign = ("at_least", "at_most", -1) if outcome == "mild" else (
        "at_most", "at_least", 1
    )  # fmt: skip
    bound = BULK + 120.0 * math.exp(sign * level)
    assert inference[side].item() == pytest.approx(bound, abs=1.0)  # of the grid of biases
    assert np.isnan(inference[other])


def test_while_a_test_waits_it_is_the_reason_and_not_that_no_test_was_severe():
    mild, waiting = bare_test(400.0, 1.2, outcome="mild"), bare_test(700.0, 4.0, outcome="severe")
    ds = synthetic.with_tests(swept(mild, waiting), status=[DONE, PENDING])
    answer = pipeline.margin(ds, 200.0, 0.5)
    assert answer["reason"].item().startswith("test 2 (severe, 700 N, 4 m/s) has not been simul")


def test_every_door_has_the_same_critical_temperature():
    ds = swept(bare_test(400.0, 1.2, outcome="mild"), bare_test(400.0, 1.9, outcome="severe"))
    critical = pipeline.infer(ds)["critical_temperature"].item()
    boundary = pipeline.boundary(ds)
    assert boundary["critical_temperature"].item() == pytest.approx(critical)
    statement = f"critical temperature {critical - 273.15:.4g} °C (median, from tests)"
    assert statement in boundary.attrs["conditions"]
    states = pipeline.points(ds)["state"].sel(load=400.0)[0]
    turns = pipeline.boundary(ds)["critical_velocity"].sel(load=400.0).item()
    assert ((states == "severe") == (states["velocity"] > turns)).all()
    failed = pipeline.temperatures(ds)["failed_area_fraction"].sel(load=400.0, step=0)
    assert ((failed > 0.1) == (failed["velocity"] > turns)).all()


@pytest.mark.parametrize(
    ("parts", "model"),
    [
        ({}, "a random surface, wear pattern swept, preset fine"),
        ({"roughness": None, "wear": None, "preset": None},
         "a smooth surface, no wear, custom numerical settings"),
    ],
)  # fmt: skip
def test_a_critical_temperature_names_the_surface_wear_and_preset_to_which_it_belongs(parts, model):
    inference = pipeline.infer(swept(bare_test(400.0, 2.0), **parts))
    assert inference.attrs["model"] == model
