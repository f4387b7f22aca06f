"""The likelihood of tests, beside a quadrature over bias and scatter, and the published table."""

import itertools
import math

import numpy as np
import pytest
from scipy.stats import norm, t

from pipeline.analysis.likelihood import Prior, SpecimenResult, condition

INF = math.inf
PLACES = np.array([-0.3, -0.1, 0.0, 0.1, 0.3])
# Probabilities [%] of severe wear at PLACES (PHYSICS 20): one row for each set of tests.
TABLE = {
    "none": ([], (0.7, 14, 50, 86, 99.3)),
    "20 mild far off": ([SpecimenResult(-1.0, sign=-1)] * 20, (0.7, 14, 50, 86, 99.3)),
    "20 mild near": ([SpecimenResult(-0.05, sign=-1)] * 20, (0, 0.4, 13, 66, 99)),
    "one severe": ([SpecimenResult(-0.3)], (30, 65, 78, 88, 97)),
    "one severe, farther": ([SpecimenResult(-0.75)], (57, 67, 73, 78, 86)),
    "two severe": ([SpecimenResult(-0.3)] * 2, (65, 89, 93, 95, 98)),
    "one severe, 20 mild": (
        [SpecimenResult(-0.3), *[SpecimenResult(-0.3, sign=-1)] * 20],
        (3, 40, 66, 85, 98),
    ),
    "one of each": ([SpecimenResult(-0.3), SpecimenResult(0.3, sign=-1)], (17, 37, 50, 64, 83)),
    "20 severe just below": (
        [SpecimenResult(float(y)) for y in np.linspace(-0.02, 0.0, 20)],
        (5, 67, 98, 100, 100),
    ),
}


@pytest.mark.parametrize("name", TABLE)
def test_sets_of_tests_have_the_published_probabilities(name):
    results, wanted = TABLE[name]
    found = 100 * condition(tuple(results), Prior()).probability(PLACES)
    assert found == pytest.approx(wanted, abs=0.7)


def by_quadrature(results, places, prior):
    """Probabilities at places, by a sum over the bias and the scatter; the results are exact."""
    bias = prior.bias * t.ppf((np.arange(1000) + 0.5) / 1000, 4)
    scatter = np.exp(np.linspace(math.log(0.1 * prior.scatter), math.log(50.0), 300))
    weight = scatter**-4 * np.exp(-4 * prior.scatter**2 / (2 * scatter**2))
    b, s = bias[:, None], scatter
    for one in results:
        width = np.hypot(s, one.own)
        if one.width < 1e-3:
            weight = weight * norm.pdf((one.y + b) / width) / width
            continue
        high = norm.cdf(one.sign * (one.y + b) / width)
        low = norm.cdf((one.sign * (one.y + b) - one.width) / width) if one.width < INF else 0.0
        weight = weight * (high - low)
    weight = weight * np.ones_like(b)
    shares = [np.sum(weight * norm.cdf((y + b) / s)) for y in places]
    return np.array(shares) / weight.sum()


SETS = [
    [SpecimenResult(0.1)],
    [SpecimenResult(-0.1), SpecimenResult(0.05, sign=-1)],
    [SpecimenResult(0.05, width=0.2), SpecimenResult(-0.04, width=0.1)],
    [SpecimenResult(0.03, width=0.0), SpecimenResult(-0.06, width=0.0), SpecimenResult(0.08)],
    [SpecimenResult(-0.05, width=0.0, own=0.1), SpecimenResult(0.02, sign=-1)],
]


@pytest.mark.parametrize("results", SETS)
def test_probabilities_are_those_of_a_quadrature(results):
    found = condition(tuple(results), Prior()).probability(PLACES)
    assert found == pytest.approx(by_quadrature(results, PLACES, Prior()), abs=0.01)


def test_a_slip_three_decades_off_leaves_the_plane_open():
    found = condition((SpecimenResult(-5.0),), Prior()).probability([-0.5, 0.5])
    assert found == pytest.approx([0.66, 0.74], abs=0.02)


@pytest.mark.parametrize("seed", range(12))
def test_a_severe_test_makes_no_easier_place_less_likely_severe(seed):
    draw = np.random.default_rng(seed)
    before = tuple(
        SpecimenResult(float(y), sign=int(sign))
        for y, sign in zip(draw.normal(0, 0.2, 4), draw.choice([-1, 1], 4), strict=True)
    )
    place = float(draw.normal(0, 0.2))
    easier = place - np.array([0.0, 0.05, 0.2, 0.5])
    plain = condition(before, Prior()).probability(easier)
    after = condition((*before, SpecimenResult(place)), Prior()).probability(easier)
    assert np.all(after >= plain - 0.02)


def test_probabilities_rise_with_y_and_are_never_unknown():
    places = np.array([-INF, -60.0, -1.0, 0.0, 1.0, 60.0, INF])
    kinds = [
        SpecimenResult(20.0),
        SpecimenResult(-20.0),
        SpecimenResult(20.0, sign=-1),
        SpecimenResult(0.3, width=0.0),
    ]
    for some in itertools.combinations(kinds, 2):
        found = condition(some, Prior()).probability(places)
        assert np.isfinite(found).all()
        assert np.all(np.diff(found) >= 0)
        assert found[[0, -1]] == pytest.approx([0.0, 1.0], abs=1e-12)


def test_a_place_is_as_likely_as_its_level_says():
    belief = condition((SpecimenResult(-0.1),), Prior())
    for share in (0.05, 0.5, 0.95):
        assert belief.probability(belief.level(share)) == pytest.approx(share, abs=1e-9)


def test_each_result_is_expected_as_by_the_others_alone():
    results = (SpecimenResult(-0.2), SpecimenResult(-0.1, sign=-1), SpecimenResult(0.05, width=0.0))
    found = condition(results, Prior()).expected
    others = condition(results[1:], Prior()).probability(-0.2)
    assert found[0] == pytest.approx(float(others), abs=0.01)
    severe = float(condition((results[0], results[1]), Prior()).probability(0.05))
    assert found[2] == pytest.approx(2 * min(severe, 1 - severe), abs=0.02)


def test_a_prior_of_no_bias_leaves_the_scatter():
    found = condition((), Prior(bias=0.0, scatter=0.1)).probability(PLACES)
    assert found == pytest.approx(t.cdf(PLACES / 0.1, 4), abs=0.002)
