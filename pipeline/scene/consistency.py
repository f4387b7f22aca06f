"""Checks between the tables of a scene, as far as the entries in question are sound."""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import Any

import tribo
from pipeline.scene.faults import Faults, did_you_mean, entry_at, quoted
from pipeline.scene.library import nearest
from pipeline.scene.quantities import display

Roughness = tribo.SelfAffineRoughness | tribo.MeasuredRoughness | tribo.Surface
Check = Callable[..., str | None]
_RULES: list[tuple[str, tuple[str, ...], Check]] = []


def check_tables(
    tables: dict[str, Any],
    fidelity: tribo.Fidelity,
    roughness: Roughness | None,
    faults: Faults,
) -> None:
    """Note all that does not fit together in tables as the format reads them."""
    _check_materials(tables, faults)
    _check_pixels(tables, fidelity.pixels_per_element, roughness, faults)
    for key, paths, check in _RULES:
        if any(map(faults.touch, paths)):
            continue
        if problem := check(*(entry_at(tables, path) for path in paths)):
            faults.note(key, problem)
    _check_tests(tables, faults)


def _check_materials(tables: dict[str, Any], faults: Faults) -> None:
    if any(fault.key == "materials" for fault in faults):
        return
    materials = tables["materials"] or {}
    for body in ("pin", "disk"):
        name = entry_at(tables, f"{body}.material")
        if name and name not in materials:
            hint = did_you_mean(name, materials) or f" ({nearest(name, 'materials')})"
            problem = f"{quoted(name)} is neither a table of [materials] nor in the library{hint}"
            choices = " or ".join(map(quoted, materials)) or "one of them, or add a table for it"
            faults.note(f"{body}.material", f"{problem}; give {choices}")


def _check_pixels(
    tables: dict[str, Any], block: int, roughness: Roughness | None, faults: Faults
) -> None:
    pixels, sides = entry_at(tables, "window.pixels"), entry_at(tables, "window.pixel_size")
    if not pixels:
        return
    size = quoted(list(pixels))
    if sides:
        try:
            tribo.Grid(pixels, sides)
        except tribo.InputError as error:
            faults.note("window.pixel_size", str(error))
    if any(n % block for n in pixels):
        faults.note(
            "window.pixels",
            f"{size} cannot be averaged {block} × {block}; give multiples of {block}, or another "
            "fidelity.pixels_per_element",
        )
    if pixels == (1, 1) and isinstance(roughness, tribo.SelfAffineRoughness):
        problem = "[1, 1] cannot be rough; give more pixels, or no disk.roughness"
        faults.note("window.pixels", problem)
    if isinstance(roughness, tribo.MeasuredRoughness) and roughness.array.shape != pixels:
        rows, columns = roughness.array.shape
        turned = " or give disk.roughness.transpose = true, since its rows follow along x,"
        narrow = rows < pixels[0] or columns < pixels[1]
        ending = (
            'or go on with it beyond its ends: disk.roughness.repeat = "mirror"'
            if narrow
            else "or cut a patch out with disk.roughness.crop"
        )
        faults.note(
            "disk.roughness.file",
            f"the surface has {rows} rows of {columns} heights, window.pixels is {size}; give a "
            f"surface and a window of the same size,{turned if pixels == (columns, rows) else ''} "
            f"{ending}",
        )


def _check_tests(tables: dict[str, Any], faults: Faults) -> None:
    for table in ("measured", "tested"):
        for number, entry in enumerate(tables[table] or ()):
            if entry and entry["friction_scatter"] is not None and not entry["friction"]:
                scatter = f"{entry['friction_scatter']:g}"
                problem = f"{scatter} needs a measured friction; give it above 0"
                faults.note(f"{table}[{number}].friction_scatter", problem)


def _rule(key: str, *paths: str) -> Callable[[Check], Check]:
    """Register a check: it takes the entries at some paths, and gives the problem of `key`.

    An entry that was left out is None; where one is faulty, there is no check.
    """

    def register(check: Check) -> Check:
        _RULES.append((key, paths, check))
        return check

    return register


def _short_of_window(length: float, pixels: Any, sides: Any, axis: int) -> str | None:
    side = pixels[axis] * sides[axis]
    if length >= side * (1 - 1e-9):
        return None
    return (
        f"{display(length, 'mm')} is shorter than the window, which is {display(side, 'mm')} "
        f"along {'xy'[axis]}; give at least that"
    )


@_rule("pin.length", "pin.length", "window.pixels", "window.pixel_size")
def _pin_length(length: float | None, pixels: Any, sides: Any) -> str | None:
    return _short_of_window(length, pixels, sides, 1) if length else None


@_rule("window.periodic_y", "pin.shape", "window.periodic_y")
def _periodic(shape: str, periodic: bool | None) -> str | None:
    if shape == "cylinder" or not periodic:
        return None
    return f"true does not fit a {shape} pin; give false, or leave it out"


@_rule("pin.crown_radius", "pin.shape", "pin.crown_radius")
def _crown(shape: str, crown: float | None) -> str | None:
    if shape == "crowned" and crown is None:
        return 'missing; a crowned pin needs its radius across sliding, such as "100 mm"'
    if shape == "ball" and crown is not None:
        return f'{display(crown, "mm")} does not fit a ball; give shape = "crowned"'
    return None


def _not_one_given(table: dict[str, Any] | None, *keys: str) -> str | None:
    """Beginning of the problem of a table that has both of two keys, or neither."""
    if table is None or [table[key] for key in keys].count(None) == 1:
        return None
    return "neither is given" if table[keys[0]] is None else "both are given"


@_rule("motion", "motion")
def _motion(motion: dict[str, Any] | None) -> str | None:
    fault = _not_one_given(motion, "slide_roll_ratio", "entrainment_velocity")
    return fault and f"{fault}; give either slide_roll_ratio or entrainment_velocity"


@_rule("motion.slide_roll_ratio", "motion.slide_roll_ratio", "motion.entrainment_velocity")
def _rolling(ratio: float | None, entrainment: float | None) -> str | None:
    if ratio != 0 or entrainment is not None:
        return None
    return (
        "0 is rolling without a sliding velocity; give another number such as 0.5, or "
        'entrainment_velocity and the velocity "0 m/s"'
    )


@_rule("motion.track_length", "motion", "pin.radius", "window.pixels", "window.pixel_size")
def _track(motion: dict[str, Any] | None, radius: float, pixels: Any, sides: Any) -> str | None:
    if motion is None:
        return None
    return _short_of_window(motion["track_length"] or 2 * math.pi * radius, pixels, sides, 0)


@_rule("temperature.critical", "temperature.bulk", "temperature.critical")
def _critical(bulk: Any, critical: float | None) -> str | None:
    warmest = max(bulk.values()) if isinstance(bulk, dict) else bulk
    if critical is None or critical > warmest:
        return None
    return (
        f"{display(critical, '°C')} is not above temperature.bulk, {display(warmest, '°C')}; "
        'give a higher one, such as "145 degC"'
    )


@_rule("friction.band", "friction.band")
def _band(band: tuple[float, float] | None) -> str | None:
    if band is None or band[0] <= band[1]:
        return None
    return f"{quoted(list(band))} falls; give the lower one first"


@_rule("friction.by_velocity", "friction.by_velocity")
def _velocities(measured: tuple[dict[str, float], ...]) -> str | None:
    velocities = [entry["velocity"] for entry in measured]
    twice = sorted({velocity for velocity in velocities if velocities.count(velocity) > 1})
    return f"has {twice[0]:g} m/s twice; give each velocity once" if twice else None


@_rule("friction.coefficient", "friction.coefficient", "friction.by_velocity")
def _scaled(coefficient: float, measured: tuple[Any, ...]) -> str | None:
    if not measured or coefficient > 0:
        return None
    return "0 cannot be scaled by friction.by_velocity; give a typical one, such as 0.1"


@_rule("friction.by_velocity", "friction.by_velocity", "temperature.bulk")
def _proportional(measured: tuple[Any, ...], bulk: Any) -> str | None:
    if not measured or not isinstance(bulk, dict):
        return None
    return (
        "pin and disk have bulk temperatures of their own, and then the rise is not proportional "
        "to friction; give one temperature.bulk, or leave this out"
    )


@_rule("disk.track_length", "disk.track_length", "motion")
def _passes(track: float | None, motion: Any) -> str | None:
    if track is None or motion is None:
        return None
    return (
        "earlier passes are counted under a pin at rest, and the scene has a [motion]; leave out "
        '"disk.track_length" or [motion]'
    )


@_rule("oil", "oil")
def _viscosity(oil: dict[str, Any] | None) -> str | None:
    fault = _not_one_given(oil, "kinematic_viscosity", "dynamic_viscosity")
    return fault and (
        f"kinematic_viscosity, dynamic_viscosity: {fault}; give kinematic_viscosity with a "
        "density, or dynamic_viscosity"
    )


@_rule("oil.density", "oil")
def _density(oil: dict[str, Any] | None) -> str | None:
    if oil is None or oil["kinematic_viscosity"] is None or oil["density"] is not None:
        return None
    return "missing; a kinematic viscosity needs one"
