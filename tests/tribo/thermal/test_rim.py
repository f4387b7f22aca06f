"""A disc heated around its rim, beside finite volumes of its rings."""

import numpy as np
import pytest
from scipy.linalg import expm

from tribo.thermal import rim_warming

RADIUS, WIDTH, DIFFUSIVITY, CAPACITY = 50e-3, 10e-3, 1.2275e-5, 3.666e6


def by_rings(time, loss=0.0, count=400):
    """Warming of the rim by 1 W, of rings that conduct; each loses its share of the loss."""
    edges = np.linspace(0.0, RADIUS, count + 1)
    volumes = np.pi * np.diff(edges**2) * WIDTH
    between = 2 * np.pi * edges[1:-1] * WIDTH * DIFFUSIVITY * CAPACITY / (RADIUS / count)
    flow = np.diag(np.append(between, 0.0) + np.append(0.0, between))
    flow -= np.diag(between, 1) + np.diag(between, -1)
    rates = -flow / (CAPACITY * volumes)[:, None] - loss * np.eye(count) / CAPACITY / volumes.sum()
    heat = np.zeros(count)
    heat[-1] = 1 / (CAPACITY * volumes[-1])
    state = np.zeros((count + 1, count + 1))
    state[:count, :count], state[:count, -1] = rates, heat
    rings = expm(state * time)[:count, -1]
    flux = 1 / (2 * np.pi * RADIUS * WIDTH)  # to the rim from the middle of the last ring
    return rings[-1] + flux * RADIUS / count / 2 / (DIFFUSIVITY * CAPACITY)


@pytest.mark.parametrize("time", [0.5, 5.0, 60.0, 600.0])
def test_the_rim_warms_as_rings_that_conduct(time):
    found = rim_warming(time, RADIUS, WIDTH, DIFFUSIVITY, CAPACITY)
    assert found == pytest.approx(by_rings(time), rel=2e-3)


@pytest.mark.parametrize("time", [5.0, 60.0, 600.0])
def test_a_loss_takes_its_part(time):
    found = rim_warming(time, RADIUS, WIDTH, DIFFUSIVITY, CAPACITY, loss=5.0)
    assert found == pytest.approx(by_rings(time, loss=5.0), rel=2e-3)
