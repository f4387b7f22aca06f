"""Friction: a coefficient, which the sliding velocity and the temperature of the contact scale.

Where friction depends on temperature, each part of the contact has the friction of its temperature,

    T = T_b + µ(T) r,                                                                    (1)

where T_b is the bulk temperature, and r the rise of that part per unit friction coefficient. Of
several solutions T is the lowest, which a contact that warms up reaches first. So T exceeds a
critical temperature T_c where r exceeds (T_c − T_b)/µ(T_c). Where friction rises so steeply that
the temperature runs away before T_c, the limit of r is the highest (T − T_b)/µ(T) below T_c. From
there on r is taken to grow as T − T_b to the power of 0.3, so that each rise has a temperature.
This is a convention: where friction may ignite a contact, Eq. (1) alone decides no verdict.

Neighbours heat a part with the friction of their own temperatures. Eq. (1) takes the friction of
the part instead. Compared with Eq. (1) of `coupled_friction`, which solves for all elements at
once, the rise exceeded on a tenth of the contact is 3 % less to 7 % more, for friction that changes
by 0.2 %/K either way. If a verdict depends on this difference, it is found by that equation.
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

STEEP = 0.7
"""Least exponent d ln µ/d ln(T − T_b) at which the temperature may run away (ignition)."""
_LEAST = 1 - STEEP  # the rise per unit friction grows at least as T − T_b to this power
_FARTHEST = 1e60  # bound on a ratio of rises, so that the ratio to the power 1/0.3 is finite

Curve = tuple[tuple[float, float], ...]
"""Velocities or temperatures, ascending, each with the factor on friction there."""


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
"""Factor for each field of `Friction`: a function of the field's value, velocity, temperature."""


@dataclass(frozen=True, slots=True)
class Friction:
    """Friction as the product of a coefficient and of factors.

    Attributes
    ----------
    coefficient : float
        Coefficient of friction; 1 if the factors are meant for a coefficient given elsewhere, as
        in `tribo.Corrections`.
    by_velocity : tuple of tuple of float
        Sliding velocities above 0, ascending [m/s], each with a factor; smooth and monotonic in
        between, constant beyond the ends.
    by_temperature : tuple of tuple of float
        Temperatures of the contact, ascending [K], each with a factor above 0; linear in between,
        constant beyond the ends.

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
        """Coefficient of friction at sliding velocities [m/s] and contact temperatures [K].

        Arrays are taken elementwise. The factor of an argument that is None is left out.
        """
        factor: Any = 1.0
        for name, form in FRICTIONS.items():
            factor = factor * form(getattr(self, name), velocity, temperature)
        return factor

    def temperature(self, rise: Any, bulk: float) -> Any:
        """Temperature T of the contact [K], the lowest solution of T = bulk + µ(T)·rise.

        `rise` is per unit friction [K], and already includes the friction's dependence on velocity.
        Where µ rises too steeply for a solution, T − bulk grows as rise^(1/0.3) instead.

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
        nodes, limits = self._rises_at_nodes(bulk)
        frictions = self.at(temperature=nodes)
        above = np.clip(np.searchsorted(limits, rise), 1, len(nodes) - 1)
        low, high = nodes[above - 1], nodes[above]
        slope = (frictions[above] - frictions[above - 1]) / (high - low)
        at_bulk = frictions[above - 1] + slope * (bulk - low)
        ratio = np.minimum(rise / np.where(above > 1, limits[above - 1], np.inf), _FARTHEST)
        steep = (low - bulk) * ratio ** (1 / _LEAST)
        left = 1 - slope * rise
        own = at_bulk * rise / np.where(left > 0, left, np.inf)
        is_steep = (above > 1) & ((left <= 0) | (at_bulk <= 0) | (own > steep))
        return bulk + np.where(is_steep, steep, own)

    def limit(self, temperature: Any, bulk: float) -> Any:
        """Rise above `bulk` per unit friction at which the contact reaches a `temperature` [K].

        It is infinite if the coefficient is 0.
        """
        if self.coefficient == 0:
            return np.full(np.shape(temperature), np.inf)[()]
        if not self.by_temperature:
            return (temperature - bulk) / self.coefficient
        nodes, limits = self._rises_at_nodes(bulk)
        below = np.clip(np.searchsorted(nodes, temperature) - 1, 0, len(nodes) - 1)
        above, low = temperature - bulk, np.where(below > 0, nodes[below] - bulk, np.inf)
        steep = limits[below] * (np.maximum(above, 0.0) / low) ** _LEAST
        return np.maximum(above / self.at(temperature=temperature), steep)[()]

    def sensitivity(self, temperature: float, bulk: float) -> float:
        """Derivative of the contact temperature by ln(r) [K], with the rise r per unit friction.

        It is taken at a `temperature` of the contact [K].
        """
        if not self.by_temperature or self.coefficient == 0:
            return temperature - bulk
        rise = self.limit(temperature, bulk) * (1 + np.array([0.0, 1e-6]))
        low, high = self.temperature(rise, bulk)
        return float(high - low) / 1e-6

    def highest(self, bulk: float) -> float:
        """Highest friction at temperatures above `bulk` [K], without the factor of velocity."""
        nodes = [bulk, *(node for node, _ in self.by_temperature if node > bulk)]
        return float(np.max(self.at(temperature=np.array(nodes))))

    def steepness(self, bulk: float, hottest: float) -> float:
        """Largest d ln µ/d ln(T − T_b) for temperatures T from `bulk`, T_b, to `hottest` [K].

        Examples
        --------
        >>> jump = Friction(0.1, by_temperature=((390.0, 1.0), (400.0, 2.5)))
        >>> [round(jump.steepness(300.0, hottest), 1) for hottest in (380.0, 400.0)]
        [0.0, 13.5]
        """
        inside = [node for node, _ in self.by_temperature if bulk < node < hottest]
        ends = np.array([bulk, *inside, hottest])
        frictions = self.at(temperature=ends) * np.ones(ends.size)
        slopes = np.diff(frictions) / np.diff(ends)
        parts = [slopes * (side - bulk) / mu for side, mu in _interval_ends(ends, frictions)]
        return float(np.max(parts, initial=0.0))

    def spread(self, bulk: float, hottest: float) -> float:
        """Largest difference of ln µ for temperatures from `bulk` to `hottest` [K]."""
        inside = [node for node, _ in self.by_temperature if bulk < node < hottest]
        logs = np.log(self.at(temperature=np.array([bulk, *inside, hottest])) * 1.0)
        return float(np.ptp(logs))

    def hottest(self, rise: Any, bulk: float) -> Any:
        """Upper bound of the contact temperature [K]: `bulk` + the highest friction · `rise`.

        `rise` is above `bulk` and per unit friction coefficient [K].
        """
        return bulk + self.highest(bulk) * rise

    def _rises_at_nodes(self, bulk: float) -> tuple[Array, Array]:
        """Temperatures of the friction curve from `bulk` on, and rises per unit friction [K].

        Each rise is the one at which the contact reaches the temperature. A last temperature, twice
        the highest of the curve, is added.
        """
        table = [node for node, _ in self.by_temperature if node > bulk]
        last = max(bulk, *table) if table else bulk
        nodes = np.array([bulk, *table, 2 * last])
        above = nodes - bulk
        limits = above / self.at(temperature=nodes)
        for place in range(2, len(nodes)):
            steep = limits[place - 1] * (above[place] / above[place - 1]) ** _LEAST
            limits[place] = max(limits[place], steep)
        return nodes, limits


@dataclass(frozen=True, slots=True)
class SolvedFriction:
    """Input for solving friction and contact temperature together, where each affects the other.

    The solver is `tribo.simulation.coupled_friction.coupled_heat`.

    Attributes
    ----------
    law : Friction
        Coefficient of friction as a function of velocity and temperature.
    bulk_temperature : float
        Temperature of both bodies far from the contact [K].
    criterion : str
        Kind of the criterion, one of `tribo.CRITERIA`.
    share : float
        Wear is severe if more than this share of the contact area is above the critical
        temperature. Used by the criterion "share" alone.
    """

    law: Friction
    bulk_temperature: float
    criterion: str
    share: float


def _interval_ends(temperatures: Array, frictions: Array) -> tuple[tuple[Array, Array], ...]:
    """Split a friction curve's n nodes into the lower and the upper ends of its n − 1 intervals.

    `temperatures` [K] and `frictions` (n,) are in ascending order of temperature. Returns the pair
    (temperatures, frictions) of the lower ends, then the pair of the upper ends.
    """
    return (temperatures[:-1], frictions[:-1]), (temperatures[1:], frictions[1:])
