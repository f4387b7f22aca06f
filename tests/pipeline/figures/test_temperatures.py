"""Temperatures at the transition itself (pipeline/figures/ramp.py)."""

import numpy as np
import pytest

from pipeline.analysis.boundary import boundary
from pipeline.figures.plot import plot
from tests.helpers import synthetic


@pytest.fixture(scope="module")
def sweep():
    return synthetic.sweep(loads=(200.0, 400.0, 750.0), velocities=(0.5, 1.0, 2.0, 4.0))


def test_the_temperature_crosses_the_critical_one_at_the_transition(sweep):
    axes = plot(sweep, "temperature", load="400 N").axes[0]
    named = {line.get_label(): line for line in axes.lines}
    (label,) = (name for name in named if name.startswith("transition"))
    expected = float(boundary(sweep).sel(load=400.0)["critical_velocity"])
    time = named[label].get_xdata()[0]
    assert time == pytest.approx(expected)
    curves = (line for line in axes.lines if len(line.get_xdata()) == 200)
    exceeded = next(line for line in curves if line.get_ls() == "-")
    assert np.interp(time, *exceeded.get_data()) == pytest.approx(145.0, abs=0.2)
