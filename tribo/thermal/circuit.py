"""The contact as a node between two bodies, each behind a thermal resistance.

Two half-spaces share the heat Q, with the share φ into the pin, so that the contact gets warmer by
θ. They act as two resistances to ground, θ/(φQ) and θ/((1 − φ)Q). The rise with further resistances
in series then follows without solving the contact again.
"""

from __future__ import annotations

from tribo.types import Array

Values = float | Array


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
