"""The stem of the pin, a rod between the heated end and a holder at the bulk temperature."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Self

import numpy as np

from tribo.errors import InputError, require_positive
from tribo.types import Array

_TERMS = 200
_EARLY = 0.05  # κt/L² until which the far end is not felt


@dataclass(frozen=True, slots=True)
class Stem:
    """The rod between the heated end of the pin and its holder.

    Attributes
    ----------
    resistance : float
        Thermal resistance in the steady state [K/W]: for a rod of length L, cross-section A and
        conductivity K, L/(K A).
    settling_time : float
        Time of diffusion along the rod, L²/κ with the diffusivity κ [s]; 0 for a resistance
        without heat capacity.

    Examples
    --------
    >>> Stem.rod(5e-3, 13.6e-6, thermal_conductivity=45.0, thermal_diffusivity=1.2275e-5)
    Stem(resistance=8.169..., settling_time=2.036...)
    """

    resistance: float
    settling_time: float = 0.0

    def __post_init__(self) -> None:
        require_positive(resistance=self.resistance)
        if not 0 <= self.settling_time < math.inf:
            raise InputError(f"settling_time is {self.settling_time!r}; it must be finite and ≥ 0")

    @classmethod
    def rod(
        cls, length: float, area: float, thermal_conductivity: float, thermal_diffusivity: float
    ) -> Self:
        """Make a stem from a rod's length [m], cross-section [m²], conductivity and diffusivity.

        The conductivity is in W/(m K), the diffusivity in m²/s.
        """
        require_positive(length=length, area=area)
        return cls(length / (thermal_conductivity * area), length**2 / thermal_diffusivity)

    def resistance_under(self, times: Array, loads: Array) -> float:
        """Warming of the heated end at the last time, per heat flow at this time [K/W].

        The heat flow is in proportion to the load F, which is linear between the times [s] and 0 at
        time 0. By Duhamel's theorem this resistance at the last time t is

            R/F(t) Σ [F₀S(t − t₀) − F₁S(t − t₁) + (F₁ − F₀)/(t₁ − t₀) (I(t − t₀) − I(t − t₁))],

        summed over the intervals between successive times t₀ and t₁, with the loads F₀ and F₁. R is
        the steady resistance. S is the resistance after a constant flow for a time, divided by R
        (`stem_fraction`), and I the integral of S from 0 to this time.

        Examples
        --------
        Under a load that has grown evenly, a long rod is two thirds as warm as under a constant
        load:

        >>> rod = Stem(1.0, settling_time=1e4)
        >>> grown = rod.resistance_under(np.array([5.0]), np.array([750.0]))
        >>> f"{grown / rod.resistance_under(np.array([1e-9, 5.0]), np.full(2, 750.0)):.3f}"
        '0.667'
        """
        if self.settling_time == 0:
            return self.resistance
        t, load = np.append(0.0, times), np.append(0.0, loads)
        tau = (t[-1] - t) / self.settling_time
        fraction, integral = stem_fraction(tau), _integrated_fraction(tau)
        lasts = np.diff(t) > 0  # a jump of the load takes no time, and brings no heat
        begin, end = load[:-1][lasts], load[1:][lasts]
        warming = begin * fraction[:-1][lasts] - end * fraction[1:][lasts]
        warming += (end - begin) * np.diff(integral)[lasts] / np.diff(tau)[lasts]
        return self.resistance * float(warming.sum() / load[-1])


def stem_fraction(time: float | Array) -> Array:
    """Resistance of a rod after a dimensionless time τ, divided by its steady resistance.

    A rod of length L gets a constant heat flow at one end from time 0, while the other end keeps
    its temperature. The resistance is the warming of the heated end divided by the flow. In the
    steady state it is L/(K A). The result is (Carslaw & Jaeger, *Conduction of Heat in Solids*, 2nd
    ed., 1959, §3.8)

        1 − (8/π²) Σ exp(−n²π²τ/4)/n²,  summed over odd n,  τ = κt/L²

    At short times the result is 2√(τ/π), as in an endless rod.

    Examples
    --------
    >>> stem_fraction(np.array([0.01, 1.0, np.inf])).round(4).tolist()
    [0.1128, 0.9313, 1.0]
    """
    tau = np.asarray(time, dtype=float)
    odd = 2 * np.arange(_TERMS) + 1.0
    series = np.exp(-(odd**2) * (math.pi**2 / 4) * tau[..., None]) / odd**2
    settled: Array = 1 - 8 / math.pi**2 * series.sum(axis=-1)
    # The series needs ever more terms at short times, where the far end is not felt yet.
    return np.where(tau < _EARLY, 2 * np.sqrt(tau / math.pi), settled)


def _integrated_fraction(tau: Array) -> Array:
    """Integral of `stem_fraction` from 0 to the dimensionless times `tau`."""
    odd = 2 * np.arange(_TERMS) + 1.0
    series = np.exp(-(odd**2) * (math.pi**2 / 4) * tau[..., None]) / odd**4
    settled = tau - 1 / 3 + 32 / math.pi**4 * series.sum(axis=-1)
    return np.where(tau < _EARLY, 4 / 3 * np.sqrt(tau**3 / math.pi), settled)
