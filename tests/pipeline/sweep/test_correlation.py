"""Unknown inputs that are correlated keep their distributions, and their samples."""

import math

import numpy as np
import pytest
from scipy.stats import kstest, spearmanr

from pipeline.uncertain.unknown import Unknown, correlations, drawn, first_unfit
from tests.helpers.unknowns import CRITICAL, FRICTION, LENGTH, RATE, distribution_of


def joined(entry, **correlations):
    """Copy of an unknown input that is correlated with others, by the last part of their path."""
    paths = {other.path.rpartition(".")[2]: other.path for other in (CRITICAL, RATE, FRICTION)}
    pairs = tuple((paths[name], number) for name, number in correlations.items())
    return Unknown(entry.path, entry.kind, entry.parameters, entry.unit, correlated=pairs)


PAIRS = (
    CRITICAL,
    joined(RATE, critical=0.6),
    FRICTION,
    joined(LENGTH, critical=-0.3, specific_wear_rate=-0.8, coefficient=0.4),
)
LIST = Unknown("disk.roughness.seed", "list", (0.0, 1.0, 2.0))


def test_ranks_are_correlated_as_normal_scores_of_that_correlation_are():
    correlation = spearmanr(drawn(PAIRS, 0, 2**15)).statistic
    expected = 6 / math.pi * np.arcsin(correlations(PAIRS) / 2)
    assert correlation == pytest.approx(expected, abs=0.005)


def test_values_are_correlated_on_the_scales_on_which_they_are_normal():
    values = drawn(PAIRS, 0, 2**15)
    assert np.corrcoef(values[:, 0], np.log(values[:, 1]))[0, 1] == pytest.approx(0.6, abs=0.003)


@pytest.mark.parametrize("number", range(4))
def test_each_keeps_its_own_distribution(number):
    values = drawn(PAIRS, 3, 2**12)[:, number]
    # Random points would exceed 0.02 in 5 % of cases; these points are more even.
    assert kstest(values, distribution_of(PAIRS[number]).cdf).statistic < 0.01


def test_what_is_correlated_with_nothing_before_it_is_drawn_as_if_it_were_alone():
    alone = drawn((CRITICAL, RATE, FRICTION, LENGTH, LIST), 2, 64)
    joint = drawn((*PAIRS, LIST), 2, 64)
    same = np.isclose(alone, joint, rtol=1e-12, atol=0.0).all(axis=0)
    assert same.tolist() == [True, False, True, False, True]


@pytest.mark.parametrize("last", [-0.5, 0.0, 0.99])
def test_the_first_unfit_input_is_the_one_that_makes_the_matrix_no_correlation(last):
    matrix = np.array([[1.0, 0.8, last], [0.8, 1.0, 0.5], [last, 0.5, 1.0]])
    # For three inputs: r₁₃ is within r₁₂ r₂₃ ± √((1 − r₁₂²)(1 − r₂₃²)).
    half = math.sqrt((1 - 0.8**2) * (1 - 0.5**2))
    is_fit = abs(last - 0.4) < half
    assert (np.linalg.eigvalsh(matrix).min() > 0) == is_fit
    assert first_unfit(matrix) == (None if is_fit else 2)
