import functools
import math
import re

import numpy as np
import pytest
from scipy.linalg import cholesky, solve_triangular
from scipy.optimize import brentq, lsq_linear

from tests.helpers.closed_forms import hertz_point_approach, westergaard_pressure
from tribo import Grid
from tribo.analytic import (
    hertz_line_half_width,
    hertz_line_peak_pressure,
    hertz_point_peak_pressure,
    hertz_point_radius,
    hertz_pressure,
)
from tribo.contact import ElasticHalfSpace, solve_contact
from tribo.errors import ConvergenceError
from tribo.surface import self_affine

E_STAR = 115.385e9


def dense(solid):
    """Dense matrix of the elastic map, from its unit columns."""
    unit = np.eye(math.prod(solid.grid.shape)).reshape(-1, *solid.grid.shape)
    return np.array([solid(column).ravel() for column in unit]).T


def bounded_least_squares(matrix, z, total, hardness):
    """Contact by another method: minimise ‖Rp − R⁻ᵀ(α − z)‖ within bounds, with roots for α."""
    root = cholesky(matrix)

    def pressure(approach):
        target = solve_triangular(root, approach - z, trans="T")
        return lsq_linear(root, target, bounds=(0, hardness), method="bvls", tol=1e-14).x

    scale = matrix.diagonal().max() * total
    low, high = z.min(), z.max() + 10 * scale
    approach = brentq(lambda a: pressure(a).sum() - total, low, high, xtol=1e-16 * high, rtol=1e-14)
    return pressure(approach), approach


@pytest.mark.parametrize("periodic", [(False, False), (False, True), (True, False)])
@pytest.mark.parametrize("hardness", [math.inf, 2.2, 1.3])
def test_equals_an_independent_bounded_least_squares_solution(periodic, hardness):
    grid = Grid((8, 7), (1.0, 1.2), periodic)
    solid = ElasticHalfSpace(grid, 1.0)
    z = 2 * np.random.default_rng(0).uniform(size=grid.shape)
    load = 0.8 * grid.area
    contact = solve_contact(solid, z, load, hardness, tolerance=1e-10)
    reference, approach = bounded_least_squares(
        dense(solid), z.ravel(), load / grid.element_area, hardness
    )
    assert contact.pressure.ravel() == pytest.approx(reference, abs=1e-7 * reference.max())
    assert contact.approach == pytest.approx(approach, rel=1e-7)


@pytest.mark.parametrize(
    ("limits", "advice"),
    [
        ({"tolerance": 1e-10, "max_iterations": 1},
         r"above 1\.00e-10; allow more than 1 iterations or a larger tolerance$"),
        ({"tolerance": 1e-18},
         r"above 1\.00e-18; rounding of displacements of \S+ m allows no less; set a tolerance of "
         r"at least (\S+)$"),
    ],
)  # fmt: skip
def test_a_contact_that_does_not_converge_says_what_helps(limits, advice):
    grid = Grid((8, 7), (1.0, 1.2), (False, True))
    z = 2 * np.random.default_rng(0).uniform(size=grid.shape)
    contact = functools.partial(solve_contact, ElasticHalfSpace(grid, 1.0), z, 0.8 * grid.area)
    words = r"^the contact did not converge: residual \S+ after \d+ iterations, "
    with pytest.raises(ConvergenceError, match=words + advice) as error:
        contact(**limits)
    advised = re.search(advice, str(error.value)).groups()
    tolerance = float(advised[0]) if advised else 1e-10
    assert contact(tolerance=tolerance).residual <= tolerance


@pytest.mark.parametrize("hardness", [math.inf, 2.2])
def test_the_penetration_is_the_deepest_of_what_is_not_plastic(hardness):
    grid = Grid((16, 12), (1.0, 1.2), (False, False))
    solid = ElasticHalfSpace(grid, 1.0)
    z = 2 * np.random.default_rng(1).uniform(size=grid.shape)
    contact = solve_contact(solid, z, 0.8 * grid.area, hardness, tolerance=1e-2)
    gap = solid(contact.pressure) + z - contact.approach
    deepest = -gap[contact.pressure < hardness].min()
    assert deepest > 1e-4
    assert contact.penetration == pytest.approx(deepest, rel=1e-9)


def test_cylinder_of_figure_4_is_hertz_within_a_thousandth():
    grid = Grid((128, 64), (3e-6, 456e-6 / 64))
    z = np.broadcast_to(grid.coordinates(0)[:, None] ** 2 / (2 * 8e-3), grid.shape)
    contact = solve_contact(ElasticHalfSpace(grid, E_STAR), z, 222.2e3 * grid.size[1])
    cylinder = (222.2e3, 8e-3, E_STAR)
    half_width, peak = hertz_line_half_width(*cylinder), hertz_line_peak_pressure(*cylinder)
    assert peak == pytest.approx(1.010e9, rel=1e-3)
    assert half_width == pytest.approx(0.14e-3, rel=1e-3)
    assert contact.pressure.max() == pytest.approx(peak, rel=1e-3)
    profile = contact.pressure[:, 0]
    inside = profile > 0.2 * peak
    # p² falls linearly in x², and is 0 at the half-width.
    slope, offset = np.polyfit(grid.coordinates(0)[inside] ** 2, profile[inside] ** 2, 1)
    assert math.sqrt(-offset / slope) == pytest.approx(half_width, rel=1e-3)
    # The kernel knows the line's images to 1e-13; the solver's tolerance is 1e-8 of the peak.
    assert np.ptp(contact.pressure, axis=1).max() < 1e-6 * peak


def test_sphere_is_hertz_and_converges_with_the_grid():
    radius, load = 10e-3, 10.0
    contact_radius = hertz_point_radius(load, radius, E_STAR)
    peak = hertz_point_peak_pressure(load, radius, E_STAR)
    errors = []
    for n in (16, 32, 64, 128):
        side = 3 * contact_radius / n
        grid = Grid((n, n), (side, side), (False, False))
        x, y = grid.coordinates(0)[:, None], grid.coordinates(1)[None, :]
        z = (x**2 + y**2) / (2 * radius)
        contact = solve_contact(ElasticHalfSpace(grid, E_STAR), z, load)
        exact = hertz_pressure(np.hypot(x, y), contact_radius, peak)
        errors.append(np.abs(contact.pressure - exact).mean() / peak)
    order = -np.polyfit(np.log([16, 32, 64, 128]), np.log(errors), 1)[0]
    assert order > 1  # limited by the square root of the pressure near the rim, which cuts elements
    assert errors[-1] < 2e-3
    approach = hertz_point_approach(load, radius, E_STAR)
    assert contact.approach == pytest.approx(approach, rel=1e-3)


def test_a_wave_has_the_pressure_and_the_width_of_westergaard():
    grid = Grid((256, 4), (1e-6, 1e-6), (True, True))
    length, amplitude = grid.size[0], 0.2e-6
    solid = ElasticHalfSpace(grid, E_STAR)
    wave = amplitude * (1 - np.cos(2 * np.pi * grid.coordinates(0) / length))[:, None]
    z = np.broadcast_to(wave, grid.shape)
    full = math.pi * E_STAR * amplitude / length  # Johnson, §13.2
    contact = solve_contact(solid, z, 1.2 * full * grid.area)
    expected = westergaard_pressure(grid.coordinates(0), 1.2 * full, full, length)
    # Constant pressure on each of 256 elements approximates the wave to (qdx)²/24.
    assert contact.pressure[:, 0] == pytest.approx(expected, rel=2e-4)
    half_width = length / 5
    partial = full * math.sin(math.pi * half_width / length) ** 2
    contact = solve_contact(solid, z, partial * grid.area)
    assert np.count_nonzero(contact.pressure[:, 0]) * 1e-6 == pytest.approx(
        2 * half_width, abs=2e-6
    )


def test_the_start_changes_the_way_but_not_the_answer():
    grid = Grid((40, 40), (1e-6, 1e-6))
    solid = ElasticHalfSpace(grid, E_STAR)
    z = grid.coordinates(0)[:, None] ** 2 / 4e-3 - self_affine(grid, 0.1e-6, 0.8, 4e-6, 0)
    cold = solve_contact(solid, z, 2.0, 6.6e9, tolerance=1e-10)
    neighbour = solve_contact(solid, z, 2.02, 6.6e9, tolerance=1e-10)
    warm = solve_contact(solid, z, 2.0, 6.6e9, tolerance=1e-10, initial_pressure=neighbour.pressure)
    odd, above_hardness = (
        solve_contact(solid, z, 2.0, 6.6e9, tolerance=1e-10, initial_pressure=start)
        for start in (neighbour.pressure[::-1] * 7, np.where(neighbour.pressure > 0, 1e12, 0.0))
    )
    assert warm.iterations < cold.iterations
    for other in (warm, odd, above_hardness):
        assert other.pressure == pytest.approx(cold.pressure, abs=1e-8 * cold.pressure.max())


def test_no_load_has_no_pressure_and_the_highest_load_has_the_hardness_everywhere():
    grid = Grid((6, 5), (1e-6, 1e-6))
    solid = ElasticHalfSpace(grid, E_STAR)
    z = 1e-7 * np.random.default_rng(0).uniform(size=grid.shape)
    unloaded = solve_contact(solid, z, 0.0, 1e9)
    assert unloaded.pressure.max() == 0
    assert unloaded.gap.min() == 0
    saturated = solve_contact(solid, z, 1e9 * grid.area, 1e9)
    assert saturated.pressure == pytest.approx(1e9)
    assert saturated.gap.max() == 0


def test_where_all_that_touches_is_plastic_the_approach_is_halfway_to_the_next_node():
    grid = Grid((8, 7), (1.0, 1.2), (False, False))
    solid = ElasticHalfSpace(grid, 1.0)
    touches = np.zeros(grid.shape, bool)
    touches[[2, 2, 6], [1, 5, 3]] = True
    z = np.where(touches, 0.0, 100.0)
    contact = solve_contact(solid, z, 3 * 2.2 * grid.element_area, 2.2)
    np.testing.assert_allclose(contact.pressure, np.where(touches, 2.2, 0.0), rtol=1e-12)
    separation = solid(contact.pressure) + z
    limits = separation[touches].max(), separation[~touches].min()
    assert contact.approach == pytest.approx(np.mean(limits), rel=1e-12)
