"""Checks between the tables of a scene, as far as the entries in question are sound."""

from __future__ import annotations

import math
from typing import Any

import tribo
from pipeline.scene.corrections import check_corrections
from pipeline.scene.entries import did_you_mean, entry_at, quoted
from pipeline.scene.faults import Fault
from pipeline.scene.library import nearest
from pipeline.scene.quantities import display

Roughness = tribo.SelfAffineRoughness | tribo.MeasuredRoughness | tribo.Surface


def check_tables(
    tables: dict[str, Any],
    fidelity: tribo.Fidelity,
    roughness: Roughness | None,
    faults: list[Fault],
) -> None:
    """Note what does not fit together.

    Parameters
    ----------
    tables : dict
        Tables of the file as the format reads them; None where an entry is faulty.
    fidelity : tribo.Fidelity
        Numerical choices.
    roughness : tribo.SelfAffineRoughness or tribo.MeasuredRoughness or None
        Surface of the disk.
    faults : list of Fault
        List to which a fault is added for everything that does not fit.
    """
    _check_materials(tables, faults)
    _check_pixels(tables, fidelity.pixels_per_element, roughness, faults)
    _check_pin(tables, faults)
    _check_motion(tables, faults)
    _check_conditions(tables, faults)
    _check_measured(tables, faults)
    check_corrections(tables, faults)


def _check_materials(tables: dict[str, Any], faults: list[Fault]) -> None:
    if any(fault.key == "materials" for fault in faults):
        return
    materials = tables["materials"] or {}
    for body in ("pin", "disk"):
        name = entry_at(tables, f"{body}.material")
        if name and name not in materials:
            hint = did_you_mean(name, materials) or f" ({nearest(name, 'materials')})"
            problem = f"{quoted(name)} is neither a table of [materials] nor in the library{hint}"
            choices = " or ".join(map(quoted, materials)) or "one of them, or add a table for it"
            faults.append(Fault(f"{body}.material", f"{problem}; give {choices}"))


def _check_pixels(
    tables: dict[str, Any], block: int, roughness: Roughness | None, faults: list[Fault]
) -> None:
    pixels = entry_at(tables, "window.pixels")
    if not pixels:
        return
    size = quoted(list(pixels))
    if sides := entry_at(tables, "window.pixel_size"):
        try:
            tribo.Grid(pixels, sides)
        except tribo.InputError as error:
            faults.append(Fault("window.pixel_size", str(error)))
    if any(n % block for n in pixels):
        problem = (
            f"{size} cannot be averaged {block} × {block}; give multiples of {block}, or another "
            "fidelity.pixels_per_element"
        )
        faults.append(Fault("window.pixels", problem))
    if pixels == (1, 1) and isinstance(roughness, tribo.SelfAffineRoughness):
        problem = "[1, 1] cannot be rough; give more pixels, or no disk.roughness"
        faults.append(Fault("window.pixels", problem))
    if isinstance(roughness, tribo.MeasuredRoughness) and roughness.array.shape != pixels:
        rows, columns = roughness.array.shape
        turned = " or give disk.roughness.transpose = true, since its rows follow along x,"
        narrow = rows < pixels[0] or columns < pixels[1]
        ending = (
            'or go on with it beyond its ends: disk.roughness.repeat = "mirror"'
            if narrow
            else "or cut a patch out with disk.roughness.crop"
        )
        problem = (
            f"the surface has {rows} rows of {columns} heights, window.pixels is {size}; give a "
            f"surface and a window of the same size,{turned if pixels == (columns, rows) else ''} "
            f"{ending}"
        )
        faults.append(Fault("disk.roughness.file", problem))


def _check_pin(tables: dict[str, Any], faults: list[Fault]) -> None:
    length, pixels = entry_at(tables, "pin.length"), entry_at(tables, "window.pixels")
    sides = entry_at(tables, "window.pixel_size")
    if length and pixels and sides and length < pixels[1] * sides[1] * (1 - 1e-9):
        problem = (
            f"{display(length, 'mm')} is shorter than the window, which is "
            f"{display(pixels[1] * sides[1], 'mm')} along y; give at least that"
        )
        faults.append(Fault("pin.length", problem))
    shape, crown = entry_at(tables, "pin.shape"), entry_at(tables, "pin.crown_radius")
    if shape in ("ball", "crowned") and entry_at(tables, "window.periodic_y"):
        problem = f"true does not fit a {shape} pin; give false, or leave it out"
        faults.append(Fault("window.periodic_y", problem))
    if any(fault.key == "pin.crown_radius" for fault in faults):
        return
    if shape == "crowned" and crown is None:
        problem = 'missing; a crowned pin needs its radius across sliding, such as "100 mm"'
        faults.append(Fault("pin.crown_radius", problem))
    if shape == "ball" and crown is not None:
        problem = f'{display(crown, "mm")} does not fit a ball; give shape = "crowned"'
        faults.append(Fault("pin.crown_radius", problem))


def _check_motion(tables: dict[str, Any], faults: list[Fault]) -> None:
    motion = tables["motion"]
    if motion is None or any(fault.key.startswith("motion.") for fault in faults):
        return
    ratio, entrainment = motion["slide_roll_ratio"], motion["entrainment_velocity"]
    if (ratio is None) == (entrainment is None):
        subject = "neither is" if ratio is None else "both are"
        problem = f"{subject} given; give either slide_roll_ratio or entrainment_velocity"
        faults.append(Fault("motion", problem))
    elif ratio == 0:
        problem = (
            "0 is rolling without a sliding velocity; give another number such as 0.5, or "
            'entrainment_velocity and the velocity "0 m/s"'
        )
        faults.append(Fault("motion.slide_roll_ratio", problem))
    window, radius = tables["window"] or {}, entry_at(tables, "pin.radius")
    pixels, sides = window.get("pixels"), window.get("pixel_size")
    track = motion["track_length"] or (radius and 2 * math.pi * radius)
    if pixels and sides and track and track < pixels[0] * sides[0] * (1 - 1e-9):
        problem = (
            f"{display(track, 'mm')} is shorter than the window, which is "
            f"{display(pixels[0] * sides[0], 'mm')} along x; give at least that"
        )
        faults.append(Fault("motion.track_length", problem))


def _check_conditions(tables: dict[str, Any], faults: list[Fault]) -> None:
    bulk, critical = entry_at(tables, "temperature.bulk"), entry_at(tables, "temperature.critical")
    if isinstance(bulk, dict):
        bulk = None if None in bulk.values() else max(bulk.values())
    if bulk and critical and critical <= bulk:
        problem = (
            f"{display(critical, '°C')} is not above temperature.bulk, {display(bulk, '°C')}; "
            'give a higher one, such as "145 degC"'
        )
        faults.append(Fault("temperature.critical", problem))
    band = entry_at(tables, "friction.band")
    if band and band[0] > band[1]:
        problem = f"{quoted(list(band))} falls; give the lower one first"
        faults.append(Fault("friction.band", problem))


def _check_measured(tables: dict[str, Any], faults: list[Fault]) -> None:
    for table in ("measured", "tested"):
        for number, entry in enumerate(tables[table] or ()):
            if entry and entry["friction_scatter"] is not None and not entry["friction"]:
                scatter = f"{entry['friction_scatter']:g}"
                problem = f"{scatter} needs a measured friction; give it above 0"
                faults.append(Fault(f"{table}[{number}].friction_scatter", problem))
