"""The thermal circuit held against contacts solved with what it stands for."""

import numpy as np
import pytest

import tribo
from tribo.numerics import Convolution
from tribo.thermal import circuit_rise, partition_heat

STEEL = tribo.Material(210e9, 0.3, 45.0, 7800.0, 470.0)
GRID = tribo.Grid((64, 32), (4e-6, 4e-6))
VELOCITY, TIME = 1.25, 3.0


@pytest.fixture(scope="module")
def bodies():
    pin, disk = (tribo.thermal.ConductingHalfSpace(GRID, STEEL, V, TIME) for V in (0.0, VELOCITY))
    x, y = (GRID.coordinates(axis) for axis in (0, 1))
    flux = np.maximum(0.0, 1e8 * (1 - (x[:, None] / 8e-5) ** 2 - (y[None, :] / 5e-5) ** 2))
    return pin, disk, flux


def solved(bodies, difference=0.0, layer=0.0):
    pin, disk, flux = bodies
    disk = Convolution(GRID, disk.spectrum + layer)
    split = partition_heat(pin, disk, flux, flux > 0, bulk_difference=difference)
    return split.rise[flux > 0].mean() + max(0.0, -difference), split


def test_a_layer_on_the_disk_warms_the_contact_by_what_the_circuit_says(bodies):
    layer = 2e-8
    mean, split = solved(bodies)
    with_layer, _ = solved(bodies, layer=layer)
    area = np.count_nonzero(bodies[2]) * GRID.element_area
    heat = bodies[2].sum() * GRID.element_area
    rise = circuit_rise(mean, split.pin_share, heat, disk_resistance=layer / area)
    # The bodies' rises are not uniform, which costs some percent of the change.
    assert rise - mean == pytest.approx(with_layer - mean, rel=0.1)


def test_a_warm_pin_warms_the_contact_by_its_share(bodies):
    mean, split = solved(bodies)
    heat = bodies[2].sum() * GRID.element_area
    warm, _ = solved(bodies, difference=-10.0)
    resistance = 50.0
    rise = circuit_rise(mean, split.pin_share, heat, pin_resistance=resistance)
    pin_share = (split.pin_share * heat * mean / (mean + resistance * split.pin_share * heat)) * (
        rise / mean
    )  # what flows into the pin
    assert rise - mean == pytest.approx((warm - mean) * resistance * pin_share / 10.0, rel=0.05)


def test_a_resistance_is_in_series_with_its_body():
    """Both bodies conduct 0.5 W/K; with 1 K/W before it the disk conducts 1/3 W/K."""
    assert circuit_rise(100.0, 0.5, 100.0, disk_resistance=1.0) == pytest.approx(120.0)
    assert circuit_rise(100.0, 0.5, 100.0, pin_resistance=1.0) == pytest.approx(120.0)
