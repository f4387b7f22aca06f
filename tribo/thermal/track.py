"""Warming of a body's track by earlier passes, on a half-space or a disc, and its effect.

Two half-spaces share the heat Q, with the share φ into the pin, so that the contact gets warmer by
θ. They act as two resistances to ground, θ/(φQ) and θ/((1 − φ)Q). A warm track is a further
resistance in series. The rise then follows without solving the contact again.
"""

from __future__ import annotations

import functools
import math
from dataclasses import dataclass

import numpy as np
import scipy

from tribo.errors import require_positive
from tribo.types import Array

_SUMMED_PASSES = 400  # number of latest passes summed one by one; earlier passes are integrated
# For an error of 1e-11; modes are used once heat has spread over a quarter of a body.
_IMAGE_COUNT, _MODE_COUNT = 3, 4
_PANEL_RATIO, _PANEL_NODES = 2.0, 5  # ratio of the ages at the ends of a panel, and nodes in each
_ROOT_COUNT = 120
# Value of κt/a² below which the rim is computed as a curved half-space. Its error there is below
# 1e-4, while the series would need more than `_ROOT_COUNT` roots.
_EARLY_FOURIER = 4e-4
Values = float | Array


def track_warming(
    time: float,
    round_trip: float,
    loads: tuple[Array, Array],
    width: float,
    diffusivity: float,
    heat_capacity: float,
    disc: Disc | None = None,
) -> float:
    """Warming of the disk's track by earlier passes under the pin [K].

    The warming is per unit friction coefficient, if the disk takes all heat. In each pass, under
    the load F, an element dx of the track gets the heat F dx over the width B of the pin. The heat
    acts as an instantaneous strip on a half-space. At a time t later the middle of the strip is
    warmer by (Carslaw & Jaeger, *Conduction of Heat in Solids*, 2nd ed., 1959, §10.3)

        θ = F/(B ρc √(πκt)) erf(B/(4√(κt)))

    The result is the sum of θ over all earlier passes. The n-th latest pass was the time t = nT
    ago, with the time T of one revolution. The length of the contact along the track cancels.

    If `disc` gives the disk a finite size, `Disc.rim_response` replaces 1/√(πκt). The two are equal
    at first, but heat that has spread through a finite disk stays there. The disk is insulated
    at its sides, and the track is in its middle: mirror images of the strip are added to the last
    factor of θ. This factor is 1 if the disk is as wide as the pin.

    Parameters
    ----------
    time : float
        Time since the start of the loading at which the warming is computed [s].
    round_trip : float
        Time of one revolution, T [s]; at 0 the warming is 0.
    loads : tuple of ndarray
        Times, ascending [s], and loads at these times [N], linear in between and 0 at time 0.
    width : float
        Width of the pin across the track, B [m].
    diffusivity, heat_capacity : float
        κ [m²/s], and heat capacity per volume, ρc [J/(m³ K)].
    disc : Disc or None
        Size of the disk; None for a half-space.

    Examples
    --------
    The disk of Bosman & de Rooij at 750 N and 1.25 m/s, with a friction coefficient of 0.1:

    >>> ramp = np.array([5.0]), np.array([750.0])
    >>> warming = track_warming(5.0, 0.34 / 1.25, ramp, 3.4e-3, 1.2275e-5, 3.666e6)
    >>> f"{0.1 * warming:.1f} K"
    '2.4 K'

    A steel disk of 100 × 10 mm takes 100 W for a minute, at 1 m/s. The disk warms by 21 K on
    average, and its track by more:

    >>> hold, disc = (np.array([1e-3, 60.0]), np.full(2, 100.0)), Disc(diameter=0.1, width=0.01)
    >>> warming = track_warming(60.0, 0.1 * np.pi, hold, 0.01, 1.2275e-5, 3.666e6, disc)
    >>> f"{warming:.1f} K"
    '28.4 K'
    """
    count = math.floor(time / round_trip) if round_trip > 0 else 0
    if count < 1:
        return 0.0
    knots = np.append(0.0, loads[0]), np.append(0.0, loads[1])

    ages = np.arange(1.0, min(count, _SUMMED_PASSES) + 1) * round_trip
    pass_loads = np.interp(time - ages, *knots)
    body = width, diffusivity, heat_capacity, disc
    warming = float(_remaining_rise(ages, pass_loads, *body).sum())
    if count > _SUMMED_PASSES:
        first_round, last_round = _SUMMED_PASSES + 0.5, count + 0.5
        # Panels end at kinks of the load, and are short compared with the age of their passes.
        kinks = (time - loads[0]) / round_trip
        panel_ends = np.geomspace(
            first_round,
            last_round,
            2 + math.ceil(math.log(last_round / first_round) / math.log(_PANEL_RATIO)),
        )
        ends = np.union1d(panel_ends, kinks[(kinks > first_round) & (kinks < last_round)])
        nodes, weights = np.polynomial.legendre.leggauss(_PANEL_NODES)
        halves = np.diff(ends)[:, None] / 2
        rounds = np.minimum(ends[:-1, None] + halves * (nodes + 1), time / round_trip)
        ages = rounds * round_trip
        pass_loads = np.interp(time - ages, *knots)
        warming += float((halves * weights * _remaining_rise(ages, pass_loads, *body)).sum())
    return warming


def _remaining_rise(
    ages: Array, loads: Array, width: float, diffusivity: float, heat_capacity: float,
    disc: Disc | None,
) -> Array:  # fmt: skip
    """Rise [K] that passes of some `ages` [s] under `loads` [N] still cause in the track.

    It is per unit friction coefficient, if the disk takes all heat.
    """
    spread = np.sqrt(diffusivity * ages)
    strip = strip_response(width, max(width, disc.width) if disc else math.inf, spread)
    if disc:
        strip = strip * disc.rim_response(ages, diffusivity)
        return np.asarray(loads * strip / (width * heat_capacity))
    return np.asarray(loads * strip / (width * heat_capacity * math.sqrt(math.pi) * spread))


def strip_response(width: float, body_width: float, spread: Array) -> Array:
    """Warming in the middle of a heated strip, divided by that of a plane heated all over.

    The heat is released in an instant, as much per area in the strip as on the plane. `spread` is
    √(κt) [m], with the diffusivity κ, at a time t after that instant.

    The strip, of width B = `width` [m], is in the middle of a body that is W = `body_width` wide
    [m] and insulated at its sides; W is infinite for a half-space. The sides act as images of the
    strip at multiples of W. In Fourier space the result is

        B/W (1 + 2 Σ sinc(kB/W) exp(−(2πk/W)²κt)),  k = 1, 2 …

    Examples
    --------
    >>> strip_response(2e-3, np.inf, np.array([1e-4, 1e-2])).round(4).tolist()
    [1.0, 0.0564]
    >>> strip_response(2e-3, 4e-3, np.array([1e-4, 1e-2])).round(4).tolist()
    [1.0, 0.5]
    """
    if math.isinf(body_width):
        half_space: Array = scipy.special.erf(width / (4 * spread))
        return half_space
    share, images = (
        width / body_width,
        body_width * np.arange(-_IMAGE_COUNT, _IMAGE_COUNT + 1)[:, None],
    )
    image_sum = scipy.special.erf((width / 2 + images) / (2 * spread.ravel())).sum(axis=0)
    modes = np.arange(1, _MODE_COUNT + 1)[:, None]
    decay = np.exp(-((2 * math.pi * modes * spread.ravel() / body_width) ** 2))
    mode_sum = share * (1 + 2 * (np.sinc(modes * share) * decay).sum(axis=0))
    response: Array = np.where(4 * spread.ravel() < body_width, image_sum, mode_sum).reshape(
        spread.shape
    )
    return response


@dataclass(frozen=True, slots=True, kw_only=True)
class Disc:
    """A disc that keeps all its heat.

    Parameters
    ----------
    diameter, width : float
        Diameter of the rim, and width of the disc across the track [m].

    Examples
    --------
    >>> print(Disc(diameter=0.1, width=0.01))
    100 × 10 mm
    """

    diameter: float
    width: float

    def __post_init__(self) -> None:
        require_positive(diameter=self.diameter, width=self.width)

    def __str__(self) -> str:
        return f"{1e3 * self.diameter:.4g} × {1e3 * self.width:.4g} mm"

    def rim_response(self, age: Array, diffusivity: float) -> Array:
        """Impulse response of the temperature of the rim [1/m], one value for each age.

        Heat Q per area [J/m²] that is spread over the rim at once warms the rim, after the time t,
        by Q/(ρc) times the response. This is a sum over the modes of a cylinder (Carslaw & Jaeger,
        *Conduction of Heat in Solids*, 2nd ed., 1959, §7.7),

            2/a Σ exp(−βₙ² κt/a²),   J₁(βₙ) = 0.

        Here a is the radius of the rim. At early times the response is 1/√(πκt), as of a
        half-space, corrected for the curvature of the rim.

        Parameters
        ----------
        age : ndarray
            Times t since the heat was spread over the rim, above 0 [s].
        diffusivity : float
            Thermal diffusivity κ [m²/s].

        Examples
        --------
        A disc of 100 × 10 mm, after a tenth of a second and when it has one temperature:

        >>> disc = Disc(diameter=0.1, width=0.01)
        >>> disc.rim_response(np.array([0.1, 600.0]), 1.2275e-5).round(1).tolist()
        [519.4, 40.0]
        """
        radius = self.diameter / 2
        fourier = diffusivity * age / radius**2
        is_early = fourier < _EARLY_FOURIER
        late_fourier = np.where(is_early, 1.0, fourier)[..., None]
        late_response = 2 * np.exp(-(_roots() ** 2) * late_fourier).sum(axis=-1)
        root = np.sqrt(np.where(is_early, fourier, 1.0))
        early_response = 1 / (math.sqrt(math.pi) * root) + 0.5 * scipy.special.erfcx(-0.5 * root)
        response: Array = np.where(is_early, early_response, late_response) / radius
        return response


@functools.cache
def _roots() -> Array:
    """Roots βₙ of J₁, beginning with 0."""
    return np.append(0.0, scipy.special.jn_zeros(1, _ROOT_COUNT))


def circuit_rise(
    rise: Values,
    pin_share: Values,
    heat: Values,
    pin_resistance: Values = 0.0,
    disk_resistance: Values = 0.0,
) -> Values:
    """Mean rise of the contact between bodies with resistances in series [K].

    `rise` is the mean rise θ [K] between half-spaces without these resistances, where the pin takes
    the share φ, `pin_share`, of the `heat` Q [W]. The resistances Rᵢ are in K/W. With the
    conductances h₁ = φQ/θ, h₂ = (1 − φ)Q/θ and hᵢ' = hᵢ/(1 + Rᵢhᵢ), the rise is

        θ' = Q/(h₁' + h₂')

    This is exact if the rises of both bodies are uniform over the contact. For an insulated pin (R₁
    → ∞) the result is θ/(1 − φ).

    Examples
    --------
    A pin that takes a tenth of the heat is then insulated from its holder:

    >>> f"{circuit_rise(90.0, 0.1, 100.0, pin_resistance=1e9):.3f} K"
    '100.000 K'
    """
    into_pin, into_disk = pin_share * heat, (1 - pin_share) * heat
    pin = into_pin / (rise + pin_resistance * into_pin)
    disk = into_disk / (rise + disk_resistance * into_disk)
    return heat / (pin + disk)
