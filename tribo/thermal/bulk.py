"""The bulk of a body behind its heated skin: a heat capacity, and a loss to the surroundings."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from tribo.errors import InputError
from tribo.types import Array

_SMALL = 1e-4  # |z| below which a series of three terms is exact to 1e-13


@dataclass(frozen=True, slots=True)
class Bulk:
    """A body of uniform temperature that warms by the heat it takes and cools by a loss.

    Attributes
    ----------
    capacity : float
        Heat that warms the body by one kelvin [J/K]; 0 for a steady state at all times.
    loss : float
        Heat that the body loses for each kelvin above its starting temperature [W/K]; 0 for no
        loss.

    Examples
    --------
    >>> Bulk(capacity=650.0, loss=2.0)
    Bulk(capacity=650.0, loss=2.0)
    """

    capacity: float = 0.0
    loss: float = 0.0

    def __str__(self) -> str:
        parts = (self.capacity, "J/K"), (self.loss, "W/K")
        return " and ".join(f"{value:.3g} {unit}" for value, unit in parts if value)

    def __post_init__(self) -> None:
        for name, value in (("capacity", self.capacity), ("loss", self.loss)):
            if not 0 <= value < math.inf:
                raise InputError(f"{name} is {value!r}; it must be finite and ≥ 0")
        if not (self.capacity or self.loss):
            raise InputError("capacity and loss are both 0; give one of them above 0")

    @property
    def resistance(self) -> float:
        """Steady thermal resistance to the surroundings [K/W]: 1/loss.

        It is 0 for a body with a heat capacity: `bulk_warming` computes how such a body warms.
        """
        return 0.0 if self.capacity else 1 / self.loss


def bulk_warming(
    times: Array,
    heats: Array,
    conductances: tuple[float, float],
    bulks: tuple[Bulk | None, Bulk | None],
) -> tuple[float, float]:
    """Warming of the bulk of the pin, and of the disk, from time 0 to the last of the `times` [K].

    The contact has one temperature, and conductances h₁ and h₂ to the bulks [W/K]. Its heat Q is
    shared, and heat flows from one body to the other. So the warming T₁ of body 1, with its
    capacity C₁ and its loss G₁, follows

        C₁ dT₁/dt = h₁/(h₁ + h₂) Q + h₁h₂/(h₁ + h₂) (T₂ − T₁) − G₁ T₁,

    and that of body 2 the same with 1 and 2 exchanged. With constant conductances the solution has
    two exponentials, each summed in closed form.

    Parameters
    ----------
    times, heats : ndarray
        Times, ascending [s], and the heat of the contact at each time [W]. The heat is linear in
        between, and 0 at time 0.
    conductances : tuple of float
        Conductances from the contact to pin and disk [W/K].
    bulks : tuple
        Bulk of pin and disk. A body with None or without capacity keeps its starting temperature.

    Examples
    --------
    A disk of 0.65 kJ/K takes nearly all heat, which rises to 94 W in 5 s and stays there for 60 s:

    >>> times, heats = np.array([5.0, 65.0]), np.array([94.0, 94.0])
    >>> _, disk = bulk_warming(times, heats, (0.0, 1.0), (None, Bulk(650.0)))
    >>> f"{disk:.2f} K"
    '9.04 K'
    """
    h1, h2 = conductances
    # With T = y/√C both equations have one symmetric matrix, and so two modes that do not mix.
    roots = np.array([bulk.capacity**-0.5 if bulk and bulk.capacity else 0.0 for bulk in bulks])
    losses = np.array([bulk.loss if bulk else 0.0 for bulk in bulks])
    between = h1 * h2 / (h1 + h2) * np.array([[-1.0, 1.0], [1.0, -1.0]]) - np.diag(losses)
    rates, modes = np.linalg.eigh(between * np.outer(roots, roots))
    gain = modes.T @ (roots * np.array([h1, h2]) / (h1 + h2))
    t, q = np.append(0.0, times), np.append(0.0, heats)
    lengths, rates = np.diff(t), np.minimum(rates, 0.0)[:, None]
    # Heat is linear over an interval: what remains at the interval's end, then at the last time.
    first, second = _weights(rates * lengths)
    left = lengths * (first * q[:-1] + second * np.diff(q)) * np.exp(rates * (t[-1] - t[1:]))
    pin, disk = roots * (modes @ (gain * left.sum(axis=1)))
    return float(pin), float(disk)


def _weights(z: Array) -> tuple[Array, Array]:
    """∫exp(z(1 − u)) du and ∫u exp(z(1 − u)) du over u from 0 to 1, for z ≤ 0.

    Examples
    --------
    >>> [f"{weight:.4f}" for weight in _weights(np.array(-1.0))]
    ['0.6321', '0.3679']
    """
    small = np.abs(z) < _SMALL
    nonzero = np.where(small, 1.0, z)
    first = np.where(small, 1 + z / 2 + z**2 / 6, np.expm1(nonzero) / nonzero)
    return first, np.where(small, 0.5 + z / 6 + z**2 / 24, (first - 1) / nonzero)
