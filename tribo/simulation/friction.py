"""Friction: a coefficient, which the sliding velocity scales."""

from __future__ import annotations

import functools
import math
from dataclasses import dataclass
from typing import Any

import numpy as np
import scipy  # subpackages are loaded on first use

from tribo.errors import InputError

Curve = tuple[tuple[float, float], ...]
"""Velocities, ascending, each with the factor on friction there."""


@dataclass(frozen=True, slots=True)
class Friction:
    """Friction as the product of a coefficient and of a factor by velocity.

    Attributes
    ----------
    coefficient : float
        Coefficient of friction; 1 if the factors are meant for a coefficient given elsewhere, as
        in `tribo.Corrections`.
    by_velocity : tuple of tuple of float
        Sliding velocities above 0, ascending [m/s], each with a factor; smooth and monotonic in
        between, constant beyond the ends.

    Examples
    --------
    >>> falling = Friction(0.1, by_velocity=((1.0, 1.03), (4.0, 0.94)))
    >>> falling.at(velocity=np.array([0.5, 2.0, 9.0])).round(4).tolist()
    [0.103, 0.0985, 0.094]
    """

    coefficient: float = 1.0
    by_velocity: Curve = ()

    def __post_init__(self) -> None:
        if not 0 <= self.coefficient < math.inf:
            raise InputError(f"friction is {self.coefficient!r}; it must be finite and ≥ 0")
        velocities = [velocity for velocity, _ in self.by_velocity]
        if (
            not all(0 < velocity < math.inf for velocity in velocities)
            or sorted(set(velocities)) != velocities
        ):
            raise InputError(
                f"velocities of friction are {velocities}; they must be finite, above 0 and "
                "ascending"
            )
        if not all(0 <= factor < math.inf for _, factor in self.by_velocity):
            raise InputError(
                f"friction by velocities is {self.by_velocity!r}; each must be finite and ≥ 0"
            )

    def at(self, velocity: Any) -> Any:
        """Coefficient of friction at sliding velocities [m/s], taken elementwise."""
        if not self.by_velocity:
            return self.coefficient * np.ones(np.shape(velocity))
        curve = _smooth_curve(self.by_velocity)
        first, last = self.by_velocity[0][0] / 2, 2 * self.by_velocity[-1][0]
        return self.coefficient * curve(np.log(np.clip(velocity, first, last)))


@functools.lru_cache(maxsize=64)  # evaluated at many points
def _smooth_curve(curve: Curve) -> Any:
    """Factor as a function of ln(velocity)."""
    velocities, factors = np.array(curve).T
    # Smooth also at the ends, since a boundary is interpolated between points on both sides.
    nodes = np.concatenate([[velocities[0] / 2], velocities, [2 * velocities[-1]]])
    return scipy.interpolate.PchipInterpolator(
        np.log(nodes), factors[[0, *range(len(factors)), -1]]
    )
