"""An optional discrepancy of the model: slopes of the rise that it does not have.

The logarithm of the rise is taken to be off by a₁ ln(V/V₀) + a₂ (T − T₀)/100 K, with the velocity
and the bulk temperature of each test, V₀ in the middle of the sweep and T₀ that of the scene
(Kennedy & O'Hagan, J. R. Stat. Soc. B 63 (2001) 425, with two functions in place of a process).
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from pipeline.sweep.unknown import Unknown
from tribo.types import Array

SLOPES = (
    Unknown("discrepancy.velocity", "normal", (0.0, 0.2)),
    Unknown("discrepancy.bulk", "normal", (0.0, 0.2)),
)
"""Slopes of ln(rise) over ln(velocity), and over the bulk temperature in 100 K."""
_KELVINS = 100.0  # of bulk temperature, over which the second slope is given


class Slopes(NamedTuple):
    """Draws of the two slopes, each shape (n,)."""

    velocity: Array
    bulk: Array

    @classmethod
    def of(cls, inputs: Array) -> Slopes:
        """The slopes, which stand last among all inputs (n, n_unknown)."""
        return cls(inputs[:, -2], inputs[:, -1])

    def log_factor(self, log_velocities: Array, warmer: float) -> Array:
        """Logarithm of the factor on the rise, shape (n, n_velocity).

        Velocities (n_velocity,) are over the middle one, the bulk temperature is so much warmer
        than that of the scene [K].

        Examples
        --------
        >>> slopes = Slopes(np.array([0.5]), np.array([0.1]))
        >>> print(slopes.log_factor(np.array([-1.0, 1.0]), warmer=50.0))
        [[-0.45  0.55]]
        """
        by_velocity = self.velocity[:, None] * log_velocities
        return np.asarray(by_velocity + self.bulk[:, None] * warmer / _KELVINS)
