"""The contact as a node between two bodies, each behind a thermal resistance.

Two half-spaces that share the heat Q so that the contact gets warmer by θ, with the share φ into
the pin, are two resistances to ground, θ/(φQ) and θ/((1 − φ)Q). Whatever lies in series with one of
them, and a bulk that earlier heat has warmed, then follows without another solution of the contact.
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
    disk_warming: Values = 0.0,
) -> Values:
    """Mean rise of the contact between bodies with resistances in series [K].

    With θ the mean rise between half-spaces, φ the pin's share of the heat Q [W], the conductances
    h₁ = φQ/θ of the pin and h₂ = (1 − φ)Q/θ of the disk, resistances R₁ and R₂ in series [K/W],
    hᵢ' = hᵢ/(1 + Rᵢhᵢ), and θ₂ the warming of the disk's bulk [K],

        θ' = (Q + h₂'θ₂)/(h₁' + h₂')

    That is exact where both bodies' rises are uniform over the contact. So an insulated pin
    (R₁ → ∞) has θ/(1 − φ).

    Examples
    --------
    A pin that takes a tenth of the heat, behind a perfect insulator:

    >>> f"{circuit_rise(90.0, 0.1, 100.0, pin_resistance=1e9):.3f} K"
    '100.000 K'

    The disk is warmer by 10 K, of which the contact sees what the pin does not conduct away:

    >>> f"{circuit_rise(90.0, 0.1, 100.0, disk_warming=10.0) - 90:.3f} K"
    '9.000 K'
    """
    into_pin, into_disk = pin_share * heat, (1 - pin_share) * heat
    # hᵢ' times θ, so that nothing is divided by a rise of 0
    pin = into_pin * rise / (rise + pin_resistance * into_pin)
    disk = into_disk * rise / (rise + disk_resistance * into_disk)
    return (heat * rise + disk * disk_warming) / (pin + disk)
