"""The stem of the pin, a rod between the heated end and a holder at the bulk temperature."""

from __future__ import annotations

import math

import numpy as np

from tribo.types import Array

_TERMS = 200


def stem_fraction(time: float | Array) -> Array:
    """Resistance of a rod after a dimensionless time τ, over that in the steady state.

    A rod of length L, heated by a constant flow at one end from time 0 and kept at its temperature
    at the other, has a heated end warmer by the flow times the resistance R L/(K A) times

        1 − (8/π²) Σ exp(−n²π²τ/4)/n²,  n = 1, 3, 5 …,  τ = κt/L²

    (Carslaw & Jaeger, *Conduction of Heat in Solids*, 2nd ed., 1959, §3.8). At first it is
    2√(τ/π), that of an endless rod.

    Examples
    --------
    >>> stem_fraction(np.array([0.01, 1.0, np.inf])).round(4).tolist()
    [0.1128, 0.9313, 1.0]
    """
    tau = np.asarray(time, dtype=float)
    odd = 2 * np.arange(_TERMS) + 1.0
    series = np.exp(-np.minimum(odd**2 * (math.pi**2 / 4) * tau[..., None], 700.0)) / odd**2
    settled: Array = 1 - 8 / math.pi**2 * series.sum(axis=-1)
    # The series needs ever more terms at short times, where no end is felt yet.
    return np.where(tau < 0.05, 2 * np.sqrt(tau / math.pi), settled)
