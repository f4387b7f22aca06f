"""Oils: viscosity at any temperature, and the film that would separate smooth surfaces.

The contact itself is computed as if it were dry (boundary lubrication). The film parameter shows
whether that assumption holds.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

from tribo.errors import InputError, require_number, require_pair, require_positive

BOUNDARY = 1.0
"""Film parameter below which the roughness carries the load."""
FULL_FILM = 3.0
"""Film parameter from which the film carries the load."""

_COLD, _WARM = 313.15, 373.15  # temperatures at which viscosities are stated [K]


@dataclass(frozen=True, slots=True)
class Oil:
    """Viscosity and density of a Newtonian lubricant, by temperature and pressure.

    Parameters
    ----------
    viscosities : tuple of float
        Kinematic viscosity at 40 and at 100 °C, falling [m²/s].
    density : float
        Density, taken as the same at all temperatures [kg/m³].
    pressure_coefficient : float or None
        Pressure-viscosity coefficient α [1/Pa]; None if it is not known.

    Examples
    --------
    >>> white = Oil((32e-6, 5e-6), 866.0, 20e-9)
    >>> f"{white.viscosity(313.15):.4f}, {white.viscosity(298.15):.4f} Pa s"
    '0.0277, 0.0593 Pa s'
    """

    viscosities: tuple[float, float]
    density: float
    pressure_coefficient: float | None = None

    def __post_init__(self) -> None:
        require_pair(viscosities=self.viscosities)
        thick, thin = self.viscosities
        require_positive(viscosity=thin, density=self.density)
        require_positive(viscosity=thick)
        if self.pressure_coefficient is not None:
            require_positive(pressure_coefficient=self.pressure_coefficient)
        if not thick > thin:
            raise InputError(
                f"viscosities are {thick:g} and {thin:g} m²/s; they must fall with temperature"
            )
        if thin < 0.31e-6:
            raise InputError(f"viscosity is {thin:g} m²/s; it must be at least 3.1e-07 m²/s")

    def viscosity(self, temperature: float) -> float:
        """Dynamic viscosity η at ambient pressure [Pa s], at a temperature [K].

        log log(ν + 0.7) is linear in log T, with ν [mm²/s] and T [K] (ASTM D341; Walther 1931).
        """
        require_positive(temperature=temperature)
        fraction = math.log(temperature / _COLD) / math.log(_WARM / _COLD)
        cold, warm = (math.log(math.log(1e6 * nu + 0.7)) for nu in self.viscosities)
        # No oil reaches the bound, which prevents overflow of the double exponential.
        kinematic = math.exp(math.exp(min(cold + fraction * (warm - cold), 5.0))) - 0.7
        return 1e-6 * kinematic * self.density


def minimum_line_film(
    speed: float,
    viscosity: float,
    pressure_coefficient: float,
    load_per_length: float,
    radius: float,
    contact_modulus: float,
) -> float:
    """Minimum film thickness between smooth cylinders [m].

    h/R = 2.65 U^0.7 G^0.54 W^−0.13 with U = ηu/(E'R), G = αE', W = w/(E'R), E' = 2E* (Dowson,
    *Elastohydrodynamics*, Proc. IMechE 182, 1968; after Dowson & Higginson): u is the mean velocity
    of both surfaces [m/s], η the viscosity at the inlet [Pa s], α the pressure-viscosity
    coefficient [1/Pa], w the load per length [N/m], R the radius of the cylinder [m], and E* the
    contact modulus [Pa], as from `tribo.contact_modulus`.

    Examples
    --------
    >>> h = minimum_line_film(0.625, 0.055, 20e-9, 750 / 3.4e-3, 2e-3, 115.385e9)
    >>> f"{1e6 * h:.3f} µm"
    '0.111 µm'
    """
    require_positive(load_per_length=load_per_length, radius=radius)
    R, E = radius, 2 * contact_modulus
    U, G, W = viscosity * abs(speed) / (E * R), pressure_coefficient * E, load_per_length / (E * R)
    return float(2.65 * U**0.7 * G**0.54 * W**-0.13 * R)


def minimum_point_film(
    speed: float,
    viscosity: float,
    pressure_coefficient: float,
    normal_load: float,
    radius: float,
    contact_modulus: float,
    ellipticity: float = 1.0,
) -> float:
    """Minimum film thickness between a smooth ball or crowned roller and a plane [m].

    h/R = 3.63 U^0.68 G^0.49 W^−0.073 (1 − e^−0.68k) with U = ηu/(E'R), G = αE', W = F/(E'R²), E' =
    2E* (Hamrock & Dowson, J. Lubr. Technol. 99, 1977): u is the mean velocity of both surfaces
    [m/s], η the viscosity at the inlet [Pa s], α the pressure-viscosity coefficient [1/Pa], F the
    load [N], R the radius in the plane of motion [m], and E* the contact modulus [Pa], as from
    `tribo.contact_modulus`. The ellipticity k is the contact's width across the motion over its
    width along it, and the fit is for 1 to 8. For larger k the result tends to the film of a long
    contact; for an ellipse along the motion it tends to 0.

    Examples
    --------
    >>> h = minimum_point_film(1.0, 0.04, 22e-9, 50.0, 9.525e-3, 115.385e9)
    >>> f"{1e6 * h:.3f} µm"
    '0.143 µm'
    """
    require_positive(normal_load=normal_load, radius=radius)
    R, E = radius, 2 * contact_modulus
    U, G, W = viscosity * abs(speed) / (E * R), pressure_coefficient * E, normal_load / (E * R**2)
    return float(3.63 * U**0.68 * G**0.49 * W**-0.073 * -math.expm1(-0.68 * ellipticity) * R)


def lubrication_regime(film_parameter: float) -> str:
    """Name the lubrication regime of a film parameter Λ, minimum film thickness over roughness Rq.

    Boundary lubrication below 1, full film from 3 on, mixed between (Hamrock, Schmid & Jacobson,
    *Fundamentals of Fluid Film Lubrication*, 2nd ed., §3.7).

    Examples
    --------
    >>> [lubrication_regime(value) for value in (0.33, 1.0, 3.0)]
    ['boundary lubrication', 'mixed lubrication', 'full film, outside the model']
    """
    require_number(film_parameter=film_parameter)
    if math.isnan(film_parameter):
        raise InputError("film_parameter is nan; it must be a number of at least 0")
    if film_parameter < BOUNDARY:
        return "boundary lubrication"
    return "mixed lubrication" if film_parameter < FULL_FILM else "full film, outside the model"
