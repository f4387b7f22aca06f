"""How linear the logarithm of the rise is in the logarithm of an uncertain input, at factors of 2.

    python -m tests.promises.linear

A verdict takes the effect of a simulated input from one further case, above its value. Here each
input of `first_try` is halved and doubled: what the line through value and double is off at half.
"""

import math
import sys

import pipeline
from pipeline.scene.uncertain import numeric_entry
from tests.helpers.campaigns import conclude

INPUTS = (
    "wear.specific_wear_rate",
    "materials.steel.thermal_conductivity",
    "materials.steel.specific_heat",
    "materials.steel.hardness",
    "disk.roughness.ra",
    "pin.radius",
)
PLACES = tuple((load, velocity) for load in (200.0, 750.0) for velocity in (1.0, 3.0))
MOST = 0.055  # of the rise: the scatter of specimens that is assumed without tests


def log_rises(sweep):
    """ln of Θ₁₀ above the bulk at each place."""
    found = []
    for place in PLACES:
        verdict = pipeline.run_point(sweep, *place).verdict(sweep.conditions)
        found.append(math.log(verdict.deciding_temperature - sweep.conditions.bulk_temperature))
    return found


def main():
    sweep = pipeline.load_scene("first_try", "standard", {"without": ["measured"]})
    usual, words, worst = log_rises(sweep), [], 0.0
    for path in INPUTS:
        entry = numeric_entry(path, sweep.entries)
        half, double = (
            log_rises(pipeline.load_scene("first_try", "standard", {path: entry.scaled(factor)}))
            for factor in (0.5, 2.0)
        )
        effects = [high - own for high, own in zip(double, usual, strict=True)]
        off = [
            abs(own - low - effect) for own, low, effect in zip(usual, half, effects, strict=True)
        ]
        largest = max(effects, key=abs)
        words.append(f"`{path}` {100 * math.expm1(largest):+.0f} %, off {100 * max(off):.0f} %")
        worst = max(worst, *off)
    return conclude("linear", "; ".join(words), worst <= MOST)


if __name__ == "__main__":
    sys.exit(main())
