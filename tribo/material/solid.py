"""Solids: elasticity, hardness and heat."""

from __future__ import annotations

import math
from dataclasses import dataclass

from tribo.errors import InputError, require_instance, require_number, require_positive


@dataclass(frozen=True, slots=True)
class Material:
    """A homogeneous, isotropic, elastic-perfectly plastic, heat-conducting solid.

    Parameters
    ----------
    elastic_modulus : float
        Young's modulus E [Pa].
    poisson_ratio : float
        Poisson's ratio ν, above −1 and at most 0.5.
    thermal_conductivity : float
        K [W/(m K)].
    density : float
        ρ [kg/m³].
    specific_heat : float
        c [J/(kg K)].
    hardness : float, optional
        Highest pressure that the solid carries, H [Pa]. Infinite, that is purely elastic, if not
        given.

    Examples
    --------
    >>> steel = Material(elastic_modulus=210e9, poisson_ratio=0.3, hardness=6.6e9,
    ...                  thermal_conductivity=45.0, density=7800.0, specific_heat=470.0)
    >>> f"{steel.thermal_diffusivity:.4e} m²/s, {steel.thermal_effusivity:.0f} J/(m² K s^½)"
    '1.2275e-05 m²/s, 12844 J/(m² K s^½)'
    """

    elastic_modulus: float
    poisson_ratio: float
    thermal_conductivity: float
    density: float
    specific_heat: float
    hardness: float = math.inf

    def __post_init__(self) -> None:
        require_number(poisson_ratio=self.poisson_ratio, hardness=self.hardness)
        require_positive(
            elastic_modulus=self.elastic_modulus,
            thermal_conductivity=self.thermal_conductivity,
            density=self.density,
            specific_heat=self.specific_heat,
        )
        if not -1 < self.poisson_ratio <= 0.5:
            raise InputError(
                f"poisson_ratio is {self.poisson_ratio!r}; it must be above -1 and at most 0.5"
            )
        if not self.hardness > 0:
            raise InputError(f"hardness is {self.hardness!r}; it must be greater than 0")

    @property
    def thermal_diffusivity(self) -> float:
        """Thermal diffusivity κ = K/(ρc) [m²/s]."""
        return self.thermal_conductivity / (self.density * self.specific_heat)

    @property
    def thermal_effusivity(self) -> float:
        """Thermal effusivity √(Kρc) [J/(m² K √s)]."""
        return math.sqrt(self.thermal_conductivity * self.density * self.specific_heat)


def contact_modulus(first: Material, second: Material) -> float:
    """Contact modulus E* of two solids [Pa].

    1/E* = (1 − ν₁²)/E₁ + (1 − ν₂²)/E₂ (Johnson, *Contact Mechanics*, Eq. 4.7).

    Examples
    --------
    >>> steel = Material(210e9, 0.3, 45.0, 7800.0, 470.0)
    >>> f"{contact_modulus(steel, steel) / 1e9:.3f} GPa"
    '115.385 GPa'
    """
    require_instance(Material, first=first, second=second)
    compliance = sum((1 - m.poisson_ratio**2) / m.elastic_modulus for m in (first, second))
    return 1 / compliance
