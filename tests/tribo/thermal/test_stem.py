import numpy as np
import pytest

from tribo.thermal import stem_fraction


def test_the_heated_end_of_a_rod_warms_as_finite_differences_have_it():
    nodes, tau = 81, np.array([0.02, 0.1, 0.4, 1.5])
    dx = 1 / (nodes - 1)
    conduction = (np.diag(np.ones(nodes - 1), 1) + np.diag(np.ones(nodes - 1), -1)) / dx**2
    conduction -= np.diag(np.full(nodes, 2 / dx**2))
    conduction[0, 1], source = 2 / dx**2, np.zeros(nodes - 1)  # heated at the first node
    source[0] = 2 / dx
    inner = conduction[:-1, :-1]  # the last is at the holder's temperature
    rates, modes = np.linalg.eig(inner)
    amplitudes = np.linalg.solve(modes, source)
    warmed = [(modes @ (amplitudes * np.expm1(rates * t) / rates))[0].real for t in tau]
    np.testing.assert_allclose(stem_fraction(tau), warmed, rtol=3e-3)


def test_a_rod_is_endless_at_first_and_a_resistance_at_last():
    assert stem_fraction(0.049) == pytest.approx(2 * np.sqrt(0.049 / np.pi), rel=1e-9)
    assert stem_fraction(0.0500001) == pytest.approx(2 * np.sqrt(0.05 / np.pi), rel=1e-4)
    assert stem_fraction(np.inf) == 1
