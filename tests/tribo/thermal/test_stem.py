import numpy as np
import pytest

import tribo
from tribo.thermal import stem_fraction


def test_the_heated_end_of_a_rod_warms_as_finite_differences_have_it():
    nodes, tau = 81, np.array([0.02, 0.1, 0.4, 1.5])
    dx = 1 / (nodes - 1)
    conduction = (np.diag(np.ones(nodes - 1), 1) + np.diag(np.ones(nodes - 1), -1)) / dx**2
    conduction -= np.diag(np.full(nodes, 2 / dx**2))
    conduction[0, 1], source = 2 / dx**2, np.zeros(nodes - 1)  # heat enters at the first node
    source[0] = 2 / dx
    inner = conduction[:-1, :-1]  # the last node has the holder's temperature
    rates, modes = np.linalg.eig(inner)
    amplitudes = np.linalg.solve(modes, source)
    warmed = [(modes @ (amplitudes * np.expm1(rates * t) / rates))[0].real for t in tau]
    np.testing.assert_allclose(stem_fraction(tau), warmed, rtol=3e-3)


def test_a_rod_warms_by_its_own_flux_in_time():
    """Expected values sum the response to each step of a flux that ramps, holds or falls."""
    for settling, times, loads in (
        (4.0, [5.0], [3.0]),
        (4.0, [5.0, 65.0], [3.0, 3.0]),
        (4.0, [0.5, 1.0, 1.0, 2.0], [4.0, 4.0, 1.0, 2.0]),
        (400.0, [0.5, 1.0, 1.0, 2.0], [4.0, 4.0, 1.0, 2.0]),  # its far end has no effect
    ):
        rod = tribo.Stem(2.0, settling_time=settling)
        grid = np.linspace(0.0, times[-1], 10001)
        flux = np.interp(grid, [0.0, *times], [0.0, *loads])
        ages = times[-1] - (grid[1:] + grid[:-1]) / 2
        warmed = 2.0 * float(np.diff(flux) @ stem_fraction(ages / settling))
        found = rod.resistance_under(np.array(times), np.array(loads))
        assert found * loads[-1] == pytest.approx(warmed, rel=1e-3)
    assert tribo.Stem(2.0).resistance_under(np.array([5.0]), np.array([3.0])) == 2.0


def test_a_heat_that_grows_evenly_warms_an_endless_rod_by_two_thirds_of_its_last():
    rod = tribo.Stem(3.0, settling_time=1e4)
    constant = 3.0 * 2 * np.sqrt(5.0 / 1e4 / np.pi)
    found = rod.resistance_under(np.array([5.0]), np.array([750.0]))
    assert found == pytest.approx(2 / 3 * constant, rel=1e-12)


def test_a_rod_is_endless_at_first_and_a_resistance_at_last():
    assert stem_fraction(0.049) == pytest.approx(2 * np.sqrt(0.049 / np.pi), rel=1e-9)
    assert stem_fraction(0.0500001) == pytest.approx(2 * np.sqrt(0.05 / np.pi), rel=1e-4)
    assert stem_fraction(np.inf) == 1
