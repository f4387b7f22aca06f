"""Files of gear pairs: TOML with units, as scenes are, with all faults at once."""

from __future__ import annotations

import math
import re
from collections.abc import Mapping
from os import PathLike
from pathlib import Path
from typing import Annotated as A
from typing import Any

import tribo
from pipeline.gears.involute import Involutes, fitting_distance
from pipeline.gears.pair import Duty, Pair
from pipeline.gears.rules import warm_duty
from pipeline.paths import user_path
from pipeline.scene.declare import List, declared, table_of
from pipeline.scene.document import override_entries, read_document
from pipeline.scene.faults import Faults, SceneFileError, did_you_mean, quoted
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
from pipeline.scene.library import resolve_library
from pipeline.scene.parts import material_of, oil_of
from pipeline.scene.units import TURNS
from pipeline.sweep.about import FromLibrary
from pipeline.sweep.tables import entry_at
from tribo import InputError

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
    return Quantity(example, zero, ends=("0.1 deg", "60 deg"), name="an angle")


TORQUE = Quantity("100 N m", ends=("1e-6 N m", "1e9 N m"), name="a torque")
MODULE = Quantity("4.5 mm", usual=(0.1, 100))
FACE_WIDTH = Quantity("20 mm", usual=(1, 1000))
ROUGHNESS = Quantity("0.35 um", usual=(0, 10))
LOAD_FACTOR = Number(above=0, usual=(0.5, 10))
SPEED = _Speed("1500 rpm", ends=("1e-3 rpm", "1e6 rpm"), name="a speed")


# fmt: off
@declared
class _Gear:
    teeth: A[int, Whole(at_least=4, at_most=10_000), "Number of teeth."]
    profile_shift: A[float, Number(at_least=-2, at_most=3), "Profile shift coefficient x."] = 0.0
    tip_diameter: A[float | None, Quantity("88.77 mm"),
        "Diameter of the tip circle; by default that which keeps the clearance of the rack."] = None
    material: A[str, "Name of its material, here or in the library."]
    roughness: A[float, ROUGHNESS, "Ra of the flanks."]

@declared
class _Mesh:
    module: A[float, MODULE, "Normal module."]
    pressure_angle: A[float, _angle("20 deg"), "Normal pressure angle."] = math.radians(20)
    helix_angle: A[float, _angle("15 deg", zero=True), "Helix angle; 0 of spur gears."] = 0.0
    centre_distance: A[float | None, Quantity("91.5 mm"),
        "By default that at which the profile shifts leave no backlash."] = None
    face_width: A[float, FACE_WIDTH, "Common face width."]
    quality: A[int, Whole(at_least=1, at_most=12), "Flank tolerance class of ISO 1328-1."] = 6

@declared
class _Duty:
    torque: A[float, TORQUE, "Torque on the pinion."]
    speed: A[float, SPEED, "Speed of the pinion."]
    load_factor: A[float, LOAD_FACTOR,
        "Factor of the load: application, dynamics, face load."] = 1.0

@declared
class _Temperature:
    bulk: A[float | None, BULK, "Temperature of the teeth before they meet."] = None
    oil: A[float | None, BULK,
        "Temperature of the oil; `bulk` then follows by ISO/TR 13989-2, Eq. 20."] = None
    critical: A[float | None, CRITICAL,
        "Contact temperature above which the lubricant fails."] = None
    critical_sd: A[float | None, CRITICAL_SD,
        "Its standard deviation, which counts in verdicts."] = None

@declared
class _Friction:
    coefficient: A[float | None, FRICTION,
        "Mean coefficient; by default by ISO/TR 13989-2, Eq. 1."] = None
    lubricant_factor: A[float, Number(above=0),
        "XL of that rule: 1 mineral oil, 0.8 polyalphaolefin, 0.7 polyglycol."] = 1.0

@declared
class _Surface:
    correlation_length: A[tuple[float, float], List(Quantity("4 um"), length=2),
        "Of the roughness, along and across the sliding."] = (4e-6, 4e-6)
    hurst_exponent: A[float, Number(above=0, at_most=1)] = 0.8
    specific_wear_rate: A[float, ANY_WEAR_RATE] = 1.2e-15

@declared
class PairFile:
    """Tables of the file of a pair."""

    title: A[str | None, "A line on the pair."] = None
    mesh: _Mesh
    pinion: _Gear
    wheel: _Gear
    duty: _Duty
    temperature: _Temperature
    friction: _Friction
    oil: Oil | None = None
    materials: dict[str, Material] | None = None
    surface: A[_Surface,
        "What no drawing gives, for the simulation of the rough and worn contact."]
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
    asked = {k: v for k, v in filled.items() if k not in _BODIES}
    tables: PairFile = table_of(PairFile).read(asked, "", faults)
    materials = tables.materials or {}
    for body, gear in _BODIES.items():
        if isinstance(named[body], str) and named[body] not in materials:
            known = ", ".join(map(quoted, materials)) or "a table [materials]"
            faults.refuse(
                f"{gear}.material",
                f"{quoted(named[body])} is neither in the library nor in {known}; give one of it",
            )
    temperature = tables.temperature
    if temperature and not faults and (temperature.bulk is None) == (temperature.oil is None):
        faults.refuse("temperature", "give one of bulk, that of the teeth, and oil")
    duty, bulk = (
        next((k for k, layer in enumerate(document.layers) if entry_at(layer.entries, path)), 0)
        for path in ("duty", "temperature.bulk")
    )
    if temperature and temperature.bulk and duty < bulk:
        faults.refuse(
            "temperature.bulk",
            "that of the file is for its own duty; give temperature.bulk of the other duty, too, "
            "or without=temperature.bulk and temperature.oil, from which it follows",
        )
    oil = oil_of(tables.oil, faults) if not faults else None
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
    tables: PairFile,
    oil: tribo.Oil | None,
    written: Mapping[str, Any],
    sources: tuple[FromLibrary, ...],
) -> Pair:
    """The pair of sound tables; raises an `InputError` for gears that cannot run."""
    mesh, pinion, wheel = tables.mesh, tables.pinion, tables.wheel
    toothing = mesh.module, mesh.pressure_angle, mesh.helix_angle
    teeth = pinion.teeth, wheel.teeth
    shifts = pinion.profile_shift, wheel.profile_shift
    apart = mesh.centre_distance or fitting_distance(*toothing, teeth, shifts)
    first, second = (
        gear.tip_diameter or tip_diameter(*toothing[::2], teeth, shifts, apart, k)
        for k, gear in enumerate((pinion, wheel))
    )
    gears = Involutes(
        **dict(zip(("module", "pressure_angle", "helix_angle"), toothing, strict=True)),
        face_width=mesh.face_width,
        teeth=teeth,
        profile_shifts=shifts,
        centre_distance=apart,
        tip_diameters=(first, second),
    )
    names, materials = (pinion.material, wheel.material), tables.materials or {}
    duty, temperature, friction = tables.duty, tables.temperature, tables.friction
    load = duty.torque, duty.speed
    bulk, warm_oil = temperature.bulk, temperature.oil
    pair = Pair(
        name=name,
        title=tables.title or name,
        gears=gears,
        materials=(material_of(materials[names[0]]), material_of(materials[names[1]])),
        roughness=(pinion.roughness, wheel.roughness),
        duty=Duty(*load, bulk or warm_oil or math.nan, duty.load_factor),
        quality=mesh.quality,
        critical=temperature.critical,
        critical_sd=temperature.critical_sd,
        friction=friction.coefficient,
        lubricant_factor=friction.lubricant_factor,
        oil=oil,
        oil_temperature=warm_oil,
        written={**written, "names": names},
        sources=sources,
        **vars(tables.surface),
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
