"""How much hotter a worn cylinder is near its sharp ends than in its middle.

The cylinder is smooth, and computed whole: its patch is as long as it is, and does not repeat.
"""

import math
import sys
from dataclasses import dataclass

import numpy as np

import tribo
from tests.helpers.campaigns import conclude, table
from tests.helpers.scenes import STEEL

_STRIP = 1e-4  # width of the strip at an end [m]
_ACROSS, _LONG = 64, 20e-6  # elements across the window, and the length of each [m]
_APART = 0.03  # step of ln(velocity) for the exponent
PAPER, STATED = "2 × 3.4 mm", (0.04, 0.11)
"""The paper's pin, and how much hotter `pipeline.answers.scene_wording` states its ends to be."""
MODULUS = tribo.contact_modulus(STEEL, STEEL)
HEADS = (
    "pin", "N", "m/s", "wear widens it by", "hotter at its ends", "exponent", "severe there at",
)  # fmt: skip


@dataclass(frozen=True)
class Run:
    """A test of a smooth cylinder with a load ramp that wears it."""

    radius: float  # [m]
    length: float  # [m]
    load: float  # [N]
    velocity: float  # [m/s]
    wear_rate: float  # [m²/N]
    seconds: float

    @property
    def widths(self):
        """Widths of the unworn and of the worn contact [m]."""
        pin = tribo.Cylinder(self.radius, self.length, STEEL)
        half_width = pin.hertz(self.load, MODULUS).half_width
        volume = self.wear_rate * self.load * self.velocity * self.seconds / 2
        return 2 * half_width, pin.worn(half_width, volume).width

    def rises(self, ratio=1.0):
        """Rises [K] that a tenth of the contact exceeds, at the ends and in the middle of the pin.

        The velocity is multiplied by `ratio`.
        """
        along = 2 * round(self.length / _LONG / 2)
        sides = 1.35 * self.widths[1] / _ACROSS, self.length / along
        scene = tribo.Scene(
            pin=tribo.Cylinder(self.radius, self.length, STEEL),
            disk=STEEL,
            pixels=tribo.Grid((_ACROSS, along), sides, (False, False)),
            loading=tribo.Ramp(self.load / self.seconds, self.load),
            wear=tribo.Wear(self.wear_rate, "local"),
            fidelity=tribo.Fidelity(pixels_per_element=1, increments=20),
        )
        *_, state = tribo.simulate(scene, self.load, self.velocity * ratio)
        y = np.abs(scene.grid.coordinates(1))
        strips = y > self.length / 2 - _STRIP, y < self.length / 20
        heats = ((state.heat.rise[:, strip], state.pressure[:, strip] > 0) for strip in strips)
        return [float(np.quantile(rise[touch], 0.9)) for rise, touch in heats]

    def row(self, name):
        """Relative excess of the rise at the ends, and a table row on it."""
        end, middle = self.rises()
        exponent = math.log(self.rises(math.exp(_APART))[1] / middle) / _APART
        unworn, worn = self.widths
        critical = (end / middle) ** (-1 / exponent) - 1
        point = f"{self.load:.3g}", f"{self.velocity:.3g}", f"{worn / unworn:.2f} ×"
        effects = f"{end / middle - 1:+.1%}", f"{exponent:.2f}", f"{critical:+.0%}"
        return end / middle - 1, (name, *point, *effects)


def paper():
    """The paper's four transitions, with its wear rate and with a tenth of it."""
    for load, velocity in ((750.0, 1.24), (600.0, 1.56), (400.0, 2.3), (200.0, 3.7)):
        for rate in (1.2e-15, 1.2e-16):
            name = PAPER if rate > 1e-15 else f"{PAPER}, a tenth of the wear rate"
            yield name, Run(2e-3, 3.4e-3, load, velocity, rate, load / 150)


def main():
    """Compute the paper's cylinder."""
    rows, is_right = [], True
    for name, run in paper():
        excess, row = run.row(name)
        rows.append(row)
        print(*row, file=sys.stderr, flush=True)
        if name == PAPER:
            is_right &= STATED[0] <= round(excess, 2) <= STATED[1]
    return conclude("ends", table(HEADS, rows), is_right)


if __name__ == "__main__":
    sys.exit(main())
