"""The disk's surface, as a scene has it: random, on several seeds, or measured.

Every fault is noted with the key of the entry that it is in.
"""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

import tribo
from pipeline.scene.schema import entry_at, quoted
from pipeline.scene.surfaces import PLAIN, Surface, cropped, filled, levelled, read_surface
from pipeline.scene.units import display

__all__ = ["realizations_of", "roughness_of"]


def realizations_of(found: dict[str, Any], faults: list[str]) -> tuple[int, ...]:
    """Seeds of the random surfaces: those listed, or so many from the surface's own seed on.

    The first becomes the scene's own.
    """
    wanted = entry_at(found, "sweep.realizations")
    if wanted is None or found["disk"] is None:
        return ()
    rough = entry_at(found, "disk.roughness")
    if rough is None or "file" in rough:
        surface = "smooth" if rough is None else "measured"
        given = wanted if isinstance(wanted, int) else list(wanted)
        if not any(fault.startswith("disk.roughness") for fault in faults):
            faults.append(
                f"sweep.realizations: {quoted(given)} does not fit a {surface} disk; leave it "
                "out, or give a [disk.roughness] that is made from a seed"
            )
        return ()
    if isinstance(wanted, int):
        first = entry_at(found, "disk.roughness.seed") or 0
        return tuple(range(first, first + wanted))
    seeds = tuple(sorted(wanted))
    rough["seed"] = seeds[0]
    return seeds


def roughness_of(
    found: dict[str, Any], folder: Path, faults: list[str], notes: list[str]
) -> tribo.SelfAffineRoughness | tribo.MeasuredRoughness | None:
    """Make the disk's roughness; None if there is none, or a faulty one."""
    table = entry_at(found, "disk.roughness")
    if table is None:
        return None
    if "file" in table:
        heights = _measured_heights(table, found, folder, faults, notes)
        return None if heights is None else tribo.MeasuredRoughness(heights)
    if None in table.values():
        return None
    length = table["correlation_length"]
    pair = length if isinstance(length, tuple) else (length, length)
    return tribo.SelfAffineRoughness(**{**table, "correlation_length": pair})


def _measured_heights(
    table: Mapping[str, Any],
    found: dict[str, Any],
    folder: Path,
    faults: list[str],
    notes: list[str],
) -> NDArray[np.float64] | None:
    """Read a measured surface, and make it fit: cropped, levelled, without holes."""
    if any(fault.startswith("disk.roughness.") for fault in faults):
        return None
    file, unit = folder / table["file"], table["height_unit"]
    if unit is None and file.suffix.lower() in PLAIN:
        faults.append(
            f"disk.roughness.height_unit: missing; {file.suffix} files need a unit of length, such "
            'as "um"'
        )
        return None
    try:
        surface = read_surface(file, unit)
    except tribo.InputError as error:
        fault = str(error)
    except Exception as error:  # a damaged file makes NumPy raise errors of any kind
        fault = f"{file}: not a plain array of numbers: {error!r}"
    else:
        return _fitted_heights(surface, table, found, faults, notes)
    faults.append(f"disk.roughness.file: {' '.join(fault.split())}")
    return None


def _fitted_heights(
    surface: Surface,
    table: Mapping[str, Any],
    found: dict[str, Any],
    faults: list[str],
    notes: list[str],
) -> NDArray[np.float64] | None:
    pixels, sides = entry_at(found, "window.pixels"), entry_at(found, "window.pixel_size")
    if surface.pixel_size and sides and not np.allclose(surface.pixel_size, sides, rtol=0.01):
        own = " × ".join(display(side, "µm") for side in surface.pixel_size)
        faults.append(f"window.pixel_size: the pixels of disk.roughness.file are {own}; give those")
    heights = surface.heights
    if table["crop"] is not None and pixels:
        try:
            heights = cropped(heights, table["crop"], pixels)
        except tribo.InputError as error:
            faults.append(f"disk.roughness.crop: {error}; give less, or fewer window.pixels")
            return None
    holes = np.argwhere(~np.isfinite(heights))
    if len(holes):
        row, column = holes[0].tolist()
        share = f"{len(holes)} of {heights.size} heights ({100 * len(holes) / heights.size:.2g} %)"
        if table["missing"] == "refuse" or len(holes) == heights.size:
            faults.append(
                f"disk.roughness.missing: {share} are missing, the first at row {row}, column "
                f'{column} (counted from 0); crop them off, or give "fill"'
            )
            return None
        notes.append(f"disk.roughness.file: {share} are missing and were filled from around them")
        heights = filled(heights)
    return levelled(heights) if table["level"] else heights
