"""What `irg infer` says beside the inputs, on a rise that is known in closed form."""

import numpy as np
import pytest

import pipeline
from pipeline.cli.weighed import _on_inputs
from tests.helpers.samples import CRITICAL, LENGTH, LOADS, critical_velocity, ensemble, fewer_draws

TRUTH = np.array([[418.15, 1.2e-15, 0.1, 4.5e-6]])
CAUTION = "velocities that are all read too high would look like a better oil, and fit as well"


@pytest.fixture(autouse=True)
def _fewer_draws(monkeypatch):
    fewer_draws(monkeypatch)


def weighed(*factors):
    """The posterior of a rig whose velocities are read too high by some factors, by load."""
    tests = [
        {
            "normal_load": load,
            "velocity": float(critical_velocity(TRUTH, load)[0] * factor),
            "friction": 0.1,
        }
        for load, factor in zip(LOADS.tolist(), factors, strict=True)
    ]
    return pipeline.posterior(ensemble((CRITICAL, LENGTH), tests=tests))


def said(posterior):
    return "\n".join(map(str, _on_inputs(posterior)))


def test_velocities_all_read_too_high_fit_like_a_better_oil_and_a_fit_says_so():
    sound, high = weighed(1.0, 1.0, 1.0), weighed(1.08, 1.08, 1.08)
    assert sound.fits
    assert high.fits
    better, as_it_is = (next(one.summary())["posterior"]["mean"] for one in (high, sound))
    of_all = 0.7 * np.log(1.08) * (TRUTH[0, 0] - 298.15)  # without a prior
    assert better - as_it_is == pytest.approx(of_all, rel=0.4)
    assert CAUTION in said(sound)
    assert CAUTION in said(high)


def test_nothing_of_the_kind_is_said_of_a_misfit():
    misfit = weighed(0.6, 1.0, 1.6)
    assert not misfit.fits
    assert CAUTION not in said(misfit)
