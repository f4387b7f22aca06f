"""Temperatures at the transition itself (pipeline/figures/temperatures.py)."""

import numpy as np
import pytest

from pipeline.analysis.boundary import boundary
from pipeline.figures.plot import plot
from tests.helpers import synthetic
from tribo import InputError


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


def test_at_the_transition_just_the_failing_share_is_above_the_critical_temperature(sweep):
    axes = plot(sweep, "histogram", load=400.0).axes[0]
    assert "10 % above 145 °C" in [text.get_text() for text in axes.figure.legends[0].get_texts()]
    assert "at the transition" in axes.get_title()
    assert sum(bar.get_height() for bar in axes.patches) == pytest.approx(100.0)


def test_a_velocity_between_the_points_is_interpolated_and_one_beyond_refused(sweep):
    def share(velocity):
        figure = plot(sweep, "histogram", load=400.0, velocity=velocity)
        words = [text.get_text() for text in figure.legends[0].get_texts()]
        return float(next(word for word in words if " % above" in word).split(" %")[0])

    assert share(2.0) < share("2.5 m/s") < share(4.0)
    with pytest.raises(InputError, match=r"from 0\.5 to 4 m/s at most"):
        plot(sweep, "histogram", load=400.0, velocity=9.0)
    with pytest.raises(InputError, match="no transition at 400 N; give a velocity"):
        plot(sweep, "histogram", load=400.0, friction=1e-4)
