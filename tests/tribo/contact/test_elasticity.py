import json
from pathlib import Path

import numpy as np
import pytest

from tests.tribo.contact.influence import elastic_influence
from tribo import Grid
from tribo.contact import ElasticHalfSpace

REFERENCES = json.loads(
    Path(__file__).with_name("references").joinpath("elastic_influence.json").read_text()
)
UNIT = 1 / np.pi  # contact modulus with which the influence is ∫∫ 1/r
E_STAR = 115.385e9


@pytest.mark.parametrize("entry", REFERENCES["free"], ids=str)
def test_free_kernel_equals_love_in_25_digits(entry):
    i, j = entry["i"], entry["j"]
    grid = Grid((i + 1, j + 1), (entry["dx"], entry["dy"]), (False, False))
    influence = elastic_influence(grid, UNIT)
    assert influence[i, j] == pytest.approx(entry["value"], abs=1e-13 * influence[0, 0])
    if max(i, j) > 20:  # far entries keep their own digits too
        assert influence[i, j] == pytest.approx(entry["value"], rel=1e-10)


@pytest.mark.parametrize("entry", REFERENCES["line_periodic"], ids=str)
@pytest.mark.parametrize("axis", [1, 0])
def test_line_periodic_kernel_equals_the_extrapolated_sum_over_images(entry, axis):
    n = 2 * entry["i"] + 2
    order = slice(None, None, 1 if axis == 1 else -1)
    grid = Grid((n, entry["ny"])[order], (entry["dx"], entry["dy"])[order], (False, True)[order])
    influence = elastic_influence(grid, UNIT)
    self_term = ElasticHalfSpace(grid, UNIT).self_influence
    difference = influence[(entry["i"], entry["j"])[order]] - influence[0, 0]
    assert difference == pytest.approx(entry["value"], abs=1e-12 * self_term)


@pytest.mark.parametrize("entry", REFERENCES["doubly_periodic"], ids=str)
@pytest.mark.parametrize("order", [1, -1])
def test_doubly_periodic_spectrum_equals_the_alternating_sum_over_waves(entry, order):
    shape, mode, spacing = (
        tuple(pair)[::order] for pair in (entry["shape"], entry["mode"], (1.0, entry["dy"]))
    )
    spectrum = ElasticHalfSpace(Grid(shape, spacing, (True, True)), UNIT).spectrum
    assert spectrum[mode] == pytest.approx(entry["value"], rel=1e-13)


def test_uniform_pressure_along_y_gives_the_plane_displacement():
    grid = Grid((60, 12), (1.632e-6, 1.9e-6))
    plane = Grid((60, 1), (1.632e-6, 12 * 1.9e-6))
    pressure = 1e9 * np.random.default_rng(0).uniform(size=(60, 1))
    rough = ElasticHalfSpace(grid, E_STAR)(np.repeat(pressure, 12, axis=1))
    smooth = ElasticHalfSpace(plane, E_STAR)(pressure)
    # Equal up to a constant and the quadrature over y, which 12 elements sample to 1e-3.
    assert np.ptp(rough, axis=1).max() < 1e-12 * np.abs(rough).max()
    shift = rough[:, :1] - smooth
    assert np.ptp(shift) < 2e-3 * np.ptp(smooth)


@pytest.mark.parametrize("order", [1, -1])
def test_nearest_image_kernel_is_the_element_and_its_image_one_period_back(order):
    (dx, dy), ny = (1.632e-6, 1.9e-6), 10
    axes = slice(None, None, order)
    grid = Grid((7, ny)[axes], (dx, dy)[axes], (False, True)[axes])
    near = elastic_influence(grid, UNIT, "nearest-image")
    alone = elastic_influence(Grid((7, ny + 1)[axes], (dx, dy)[axes], (False, False)), UNIT)
    for i, j in ((0, 0), (0, 1), (3, 5), (6, 9), (2, 7)):
        place, nearest, image = (pair[axes] for pair in ((i, j), (i, j), (i, ny - j)))
        assert near[place] == pytest.approx(alone[nearest] + alone[image], rel=1e-12)
