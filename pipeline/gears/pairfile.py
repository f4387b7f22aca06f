"""Tables of the file of a gear pair: entries, units, limits and meanings."""

from __future__ import annotations

import math
from typing import Annotated as A
from typing import Any

from pipeline.scene.declare import Declared, List
from pipeline.scene.faults import Faults, quoted
from pipeline.scene.format import (
    ANY_WEAR_RATE,
    BULK,
    CRITICAL,
    CRITICAL_SD,
    FRICTION,
    Material,
    Oil,
)
from pipeline.scene.kinds import Number, Quantity, UnfitError, Whole
from pipeline.scene.units import TURNS


class _Speed(Quantity):
    """Speed of rotation in rpm or rad/s; 1/s is refused, as it may mean turns or radians."""

    def _read(self, value: Any, place: str, faults: Faults) -> float:
        if isinstance(value, str) and not any(unit in value for unit in (*TURNS, "rad/s")):
            raise UnfitError(f"{quoted(value)} is not in rpm or rad/s")
        return super()._read(value, place, faults)


def _angle(example: str, zero: bool = False) -> Quantity:
    return Quantity(example, zero, ends=("0.1 deg", "60 deg"), name="an angle")


TORQUE = Quantity("100 N m", ends=("1e-6 N m", "1e9 N m"), name="a torque")
LOAD_FACTOR = Number(above=0, usual=(0.5, 10))
SPEED = _Speed("1500 rpm", ends=("1e-3 rpm", "1e6 rpm"), name="a speed")


# fmt: off
class Gear(Declared):
    """Data of one gear in the file of a pair."""

    teeth: A[int, Whole(at_least=4, at_most=10_000), "Number of teeth."]
    profile_shift: A[float, Number(at_least=-2, at_most=3), "Profile shift coefficient x."] = 0.0
    tip_diameter: A[float | None, Quantity("88.77 mm"),
        "Diameter of the tip circle; by default that which keeps the clearance of the rack."] = None
    material: A[str, "Name of its material, here or in the library."]
    roughness: A[float, Quantity("0.35 um", usual=(0, 10)), "Ra of the flanks."]

class Toothing(Declared):
    """Geometry of the teeth that both gears share."""

    module: A[float, Quantity("4.5 mm", usual=(0.1, 100)), "Normal module."]
    pressure_angle: A[float, _angle("20 deg"), "Normal pressure angle."] = math.radians(20)
    helix_angle: A[float, _angle("15 deg", zero=True), "Helix angle; 0 of spur gears."] = 0.0
    centre_distance: A[float | None, Quantity("91.5 mm"),
        "By default that at which the profile shifts leave no backlash."] = None
    face_width: A[float, Quantity("20 mm", usual=(1, 1000)), "Common face width."]
    quality: A[int, Whole(at_least=1, at_most=12), "Flank tolerance class of ISO 1328-1."] = 6

class Load(Declared):
    """Torque and speed of the pinion, and a factor on the load of its teeth."""

    torque: A[float, TORQUE, "Torque on the pinion."]
    speed: A[float, SPEED, "Speed of the pinion."]
    load_factor: A[float, LOAD_FACTOR,
        "Factor on the tooth load: product of those for application, dynamics, face load."] = 1.0

class Temperatures(Declared):
    """Temperatures of teeth, oil and lubricant failure [K]."""

    bulk: A[float | None, BULK, "Temperature of the teeth before they meet."] = None
    oil: A[float | None, BULK,
        "Temperature of the oil; `bulk` then follows by ISO/TR 13989-2, Eq. 20."] = None
    critical: A[float | None, CRITICAL,
        "Contact temperature above which the lubricant fails."] = None
    critical_sd: A[float | None, CRITICAL_SD,
        "Its standard deviation, which counts in verdicts."] = None

class Friction(Declared):
    """Mean coefficient of friction of the mesh, or data to compute it."""

    coefficient: A[float | None, FRICTION,
        "Mean coefficient; by default by ISO/TR 13989-2, Eq. 1."] = None
    lubricant_factor: A[float, Number(above=0),
        "XL of that rule: 1 mineral oil, 0.8 polyalphaolefin, 0.7 polyglycol."] = 1.0

class Surface(Declared):
    """Surface data that drawings do not state; the defaults suit usual flanks."""

    correlation_length: A[tuple[float, float], List(Quantity("4 um"), length=2),
        "Of the roughness, along and across the sliding."] = (4e-6, 4e-6)
    hurst_exponent: A[float, Number(above=0, at_most=1)] = 0.8
    specific_wear_rate: A[float, ANY_WEAR_RATE] = 1.2e-15

class PairFile(Declared):
    """All tables of the file of a gear pair."""

    title: A[str | None, "A line on the pair."] = None
    mesh: Toothing
    pinion: Gear
    wheel: Gear
    duty: Load
    temperature: Temperatures
    friction: Friction
    oil: Oil | None = None
    materials: dict[str, Material] | None = None
    surface: A[Surface,
        "What no drawing gives, for the simulation of the rough and worn contact."]
# fmt: on
