"""Files of gear pairs: TOML with units, as scenes are, with all faults at once."""

from __future__ import annotations

import math
import re
from collections.abc import Mapping
from os import PathLike
from pathlib import Path
from typing import Any

from pipeline.gears.involute import Involutes, fitting_distance
from pipeline.gears.pair import Duty, Pair
from pipeline.gears.rules import warm_duty
from pipeline.paths import user_path
from pipeline.scene.compounds import Entry, List, Optional, Table, Tables
from pipeline.scene.document import override_entries, read_document
from pipeline.scene.faults import Faults, SceneFileError, did_you_mean, entry_at, quoted
from pipeline.scene.format import (
    ANY_WEAR_RATE,
    BULK,
    CRITICAL,
    CRITICAL_SD,
    FRICTION,
    MATERIAL,
    OIL,
    length,
)
from pipeline.scene.kinds import Number, Quantity, Text, UnfitError, Whole
from pipeline.scene.library import resolve_library
from pipeline.scene.parts import oil_of
from pipeline.scene.units import TURNS
from pipeline.sweep.about import FromLibrary
from tribo import InputError, Material, Oil

_PAIRS = Path(__file__).parent / "pairs"


class _Speed(Quantity):
    """A speed of rotation in turns per minute, or rad/s; 1/s alone might be turns or radians."""

    def _read(self, value: Any, place: str, faults: Faults) -> float:
        if isinstance(value, str):
            for turns in TURNS:
                value = value.replace(turns, "rpm")
            if not re.search(r"rpm|rad/s", value):
                raise UnfitError(f"{quoted(value)} is not in rpm or rad/s")
        return super()._read(value, place, faults)


def _angle(example: str, zero: bool = False) -> Quantity:
    return Quantity("an angle", example, zero=zero, ends=("0.1 deg", "60 deg"))


TORQUE = Quantity("a torque", "100 N m", ends=("1e-6 N m", "1e9 N m"))
SPEED = _Speed("a speed", "1500 rpm", ends=("1e-3 rpm", "1e6 rpm"))

# fmt: off
_GEAR = Table({
    "teeth": Entry(Whole(at_least=4, at_most=10_000), "Number of teeth."),
    "profile_shift": Optional(Number(at_least=-2, at_most=3),
        "Profile shift coefficient x.", default=0.0),
    "tip_diameter": Optional(length("88.77 mm"),
        "Diameter of the tip circle; by default that which keeps the clearance of the rack."),
    "material": Entry(Text(), "Name of its material, here or in the library."),
    "roughness": Entry(length("0.35 um"), "Ra of the flanks."),
})
PAIR = Table({
    "title": Optional(Text(), "A line on the pair."),
    "mesh": Entry(Table({
        "module": Entry(length("4.5 mm"), "Normal module."),
        "pressure_angle": Optional(_angle("20 deg"),
            "Normal pressure angle.", default=math.radians(20)),
        "helix_angle": Optional(_angle("15 deg", zero=True),
            "Helix angle; 0 of spur gears.", default=0.0),
        "centre_distance": Optional(length("91.5 mm"),
            "By default that at which the profile shifts leave no backlash."),
        "face_width": Entry(length("20 mm"), "Common face width."),
        "quality": Optional(Whole(at_least=1, at_most=12),
            "Flank tolerance class of ISO 1328-1.", default=6),
    })),
    "pinion": Entry(_GEAR), "wheel": Entry(_GEAR),
    "duty": Entry(Table({
        "torque": Entry(TORQUE, "Torque on the pinion."),
        "speed": Entry(SPEED, "Speed of the pinion."),
        "load_factor": Optional(Number(above=0),
            "Factor of the load: application, dynamics, face load.", default=1.0),
    })),
    "temperature": Entry(Table({
        "bulk": Optional(BULK, "Temperature of the teeth before they meet."),
        "oil": Optional(BULK,
            "Temperature of the oil; `bulk` then follows by ISO/TR 13989-2, Eq. 20."),
        "critical": Optional(CRITICAL, "Contact temperature above which the lubricant fails."),
        "critical_sd": Optional(CRITICAL_SD, "Its standard deviation, which counts in verdicts."),
    })),
    "friction": Optional(Table({
        "coefficient": Optional(FRICTION, "Mean coefficient; by default by ISO/TR 13989-2, Eq. 1."),
        "lubricant_factor": Optional(Number(above=0),
            "XL of that rule: 1 mineral oil, 0.8 polyalphaolefin, 0.7 polyglycol.", default=1.0),
    })),
    "oil": Optional(OIL),
    "materials": Optional(Tables(MATERIAL), default={}),
    "surface": Optional(Table({
        "correlation_length": Optional(List(length("4 um"), length=2),
            "Of the roughness, along and across the sliding.", default=(4e-6, 4e-6)),
        "hurst_exponent": Optional(Number(above=0, at_most=1), default=0.8),
        "specific_wear_rate": Optional(ANY_WEAR_RATE, default=1.2e-15),
    }), "What no drawing gives, for the simulation of the rough and worn contact."),
})
# fmt: on


def shipped_pairs() -> dict[str, Path]:
    """File of each shipped pair, by name."""
    return {path.stem: path for path in sorted(_PAIRS.glob("*.toml"))}


def read_pair(path: str | PathLike[str], overrides: Mapping[str, Any] | None = None) -> Pair:
    """Read the file of a gear pair.

    Parameters
    ----------
    path : str or path
        TOML file, or the name of a shipped pair, such as ``"fzg_a"``. It may extend another file.
    overrides : mapping, optional
        Entries by their paths in place of the file's, such as ``{"pinion.roughness": "0.8 um"}``.
        Another duty needs its temperature, too.

    Raises
    ------
    SceneFileError
        If there is any fault in the file: a line for each.

    Examples
    --------
    >>> import pipeline.gears
    >>> pair = pipeline.gears.read_pair("fzg_a", {"pinion.roughness": "0.8 um"})
    >>> pair.gears.teeth, pair.duty.torque
    ((16, 24), 372.6)
    """
    given = file = user_path(path)
    if not file.exists():
        shipped = shipped_pairs()
        if str(path) not in shipped:
            near = did_you_mean(str(path), shipped)
            known = f"a file of a pair, or one of those that ship: {', '.join(shipped)}"
            raise SceneFileError(file, [f"there is no such file{near}; give {known}"])
        file = shipped[str(path)]
    faults = Faults()
    document = override_entries(read_document(file, faults), overrides or {}, faults)
    entries = {"friction": {}, "surface": {}} | document.entries()  # each has defaults
    named = {body: entry_at(entries, f"{gear}.material") for body, gear in _BODIES.items()}
    bodies = {body: {"material": name} for body, name in named.items()}
    filled, sources = resolve_library(entries | bodies, faults)
    tables = PAIR.read({k: v for k, v in filled.items() if k not in _BODIES}, "", faults)
    materials = tables["materials"] or {}
    for body, gear in _BODIES.items():
        if isinstance(named[body], str) and named[body] not in materials:
            known = ", ".join(map(quoted, materials)) or "a table [materials]"
            faults.refuse(
                f"{gear}.material",
                f"{quoted(named[body])} is neither in the library nor in {known}; give one of it",
            )
    temperature = tables["temperature"]
    if temperature and not faults and (temperature["bulk"] is None) == (temperature["oil"] is None):
        faults.refuse("temperature", "give one of bulk, that of the teeth, and oil")
    has_own = {key.partition(".")[0] for key in overrides or {}}
    if temperature and temperature["bulk"] and "duty" in has_own and "temperature" not in has_own:
        faults.refuse(
            "temperature.bulk",
            "that of the file is for its own duty; give temperature.bulk of the other duty, too, "
            "or without=temperature.bulk and temperature.oil, from which it follows",
        )
    oil = oil_of(tables["oil"], faults) if not faults else None
    if faults:
        raise SceneFileError(given, [*map(document.line, faults)])
    written = {key: filled[key] for key in ("materials", "oil") if filled.get(key) is not None}
    try:
        return _make_pair(file.stem, tables, oil, written, sources)
    except InputError as error:
        raise SceneFileError(given, [str(error)]) from error


_BODIES = {"pin": "pinion", "disk": "wheel"}
"""Gears by the bodies of a scene that stand for them."""


def _make_pair(
    name: str,
    tables: Mapping[str, Any],
    oil: Oil | None,
    written: Mapping[str, Any],
    sources: tuple[FromLibrary, ...],
) -> Pair:
    """The pair of sound tables; raises an `InputError` for gears that cannot run."""
    mesh, both = tables["mesh"], (tables["pinion"], tables["wheel"])
    toothing = mesh["module"], mesh["pressure_angle"], mesh["helix_angle"]
    teeth, shifts = (tuple(gear[key] for gear in both) for key in ("teeth", "profile_shift"))
    apart = mesh["centre_distance"] or fitting_distance(*toothing, teeth, shifts)
    first, second = (
        gear["tip_diameter"] or tip_diameter(*toothing[::2], teeth, shifts, apart, k)
        for k, gear in enumerate(both)
    )
    gears = Involutes(
        **{name: mesh[name] for name in ("module", "pressure_angle", "helix_angle", "face_width")},
        teeth=teeth,
        profile_shifts=shifts,
        centre_distance=apart,
        tip_diameters=(first, second),
    )
    pinion, wheel = (
        Material(**{k: v for k, v in tables["materials"][gear["material"]].items() if k != "like"})
        for gear in both
    )
    duty, temperature, friction = tables["duty"], tables["temperature"], tables["friction"]
    load = duty["torque"], duty["speed"]
    bulk, warm_oil = temperature["bulk"], temperature["oil"]
    pair = Pair(
        name=name,
        title=tables["title"] or name,
        gears=gears,
        materials=(pinion, wheel),
        roughness=(both[0]["roughness"], both[1]["roughness"]),
        duty=Duty(*load, bulk or warm_oil, duty["load_factor"]),
        quality=mesh["quality"],
        critical=temperature["critical"],
        critical_sd=temperature["critical_sd"],
        friction=friction["coefficient"],
        lubricant_factor=friction["lubricant_factor"],
        oil=oil,
        oil_temperature=warm_oil,
        written={**written, "names": (both[0]["material"], both[1]["material"])},
        sources=sources,
        **tables["surface"],
    )
    return pair.changed(duty=warm_duty(pair, *load, bulk))


def tip_diameter(
    module: float,
    helix_angle: float,
    teeth: tuple[int, int],
    profile_shifts: tuple[float, float],
    centre_distance: float,
    gear: int,
) -> float:
    """Diameter of a tip circle that keeps the clearance of the basic rack [m].

    da = d + 2 m (1 + y − x'), x' of the other gear, y m the centre distance less that without
    shifts (ISO 21771:2007).

    Examples
    --------
    >>> f"{tip_diameter(3e-3, 0.0, (12, 24), (0.6, 0.36), 56.5e-3, 0):.5f}"
    '0.04484'
    """
    transverse = module / math.cos(helix_angle)
    apart = centre_distance - transverse * sum(teeth) / 2
    return transverse * teeth[gear] + 2 * (module + apart - profile_shifts[1 - gear] * module)
