"""The bulk of a body behind its heated skin: a heat capacity, and a loss to what is around it."""

from __future__ import annotations

import itertools
import math
from dataclasses import dataclass

import numpy as np
import scipy

from tribo.errors import InputError
from tribo.types import Array

_STRAIGHT = 1e-9  # of the heat, by which a moment lies beside the line of its neighbours


@dataclass(frozen=True, slots=True)
class Bulk:
    """A body of one temperature that warms by the heat it takes and cools by a loss.

    Attributes
    ----------
    capacity : float
        Heat that warms it by one kelvin [J/K]; 0 where it is always in its steady state.
    loss : float
        Heat that it loses for each kelvin above where it starts [W/K]; 0 for none.

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
        """Thermal resistance that it puts in series with its body's others [K/W]."""
        return 0.0 if self.capacity else 1 / self.loss


def bulk_warming(
    times: Array,
    heats: Array,
    conductances: tuple[float, float],
    bulks: tuple[Bulk | None, Bulk | None],
) -> tuple[float, float]:
    """Warming of the bulk of pin and disk since the start [K].

    The contact, which has one temperature, is tied to the bulks by conductances h₁ and h₂ [W/K].
    Of the heat Q that arises there, and of what flows from one body to the other, body 1 gets

        C₁ dT₁/dt = h₁/(h₁ + h₂) Q + h₁h₂/(h₁ + h₂) (T₂ − T₁) − G₁ T₁,

    body 2 likewise. With constant conductances the solution is a matrix exponential.

    Parameters
    ----------
    times, heats : ndarray
        Times [s] and the heat at each [W], linear in between and 0 at time 0.
    conductances : tuple of float
        Conductances of pin and disk.
    bulks : tuple
        Bulk of pin and disk; one that is None, or has no capacity, stays as warm as it starts.

    Examples
    --------
    A disk of 0.65 kJ/K that takes nearly all of 94 W, after a ramp of 5 s and a hold of 60 s:

    >>> moments, heats = np.array([5.0, 65.0]), np.array([94.0, 94.0])
    >>> _, disk = bulk_warming(moments, heats, (0.0, 1.0), (None, Bulk(650.0)))
    >>> f"{disk:.2f} K"
    '9.04 K'
    """
    h1, h2 = conductances
    capacities = np.array([bulk.capacity or math.inf if bulk else math.inf for bulk in bulks])
    losses = np.array([bulk.loss if bulk else 0.0 for bulk in bulks])
    between = h1 * h2 / (h1 + h2)
    decay = (between * np.array([[-1.0, 1.0], [1.0, -1.0]]) - np.diag(losses)) / capacities[:, None]
    gain = np.array([h1, h2]) / (h1 + h2) / capacities
    warming = np.zeros(2)
    for (begin, before), (end, heat) in itertools.pairwise(_corners(times, heats)):
        # In units of the interval the heat and its change are two more states, of constant slope.
        system = np.zeros((4, 4))
        system[:2, :2], system[:2, 2] = decay * (end - begin), gain * (end - begin)
        system[2, 3] = 1.0
        warming = (scipy.linalg.expm(system) @ [*warming, before, heat - before])[:2]
    return float(warming[0]), float(warming[1])


def _corners(times: Array, heats: Array) -> list[tuple[float, float]]:
    """Start, end, and the moments in between at which the heat bends."""
    t, q = np.append(0.0, times), np.append(0.0, heats)
    later = t[2:] - t[:-2]
    line = q[:-2] + (q[2:] - q[:-2]) * (t[1:-1] - t[:-2]) / np.where(later > 0, later, 1.0)
    bends = np.abs(q[1:-1] - line) > _STRAIGHT * np.abs(q).max()
    kept = np.concatenate([[True], bends, [True]])
    return list(zip(t[kept].tolist(), q[kept].tolist(), strict=True))
