"""Read files of gear pairs: TOML with units, as for scenes, with all faults in one error."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import replace
from os import PathLike
from pathlib import Path
from typing import Any

from pipeline.gears.involute import Involutes, fitting_distance
from pipeline.gears.pair import Duty, Pair
from pipeline.gears.pairfile import PairFile
from pipeline.gears.rules import warm_duty
from pipeline.paths import user_path
from pipeline.scene.consistency import unknown_material
from pipeline.scene.declare import table_of
from pipeline.scene.document import override_entries, read_document
from pipeline.scene.faults import Faults, SceneFileError
from pipeline.scene.library import resolve_library
from pipeline.scene.parts import material_of, oil_of
from pipeline.sweep.sources import FromLibrary
from pipeline.sweep.tables import entry_at
from tribo import InputError, Oil

_PAIRS = Path(__file__).parent / "pairs"
_BODIES = {"pin": "pinion", "disk": "wheel"}
"""Gear that each body of a scene stands for."""


def shipped_pairs() -> dict[str, Path]:
    """File of each shipped pair, by name."""
    return {path.stem: path for path in sorted(_PAIRS.glob("*.toml"))}


def read_pair(path: str | PathLike[str], overrides: Mapping[str, Any] | None = None) -> Pair:
    """Read the file of a gear pair.

    Parameters
    ----------
    path : str or path
        TOML file, or the name of a shipped pair, such as ``"fzg_a"``. The file may extend another
        file.
    overrides : mapping, optional
        Values that replace entries of the file, by path, such as
        ``{"pinion.roughness": "0.8 um"}``. If they change the duty, also give its temperature.

    Raises
    ------
    SceneFileError
        If the file has faults; the message has a line for each.

    Examples
    --------
    >>> import pipeline.gears
    >>> pair = pipeline.gears.read_pair("fzg_a", {"pinion.roughness": "0.8 um"})
    >>> pair.gears.teeth, pair.duty.torque
    ((16, 24), 372.6)
    """
    given, shipped = user_path(path), shipped_pairs()
    file = shipped.get(str(path), given)
    if not file.exists():
        known = f"there is no such file; give that of a pair, or {' or '.join(shipped)}"
        raise SceneFileError(given, [known])
    faults = Faults()
    document = override_entries(read_document(file, faults), overrides or {}, faults)
    entries = {"friction": {}, "surface": {}} | document.entries()  # each has defaults
    named = {body: entry_at(entries, f"{gear}.material") for body, gear in _BODIES.items()}
    bodies = {body: {"material": name} for body, name in named.items()}
    filled, sources = resolve_library(entries | bodies, faults)
    own = {k: v for k, v in filled.items() if k not in _BODIES}
    tables: PairFile = table_of(PairFile).read(own, "", faults)
    materials = tables.materials or {}
    for body, gear in _BODIES.items():
        if isinstance(named[body], str) and (why := unknown_material(named[body], materials)):
            faults.refuse(f"{gear}.material", why)
    temperature = tables.temperature
    if temperature and not faults and (temperature.bulk is None) == (temperature.oil is None):
        faults.refuse("temperature", "give either the key bulk (of the teeth) or the key oil")
    duty, bulk = (
        next((k for k, layer in enumerate(document.layers) if entry_at(layer.entries, path)), 0)
        for path in ("duty", "temperature.bulk")
    )
    if temperature and temperature.bulk and duty < bulk:
        faults.refuse(
            "temperature.bulk",
            "the file's value is for its own duty; give temperature.bulk for the other duty, too, "
            "or without=temperature.bulk and temperature.oil, from which it follows",
        )
    if faults:
        raise SceneFileError(given, [*map(document.line, faults)])
    try:
        oil = oil_of(tables.oil) if tables.oil else None
        return replace(_make_pair(tables, oil, filled, sources), notes=tuple(faults.notes))
    except InputError as error:
        raise SceneFileError(given, [str(error)]) from error


def _make_pair(
    tables: PairFile,
    oil: Oil | None,
    written: Mapping[str, Any],
    sources: tuple[FromLibrary, ...],
) -> Pair:
    """Pair of gears made from valid tables; raises an `InputError` if the gears cannot run.

    `written` has the entries in the user's words, `sources` the values from the library.
    """
    mesh, (first, second) = tables.mesh, (tables.pinion, tables.wheel)
    toothing = mesh.module, mesh.pressure_angle, mesh.helix_angle
    teeth, shifts = (first.teeth, second.teeth), (first.profile_shift, second.profile_shift)
    distance = mesh.centre_distance or fitting_distance(*toothing, teeth, shifts)
    clear = [tip_diameter(*toothing[::2], teeth, shifts, distance, gear) for gear in (0, 1)]
    tips = first.tip_diameter or clear[0], second.tip_diameter or clear[1]
    materials, duty, warm = tables.materials or {}, tables.duty, tables.temperature
    pair = Pair(
        title=tables.title or f"{teeth[0]} and {teeth[1]} teeth",
        file=tables,
        gears=Involutes(*toothing, teeth, shifts, distance, tips, mesh.face_width),
        materials=(material_of(materials[first.material]), material_of(materials[second.material])),
        oil=oil,
        duty=Duty(duty.torque, duty.speed, warm.bulk or warm.oil or math.nan, duty.load_factor),
        written=written,
        sources=sources,
    )
    return replace(pair, duty=warm_duty(pair, duty.torque, duty.speed, warm.bulk))


def tip_diameter(
    module: float,
    helix_angle: float,
    teeth: tuple[int, int],
    profile_shifts: tuple[float, float],
    centre_distance: float,
    gear: int,
) -> float:
    """Tip diameter that keeps the clearance of the basic rack [m].

    da = d + 2 m (1 + y − x'), with the profile shift x' of the other gear; y m is the increase of
    the centre distance due to the shifts (ISO 21771:2007). The module m is in metres, the helix
    angle in radians, and `gear` is 0 for the pinion, 1 for the wheel.

    Examples
    --------
    >>> f"{tip_diameter(3e-3, 0.0, (12, 24), (0.6, 0.36), 56.5e-3, 0):.5f}"
    '0.04484'
    """
    transverse = module / math.cos(helix_angle)
    extension = centre_distance - transverse * sum(teeth) / 2
    return transverse * teeth[gear] + 2 * (module + extension - profile_shifts[1 - gear] * module)
