"""Friction: a coefficient, which the sliding velocity and the temperature of the contact scale.

Where friction depends on temperature, each part of the contact has that of its own temperature,

    T = T_b + µ(T) r,                                                                    (1)

where r is its own rise at friction 1. Of several solutions that is the lowest, which a contact that
warms up reaches first. So a temperature exceeds T_c where r exceeds (T_c − T_b)/µ(T_c); or the
highest of (T − T_b)/µ(T) below T_c, where friction rises so steeply that it runs away before.

Neighbours heat a part with the friction of their own temperatures, which (1) takes to be that of
the part. Beside a partition of heat that has the friction of each element, (1) finds for the rise
that a tenth of the contact exceeds 1.5 to 3.0 % less where friction falls by 0.2 %/K, 0.5 to 3.4 %
more where it rises as much, and up to 4.4 % less where it falls by 0.5 %/K. With the friction of
the mean temperature of the contact it would be up to 10 % more.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import numpy as np
import scipy  # parts of it are loaded where they are used

from tribo.errors import InputError
from tribo.types import Array

Curve = tuple[tuple[float, float], ...]
"""Abscissae, ascending, and a factor at each."""


def _velocity_factor(curve: Curve, velocity: Any, _: Any) -> Any:
    if velocity is None or not curve:
        return np.ones(np.shape(0.0 if velocity is None else velocity))
    velocities, factors = np.array(curve).T
    # Smooth also at the ends, since a boundary is interpolated between points on both sides.
    nodes = np.concatenate([[velocities[0] / 2], velocities, [2 * velocities[-1]]])
    smooth = scipy.interpolate.PchipInterpolator(
        np.log(nodes), factors[[0, *range(len(factors)), -1]]
    )
    return smooth(np.log(np.clip(velocity, nodes[0], nodes[-1])))


def _temperature_factor(curve: Curve, _: Any, temperature: Any) -> Any:
    return np.interp(temperature, *np.array(curve).T) if curve and temperature is not None else 1.0


FRICTIONS: dict[str, Callable[[Any, Any, Any], Any]] = {
    "coefficient": lambda coefficient, *_: coefficient,
    "by_velocity": _velocity_factor,
    "by_temperature": _temperature_factor,
}
"""Forms of friction by the fields of `Friction`: each a factor, from the field, V and T."""


@dataclass(frozen=True, slots=True)
class Friction:
    """Friction as the product of a coefficient and of factors.

    Attributes
    ----------
    coefficient : float
        Coefficient of friction, or 1 for friction over that of the conditions.
    by_velocity : tuple of tuple of float
        Sliding velocities above 0, ascending [m/s], and a factor at each; smooth and monotonic in
        between, and beyond the ends as there.
    by_temperature : tuple of tuple of float
        Temperatures of the contact, ascending [K], and a factor above 0 at each; linear in between,
        and beyond the ends as there.

    Examples
    --------
    >>> falling = Friction(0.1, by_velocity=((1.0, 1.03), (4.0, 0.94)))
    >>> falling.at(velocity=np.array([0.5, 2.0, 9.0])).round(4).tolist()
    [0.103, 0.0985, 0.094]
    >>> warm = Friction(0.1, by_temperature=((300.0, 1.0), (400.0, 0.8)))
    >>> round(float(warm.at(velocity=1.0, temperature=350.0)), 9)
    0.09
    """

    coefficient: float = 1.0
    by_velocity: Curve = ()
    by_temperature: Curve = ()

    def __post_init__(self) -> None:
        if not 0 <= self.coefficient < math.inf:
            raise InputError(f"friction is {self.coefficient!r}; it must be finite and ≥ 0")
        for name, least in (("velocities", 0.0), ("temperatures", 5e-324)):
            curve = self.by_velocity if name == "velocities" else self.by_temperature
            nodes = [node for node, _ in curve]
            is_finite = all(0 < node < math.inf for node in nodes)
            if not is_finite or sorted(set(nodes)) != nodes:
                raise InputError(
                    f"{name} of friction are {nodes}; they must be finite, above 0 and ascending"
                )
            if not all(least <= factor < math.inf for _, factor in curve):
                allowed = "above 0" if least else "≥ 0"
                raise InputError(
                    f"friction by {name} is {curve!r}; each must be finite and {allowed}"
                )

    def at(self, velocity: Any = None, temperature: Any = None) -> Any:
        """Friction at sliding velocities [m/s] and temperatures of the contact [K].

        Without one of both its factor is left out.
        """
        factor: Any = 1.0
        for name, form in FRICTIONS.items():
            factor = factor * form(getattr(self, name), velocity, temperature)
        return factor

    def temperature(self, rise: Any, bulk: float) -> Any:
        """Temperature of the contact at rises at friction 1, Eq. (1) [K].

        The factor of velocity is in the rises.

        Examples
        --------
        >>> warm = Friction(0.1, by_temperature=((300.0, 1.0), (400.0, 0.8)))
        >>> found = float(warm.temperature(1000.0, bulk=300.0))
        >>> f"{found:.2f} K = 300 + {1000 * float(warm.at(temperature=found)):.2f}"
        '383.33 K = 300 + 83.33'
        """
        if not self.by_temperature or self.coefficient == 0:
            return bulk + self.coefficient * rise
        # Between two nodes µ is linear, and (T − T_b)/µ a hyperbola, which only rises or falls.
        nodes, limits = self._limits(bulk)
        frictions = self.at(temperature=nodes)
        above = np.clip(np.searchsorted(limits, rise), 1, len(nodes) - 1)
        low, high = nodes[above - 1], nodes[above]
        slope = (frictions[above] - frictions[above - 1]) / (high - low)
        at_bulk = frictions[above - 1] + slope * (bulk - low)
        return bulk + at_bulk * rise / (1 - slope * rise)

    def limit(self, temperature: float, bulk: float) -> float:
        """Rise at friction 1 above which the contact is hotter than a temperature [K]."""
        if self.coefficient == 0:
            return math.inf
        if not self.by_temperature:
            return (temperature - bulk) / self.coefficient
        nodes, limits = self._limits(bulk)
        own = (temperature - bulk) / float(self.at(temperature=temperature))
        return float(max(own, limits[nodes < temperature].max(initial=0.0)))

    def sensitivity(self, temperature: float, bulk: float) -> float:
        """Derivative of a temperature by the logarithm of its rise at friction 1 [K]."""
        if not self.by_temperature or self.coefficient == 0:
            return temperature - bulk
        rise = self.limit(temperature, bulk) * (1 + np.array([0.0, 1e-6]))
        low, high = self.temperature(rise, bulk)
        return float(high - low) / 1e-6

    def _limits(self, bulk: float) -> tuple[Array, Array]:
        """Temperatures from a bulk on, and rises at friction 1 that reach them [K]."""
        table = [node for node, _ in self.by_temperature if node > bulk]
        last = max(bulk, *table) if table else bulk
        nodes = np.array([bulk, *table, 2 * last])
        return nodes, np.maximum.accumulate((nodes - bulk) / self.at(temperature=nodes))
