"""The disk's surface in a scene: random, on one seed or several, or measured."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import Any, cast

import numpy as np

import tribo
from pipeline.scene.document import Document
from pipeline.scene.faults import Faults, entry_at, quoted
from pipeline.scene.parts import own_of
from pipeline.scene.quantities import display
from pipeline.scene.surfaces import PLAIN, Surface, filled, levelled, oriented, read_surface
from pipeline.sweep.own_laws import SURFACE, Laws
from tribo.types import Array

Roughness = tribo.SelfAffineRoughness | tribo.MeasuredRoughness | tribo.Surface


def realizations_of(tables: dict[str, Any], faults: Faults) -> tuple[int, ...]:
    """Seeds of the random surfaces: those listed, or a number of them from the surface's own on.

    The first becomes the scene's own.
    """
    wanted = entry_at(tables, "sweep.realizations")
    if wanted is None or tables["disk"] is None:
        return ()
    rough = entry_at(tables, "disk.roughness")
    if rough is None or "file" in rough:
        if not faults.touch("disk.roughness"):
            surface = "smooth" if rough is None else "measured"
            asked = wanted if isinstance(wanted, int) else list(wanted)
            faults.note(
                "sweep.realizations",
                f"{quoted(asked)} does not fit a {surface} disk; leave it out, or give a "
                "[disk.roughness] that is made from a seed",
            )
        return ()
    if isinstance(wanted, int):
        first = rough["seed"] or 0
        return tuple(range(first, first + wanted))
    seeds = tuple(sorted(wanted))
    rough["seed"] = seeds[0]
    return seeds


def roughness_of(
    tables: dict[str, Any], document: Document, laws: Laws, faults: Faults
) -> Roughness | None:
    """The disk's roughness; None if there is none, or a faulty one."""
    table, law = entry_at(tables, "disk.roughness"), entry_at(tables, "disk.surface")
    if law:
        if table is not None:
            faults.note("disk.surface", "there is a [disk.roughness], too; leave out one of them")
        if faults.touch("disk.surface"):
            return None
        key, reference, parameters = "disk.surface.law", law["law"], law["parameters"]
        surface: Any = own_of(key, SURFACE, reference, laws, faults, parameters)
        return cast(tribo.Surface | None, surface)
    if table is None or faults.touch("disk.roughness"):
        return None
    if "file" in table:
        folder = document.file_of("disk.roughness.file").parent
        surface = _surface(folder / table["file"], table["height_unit"], faults)
        if surface is None:
            return None
        surface = oriented(surface, table["transpose"], table["flip"])
        heights = _fitted_heights(surface, table, tables["window"], faults)
        levelled_words = ", levelled" if table["level"] else ""
        faults.notes.append(f"disk.roughness.file: {Path(table['file']).name}{levelled_words}")
        return None if heights is None else tribo.MeasuredRoughness(heights)
    length = table["correlation_length"]
    pair = length if isinstance(length, tuple) else (length, length)
    return tribo.SelfAffineRoughness(**{**table, "correlation_length": pair})


def _surface(file: Path, unit: float | None, faults: Faults) -> Surface | None:
    """Read a measured surface; None if that fails."""
    if unit is None and file.suffix.lower() in PLAIN:
        problem = f'missing; {file.suffix} files need a unit of length, such as "um"'
        faults.note("disk.roughness.height_unit", problem)
        return None
    try:
        return read_surface(file, unit)
    except tribo.InputError as error:
        faults.note("disk.roughness.file", " ".join(str(error).split()))
        return None


def _fitted_heights(
    surface: Surface, table: Mapping[str, Any], window: Mapping[str, Any] | None, faults: Faults
) -> Array | None:
    """Heights fit for a scene: cropped, without holes, levelled; None if that is impossible."""
    pixels, sides = ((window or {}).get(key) for key in ("pixels", "pixel_size"))
    if surface.pixel_size and sides and not np.allclose(surface.pixel_size, sides, rtol=0.01):
        size = " × ".join(display(side, "µm") for side in surface.pixel_size)
        problem = f"the pixels of disk.roughness.file are {size}; give those"
        faults.note("window.pixel_size", problem)
    heights = surface.heights
    if table["crop"] is not None and pixels:
        (i, j), (rows, columns) = table["crop"], pixels
        if table["repeat"] != "no":  # as much of it as there is
            left = np.subtract(heights.shape, table["crop"])
            rows, columns = np.minimum(pixels, np.maximum(left, 1)).tolist()
        if i + rows > heights.shape[0] or j + columns > heights.shape[1]:
            faults.note(
                "disk.roughness.crop",
                f"a patch of {rows} × {columns} heights from row {i}, column {j} reaches beyond "
                f"the surface of {heights.shape[0]} × {heights.shape[1]}; give a lower row and "
                "column, or fewer window.pixels",
            )
            return None
        heights = heights[i : i + rows, j : j + columns]
    holes = np.argwhere(~np.isfinite(heights))
    if len(holes):
        i, j = holes[0].tolist()
        if len(holes) == heights.size:
            faults.note("disk.roughness.file", "all heights are missing; give another file")
            return None
        share = f"{len(holes)} of {heights.size} heights ({100 * len(holes) / heights.size:.2g} %)"
        if table["missing"] == "refuse":
            problem = (
                f"{share} are missing, the first at row {i}, column {j} (counted from 0); crop "
                'them off, or give "fill"'
            )
            faults.note("disk.roughness.missing", problem)
            return None
        faults.notes.append(
            f"disk.roughness.file: {share} are missing and were filled from around them"
        )
        heights = filled(heights)
    if table["level"]:
        heights = levelled(heights)
    if table["repeat"] == "no" or not pixels or np.greater_equal(heights.shape, pixels).all():
        return heights
    rows, columns = heights.shape
    is_mirrored = table["repeat"] == "mirror"  # stays continuous; tiles step, but keep their lay
    faults.notes.append(
        f"disk.roughness.file: {rows} × {columns} heights were "
        f"{'mirrored' if is_mirrored else 'tiled'} to fill the window of {pixels[0]} × "
        f"{pixels[1]}, so that the surface repeats itself"
    )
    more = [
        (0, max(0, count - present)) for count, present in zip(pixels, heights.shape, strict=True)
    ]
    return np.pad(heights, more, mode="symmetric" if is_mirrored else "wrap")
