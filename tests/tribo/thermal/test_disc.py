"""Discs and rings heated around their rims, beside finite volumes of their rings."""

import numpy as np
import pytest
from scipy.linalg import expm
from scipy.special import zeta

from tribo.thermal import Disc
from tribo.thermal.track import track_warming

DIFFUSIVITY, CAPACITY = 1.2275e-5, 3.666e6
CONDUCTIVITY = DIFFUSIVITY * CAPACITY
DISC = Disc(diameter=0.1, width=10e-3)
SPEED, RAMP, POWER = 200.0, 10.0, 400.0


def by_rings(disc, hold, count=60):
    """Warming of a disc's rim [K] after a ramp of heat and a hold, by concentric rings."""
    edges = np.linspace(0.0, disc.diameter / 2, count + 1)
    thickness = edges[1] - edges[0]
    volumes = np.pi * np.diff(edges**2) * disc.width
    between = 2 * np.pi * edges[1:-1] * disc.width * CONDUCTIVITY / thickness
    flow = np.diag(np.append(between, 0.0) + np.append(0.0, between))
    flow -= np.diag(between, 1) + np.diag(between, -1)
    half = thickness / 2 / CONDUCTIVITY
    rim = np.pi * disc.diameter * disc.width
    rates, size = -flow / (CAPACITY * volumes)[:, None], count + 2
    system = np.zeros((size, size))
    system[:count, :count] = rates
    system[count - 1, count] = POWER / (CAPACITY * volumes[-1])
    state = np.zeros(size)
    for length, slope in ((RAMP, 1 / RAMP), (hold, 0.0)):
        state[-1], system[count, -1] = 1.0, slope
        state = expm(system * length) @ state if length else state
    flux = POWER * state[count] / rim
    return state[count - 1] + flux * half


def by_turns(disc, hold):
    """Warming of a disc's rim [K] by `track_warming`, plus what the present turn has yet to lay."""
    times, loads = np.array([RAMP, RAMP + hold]), np.full(2, POWER / SPEED)
    if not hold:
        times, loads = times[:1], loads[:1]
    turn = np.pi * disc.diameter / SPEED
    heat = (times, loads), disc.width, DIFFUSIVITY, CAPACITY
    warmed = track_warming(times[-1], turn, *heat, disc)
    # Σ 1/√n over N turns is 2√N + ζ(½); for a continuous source it is 2√N.
    pause = POWER / SPEED / (disc.width * CAPACITY * np.sqrt(np.pi * DIFFUSIVITY * turn))
    return warmed - zeta(0.5) * pause


@pytest.mark.parametrize("hold", [0.0, 600.0])
def test_the_rim_warms_as_rings_that_conduct(hold):
    assert by_turns(DISC, hold) == pytest.approx(by_rings(DISC, hold), rel=0.01)


def test_a_disc_is_a_half_space_at_first_and_of_one_temperature_at_last():
    early, late = DISC.rim_response(np.array([1e-6, 1e4]), DIFFUSIVITY)
    assert early == pytest.approx(1 / np.sqrt(np.pi * DIFFUSIVITY * 1e-6), rel=1e-3)
    assert late == pytest.approx(2 / 0.05, rel=1e-9)


def test_the_half_space_and_the_series_meet():
    wall = DISC.diameter / 2
    at = 4e-4 * wall**2 / DIFFUSIVITY * np.array([1 - 1e-9, 1 + 1e-9])
    before, after = DISC.rim_response(at, DIFFUSIVITY)
    assert before == pytest.approx(after, rel=3e-4)
