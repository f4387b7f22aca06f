"""Checks between the tables of a scene, as far as the entries in question are sound."""

from __future__ import annotations

from typing import Any

import tribo
from pipeline.scene.faults import Fault
from pipeline.scene.schema import did_you_mean, entry_at, quoted
from pipeline.scene.units import display

Roughness = tribo.SelfAffineRoughness | tribo.MeasuredRoughness


def check_tables(
    found: dict[str, Any],
    fidelity: tribo.Fidelity,
    roughness: Roughness | None,
    faults: list[Fault],
) -> None:
    """Note what does not fit together.

    Parameters
    ----------
    found : dict
        What the format gives of the file; None where an entry is faulty.
    fidelity : tribo.Fidelity
        Numerical choices.
    roughness : tribo.SelfAffineRoughness or tribo.MeasuredRoughness or None
        Surface of the disk.
    faults : list of Fault
        List to which a fault is added for everything that does not fit.
    """
    _check_materials(found, faults)
    _check_pixels(found, fidelity.pixels_per_element, roughness, faults)
    _check_pin(found, faults)
    _check_conditions(found, faults)


def _check_materials(found: dict[str, Any], faults: list[Fault]) -> None:
    materials = found["materials"]
    for body in ("pin", "disk"):
        name = entry_at(found, f"{body}.material")
        if name and materials and name not in materials:
            allowed = " or ".join(map(quoted, materials))
            hint = did_you_mean(name, materials)
            problem = f"{quoted(name)} is not a table of [materials]{hint}; give {allowed}"
            faults.append(Fault(f"{body}.material", problem))


def _check_pixels(
    found: dict[str, Any], block: int, roughness: Roughness | None, faults: list[Fault]
) -> None:
    pixels = entry_at(found, "window.pixels")
    if not pixels:
        return
    given = quoted(list(pixels))
    if any(n % block for n in pixels):
        problem = (
            f"{given} cannot be averaged {block} × {block}; give multiples of {block}, or another "
            "fidelity.pixels_per_element"
        )
        faults.append(Fault("window.pixels", problem))
    if pixels == (1, 1) and isinstance(roughness, tribo.SelfAffineRoughness):
        problem = "[1, 1] cannot be rough; give more pixels, or no disk.roughness"
        faults.append(Fault("window.pixels", problem))
    if isinstance(roughness, tribo.MeasuredRoughness) and roughness.array.shape != pixels:
        rows, columns = roughness.array.shape
        turned = " or transpose it, since its rows follow one another along x,"
        problem = (
            f"the surface has {rows} rows of {columns} heights, window.pixels is {given}; give a "
            f"surface and a window of the same size,{turned if pixels == (columns, rows) else ''} "
            "or cut a patch out with disk.roughness.crop"
        )
        faults.append(Fault("disk.roughness.file", problem))


def _check_pin(found: dict[str, Any], faults: list[Fault]) -> None:
    length, pixels = entry_at(found, "pin.length"), entry_at(found, "window.pixels")
    sides = entry_at(found, "window.pixel_size")
    if length and pixels and sides and length < pixels[1] * sides[1] * (1 - 1e-9):
        problem = (
            f"{display(length, 'mm')} is shorter than the window, which is "
            f"{display(pixels[1] * sides[1], 'mm')} along y; give at least that"
        )
        faults.append(Fault("pin.length", problem))
    ball, periodic_y = entry_at(found, "pin.shape") == "ball", entry_at(found, "window.periodic_y")
    if ball and periodic_y:
        problem = "true does not fit a ball; give false, or leave it out"
        faults.append(Fault("window.periodic_y", problem))
    if entry_at(found, "wear.pattern") == "swept" and (ball or periodic_y is False):
        problem = (
            '"swept" averages along y, which needs a window that is periodic along y, under a '
            'cylinder; give "local"'
        )
        faults.append(Fault("wear.pattern", problem))


def _check_conditions(found: dict[str, Any], faults: list[Fault]) -> None:
    bulk, critical = entry_at(found, "temperature.bulk"), entry_at(found, "temperature.critical")
    if bulk and critical and critical <= bulk:
        problem = (
            f"{display(critical, '°C')} is not above temperature.bulk, {display(bulk, '°C')}; "
            'give a higher one, such as "145 degC"'
        )
        faults.append(Fault("temperature.critical", problem))
    band = entry_at(found, "friction.band")
    if band and band[0] > band[1]:
        problem = f"{quoted(list(band))} falls; give the lower one first"
        faults.append(Fault("friction.band", problem))
