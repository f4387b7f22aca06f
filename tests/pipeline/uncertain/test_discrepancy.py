"""Slopes that the model lacks, and what they gain in evidence, on a rise in closed form."""

import numpy as np
import pytest

import pipeline
from pipeline.sweep.unknown import Unknown
from tests.helpers.samples import EXPONENT, critical_velocity, ensemble
from tests.helpers.unknowns import CRITICAL

TRUTH = np.array([418.15, 1.2e-15, 0.1, 4.5e-6])
LOADS = (200.0, 400.0, 750.0) * 2
WIDE = Unknown(CRITICAL.path, "uniform", (383.15, 473.15), "K")


def logged(slope):
    """Transitions of a rig whose rise has another slope over the velocity than the model's."""
    chance = np.random.default_rng(1)
    for load in LOADS:
        log_velocity = np.log(critical_velocity(TRUTH[None], load)[0] / 3**0.5)
        velocity = 3**0.5 * np.exp(log_velocity * EXPONENT / (EXPONENT + slope))
        velocity *= np.exp(0.03 * chance.standard_normal())
        yield {"normal_load": load, "velocity": float(velocity), "friction": 0.1}


@pytest.mark.parametrize(("slope", "is_missing"), [(0.0, False), (-0.25, True)])
def test_a_discrepancy_gains_where_the_rise_has_another_slope(slope, is_missing):
    samples = ensemble((WIDE,), 16, tests=logged(slope))
    posterior = pipeline.posterior(samples, 0.05, discrepancy=True)
    assert (posterior.evidence_gain > 3) == is_missing
    assert posterior.evidence_gain > 3 or posterior.evidence_gain < 0
    plain = pipeline.posterior(samples, 0.05)
    assert posterior.unknown == plain.unknown  # it moves no input
    np.testing.assert_array_equal(posterior.draws.inputs, plain.draws.inputs)
    np.testing.assert_array_equal(posterior.draws.weights, plain.draws.weights)
