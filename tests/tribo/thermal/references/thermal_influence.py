"""Entries of the thermal influence kernel to 20 digits; writes thermal_influence.json.

After changing the cases run by hand
``python tests/tribo/thermal/references/thermal_influence.py``.
It needs mpmath, which the tests do not: they read the stored numbers.

Each entry is the integral over time of the temperature that the instantaneous sources q dx' dy'
on an element leave at a surface point a time τ later (Carslaw & Jaeger, §10.2; 8 becomes 4 since
the surface is insulated),

    T = ∫₀^t dτ / (4 ρc (πκτ)^{3/2}) ∫∫ exp(−[(x − Vτ − x')² + (y − y')²]/(4κτ)) dx' dy',

summed over the images of the element along periodic axes. The inner integrals are differences of
erf; the outer one is done by mpmath on intervals that halve until two rules agree.
"""

import json
import math
from pathlib import Path

import mpmath as mp

mp.mp.dps = 30

STEEL = {"thermal_conductivity": 45.0, "density": 7800.0, "specific_heat": 470.0}
FREE, LINE, TRACK, FLAT = (False, False), (False, True), (True, False), (True, True)
ELEMENT = (1.632e-6, 1.9e-6)
NEAR_AND_FAR = [(0, 0), (1, 0), (-1, 0), (0, 1), (3, -2), (11, 0), (-11, 5)]
# shape, spacing [m], periodic, velocity [m/s], time [s], offsets in elements
CASES = [
    # early, middle and late; at rest and moving
    *(
        ((12, 7), ELEMENT, axes, velocity, time, NEAR_AND_FAR)
        for axes in (FREE, LINE, TRACK, FLAT)
        for velocity, time in [
            (0.0, 3e-9),
            (0.0, 1e-6),
            (0.0, 1e-4),
            (1.25, 1e-6),
            (1.25, 1e-4),
            (-40.0, 2e-6),
        ]
    ),
    ((12, 7), ELEMENT, LINE, 1.25, 1e-2, [(0, 0), (11, 0), (-11, 5)]),
    ((12, 7), ELEMENT, FREE, 1.25, 5.0, [(0, 0), (11, 0), (-11, 5)]),
    # many elements passed; many periods passed
    ((12, 7), ELEMENT, LINE, 2000.0, 1e-6, [(0, 0), (1, 0), (11, 0), (6, 1)]),
    ((12, 7), ELEMENT, FLAT, 2000.0, 3e-8, [(0, 0), (1, 0), (11, 0), (6, 1)]),
    ((5, 3), ELEMENT, TRACK, 300.0, 1e-6, [(0, 0), (2, 0), (-2, 1)]),
    # slender elements
    ((6, 5), (1e-6, 1e-3), LINE, 1.25, 1e-3, [(0, 0), (1, 0), (5, 0), (-5, 0), (0, 1)]),
    ((6, 5), (1e-3, 1e-6), LINE, 1.25, 1e-3, [(0, 0), (1, 0), (0, 1), (0, 2)]),
]


def strip(position, side, period, spread):
    """∫ exp(−(position − x')²/spread²) dx' over an element and its images, divided by √π/2."""
    if period is None:
        images = [0]
    else:
        nearest = int(mp.nint(-position / period))
        count = int(9 * spread / period) + 1
        images = range(nearest - count, nearest + count + 1)
    total = mp.mpf(0)
    for image in images:
        low, high = (
            (position + image * period if period else position) + h * side / 2 for h in (-1, 1)
        )
        low, high = low / spread, high / spread
        if min(abs(low), abs(high)) > 9 and low * high > 0:
            continue
        # beyond 1, the complement keeps the digits of nearly equal values
        if low > 1:
            total += mp.erfc(low) - mp.erfc(high)
        elif high < -1:
            total += mp.erfc(-high) - mp.erfc(-low)
        else:
            total += mp.erf(high) - mp.erf(low)
    return total * spread


def entry(shape, spacing, periodic, velocity, time, offset):
    """One entry of the kernel [K m²/W]."""
    K, rho, c = (mp.mpf(value) for value in STEEL.values())
    kappa = K / (rho * c)
    dx, dy = (mp.mpf(side) for side in spacing)
    x, y = offset[0] * dx, offset[1] * dy
    period_x, period_y = (
        n * side if wraps else None
        for n, side, wraps in zip(shape, (dx, dy), periodic, strict=True)
    )
    V, t = mp.mpf(velocity), mp.mpf(time)

    def integrand(root):  # τ = root², dτ = 2 root d(root)
        spread = 2 * mp.sqrt(kappa) * root
        inner = strip(x - V * root**2, dx, period_x, spread) * strip(y, dy, period_y, spread)
        return 2 * root * inner * mp.pi / 4 / (4 * rho * c * (mp.pi * kappa * root**2) ** 1.5)

    # From far below any length of the problem, where heat has not crossed half an element.
    start = min(mp.sqrt(t), min(dx, dy) / (40 * mp.sqrt(kappa)), mp.sqrt(dx / (40 * abs(V) + 1e-9)))
    total = start * integrand(start / 2)
    low = start
    while low < mp.sqrt(t):
        # Steps that neither double the spread nor move the source by more than one spread.
        step = low if V == 0 else min(low, mp.sqrt(kappa) / abs(V))
        high = min(low + step, mp.sqrt(t))
        total += mp.quad(integrand, [low, high], method="gauss-legendre", maxdegree=4)
        low = high
    return total


def main():
    """Compute every case and write the file."""
    cases = []
    for *scene, offsets in CASES:
        values = [float(entry(*scene, offset)) for offset in offsets]
        assert all(map(math.isfinite, values))
        keys = ("shape", "spacing", "periodic", "velocity", "time")
        cases.append({**dict(zip(keys, scene, strict=True)), "offsets": offsets, "values": values})
        print(cases[-1])
    target = Path(__file__).with_suffix(".json")
    target.write_text(json.dumps({"material": STEEL, "cases": cases}, indent=1) + "\n")


if __name__ == "__main__":
    main()
