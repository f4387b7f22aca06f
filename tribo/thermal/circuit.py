"""The contact as a node between two bodies, each behind a thermal resistance.

Two half-spaces share the heat Q, with the share φ into the pin, so that the contact gets warmer by
θ. They act as two resistances to ground, θ/(φQ) and θ/((1 − φ)Q). The rise with further resistances
in series, or with bulks that earlier heat has warmed, then follows without solving the contact
again.
"""

from __future__ import annotations

from tribo.types import Array

Values = float | Array


def conductances(
    rise: Values,
    pin_share: Values,
    heat: Values,
    pin_resistance: Values = 0.0,
    disk_resistance: Values = 0.0,
) -> tuple[Values, Values]:
    """Thermal conductances into pin and disk [W/K], with resistances in series.

    For half-spaces they are h₁ = φQ/θ and h₂ = (1 − φ)Q/θ, with the mean rise θ [K] and the pin's
    share φ of the heat Q [W]. With resistances R₁ and R₂ in series [K/W], hᵢ' = hᵢ/(1 + Rᵢhᵢ).
    Arrays are taken elementwise.

    Examples
    --------
    >>> [f"{h:.2f}" for h in conductances(90.0, 0.1, 90.0, pin_resistance=10.0)]
    ['0.05', '0.90']
    """
    into_pin, into_disk = pin_share * heat, (1 - pin_share) * heat
    return (
        into_pin / (rise + pin_resistance * into_pin),
        into_disk / (rise + disk_resistance * into_disk),
    )


def circuit_rise(
    rise: Values,
    pin_share: Values,
    heat: Values,
    pin_resistance: Values = 0.0,
    disk_resistance: Values = 0.0,
    pin_warming: Values = 0.0,
    disk_warming: Values = 0.0,
) -> Values:
    """Mean rise of the contact between bodies with resistances in series [K].

    `rise` is the mean rise θ [K] between half-spaces without these resistances, where the pin takes
    the share φ, `pin_share`, of the `heat` Q [W]. The resistances are in K/W. With the conductances
    hᵢ' of `conductances`, and the warming of the bulk of pin (θ₁) and disk (θ₂) [K], the rise is

        θ' = (Q + h₁'θ₁ + h₂'θ₂)/(h₁' + h₂')

    This is exact if the rises of both bodies are uniform over the contact. For an insulated pin (R₁
    → ∞) the result is θ/(1 − φ).

    Examples
    --------
    A pin that takes a tenth of the heat is then insulated from its holder:

    >>> f"{circuit_rise(90.0, 0.1, 100.0, pin_resistance=1e9):.3f} K"
    '100.000 K'

    If the bulk of the disk is warmer by 10 K, the contact is warmer by 9 K:

    >>> f"{circuit_rise(90.0, 0.1, 100.0, disk_warming=10.0) - 90:.3f} K"
    '9.000 K'
    """
    pin, disk = conductances(rise, pin_share, heat, pin_resistance, disk_resistance)
    return (heat + pin * pin_warming + disk * disk_warming) / (pin + disk)
