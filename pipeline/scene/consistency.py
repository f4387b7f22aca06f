"""Checks between the tables of a scene; a check is skipped if one of its entries is faulty."""

from __future__ import annotations

import math
from collections import deque
from collections.abc import Callable, Collection, Iterator, Mapping
from functools import partial
from typing import Any

import tribo
from pipeline.quantities import display
from pipeline.scene.faults import Faults, did_you_mean, quoted
from pipeline.scene.format import Bulks, Ramp
from pipeline.scene.library import library
from pipeline.scene.parts import DISC, track_of
from pipeline.scene.runs import run_faults
from pipeline.sweep.tables import entry_at
from tribo.simulation.pins import sizes_of

_PLATE = "track_length", "capacity", "loss"
"""Entries of a body that is a plate."""
_ALIKE = 0.01  # by which two lengths of one track may differ
Misfits = Iterator[str | tuple[str, str]]
"""What is wrong with the first entry; or the path of an entry, and words."""
_CHECKS: list[tuple[tuple[str, ...], frozenset[str], Callable[..., Misfits]]] = []
"""Paths of the entries that each check compares, their tables, and the check."""


def _check(*paths: str, **given: Any) -> Callable[[Callable[..., Misfits]], Callable[..., Misfits]]:
    """Compare the entries at some paths, if all are sound, by the function below."""

    def add(find: Callable[..., Misfits]) -> Callable[..., Misfits]:
        tables = frozenset(path.partition(".")[0] for path in paths)
        _CHECKS.append((paths, tables, partial(find, **given)))
        return find

    return add


def check_tables(tables: dict[str, Any], changed: Collection[str], faults: Faults) -> None:
    """Note every conflict between the tables of a scene, of which some have changed.

    With them are ``fidelity``, all numerical choices, and ``surface``, the roughness as it is made.
    """
    if not any(fault.key == "materials" for fault in faults):
        for body in ("pin", "disk"):
            name = entry_at(tables, f"{body}.material")
            if problem := unknown_material(name, tables["materials"] or {}):
                faults.refuse(f"{body}.material", problem)
    for paths, names, find in _CHECKS:
        if names.isdisjoint(changed) or any(map(faults.touch, paths)):
            continue
        for misfit in find(*(entry_at(tables, path) for path in paths)):
            faults.refuse(*((paths[0], misfit) if isinstance(misfit, str) else misfit))


def unknown_material(name: Any, materials: Mapping[str, Any]) -> str:
    """Why a body cannot be of a material; empty if there is a table for it."""
    if not name or name in materials:
        return ""
    known = {**materials, **library()["materials"]}
    hint, choices = did_you_mean(name, known), ", ".join(map(quoted, known))
    problem = f"{quoted(name)} is neither a table of [materials] nor in the library{hint}"
    return f"{problem}; give {choices}, or add a table for it"


@_check("window.pixel_size", "window.pixels")
def _unfit_sides(sides: Any, pixels: Any) -> Misfits:
    yield from _refused(tribo.Grid, pixels, sides)


@_check("window.pixels", "fidelity.pixels_per_element")
def _unfit_pixels(pixels: Any, block: int) -> Misfits:
    if any(n % block for n in pixels):
        words = f"{quoted(list(pixels))} cannot be averaged {block} × {block}; give multiples of"
        yield f"{words} {block}, or another fidelity.pixels_per_element"


@_check("window.pixels", "disk.roughness", "surface")
def _unfit_surface(pixels: Any, _: Any, surface: Any) -> Misfits:
    size = quoted(list(pixels))
    if pixels == (1, 1) and isinstance(surface, tribo.SelfAffineRoughness):
        yield "[1, 1] cannot be rough; give more pixels, or no disk.roughness"
    if isinstance(surface, tribo.MeasuredRoughness) and surface.array.shape != pixels:
        nx, ny = surface.array.shape
        yield (
            "disk.roughness.file",
            f"the surface has {nx} × {ny} heights along x and y, window.pixels is {size}; give "
            "both the same size: cut out a patch (disk.roughness.crop), exchange x and y "
            "(disk.roughness.transpose = true, since x is along the columns of the file), or go on "
            'beyond the ends (disk.roughness.repeat = "mirror")',
        )


def _refused(kind: Any, *args: Any, **values: Any) -> Misfits:
    """What an object of the physics has against its values."""
    try:
        kind(*args, **values)
    except tribo.InputError as error:
        yield str(error)


def _short_of_window(key: str, length: float, pixels: Any, sides: Any, axis: int) -> Misfits:
    if length < pixels[axis] * sides[axis] * (1 - 1e-9):
        window = f"{pixels[axis]} pixels of {display(sides[axis], 'µm')} along {'xy'[axis]}"
        words = f"{display(length, 'mm')} is shorter than the window, {window}; give at least that"
        yield key, words


@_check("pin.length", "window.pixels", "window.pixel_size")
def _short_pin(length: Any, pixels: Any, sides: Any) -> Misfits:
    if length:
        yield from _short_of_window("pin.length", length, pixels, sides, 1)


_SIZES = dict.fromkeys(size for shape in tribo.PINS for size in sizes_of(shape))


@_check("pin.shape", *(f"pin.{size}" for size in _SIZES))
def _unfit_sizes(shape: str, *values: Any) -> Misfits:
    for size, value in zip(_SIZES, values, strict=True):
        is_needed = size in sizes_of(shape)
        if is_needed and value is None:
            yield f"pin.{size}", f"missing; a {shape} pin needs it"
        if not is_needed and value is not None:
            shapes = " or ".join(f'"{other}"' for other in tribo.PINS if size in sizes_of(other))
            yield f"pin.{size}", f"does not fit a {shape}; leave it out, or give shape = {shapes}"


@_check("motion")
def _unfit_motion(motion: Any) -> Misfits:
    if motion is not None:
        yield from _refused(tribo.Motion, **vars(motion))


@_check("motion", "pin.diameter", "pin.track_length")
def _unfit_track(motion: Any, diameter: Any, length: Any) -> Misfits:
    around = track_of(diameter, length)
    key = "pin.diameter" if diameter else "pin.track_length"
    if around and motion is None:
        problem = "the pin is at rest, so that no earlier turn has warmed it; leave it out"
        yield key, f"{problem}, or give a [motion]"
    elif around and (worn := motion.track_length) and abs(worn / around - 1) > _ALIKE:
        problem = f"is not the {display(around, 'mm')} of {key}; leave it out"
        yield "motion.track_length", f"{display(worn, 'mm')} {problem}"


@_check(
    "motion", "pin.diameter", "pin.track_length", "pin.radius", "window.pixels",
    "window.pixel_size",
)  # fmt: skip
def _short_track(
    motion: Any, diameter: Any, length: Any, radius: float, pixels: Any, sides: Any
) -> Misfits:
    if motion:
        track = motion.track_length or track_of(diameter, length) or 2 * math.pi * radius
        yield from _short_of_window("motion.track_length", track, pixels, sides, 0)


@_check("pin.stem", "motion", "sweep.velocities")
def _turning_rod(rod: Any, motion: Any, velocities: Any) -> Misfits:
    if not rod or not motion:
        return
    turning = [tribo.Motion(**vars(motion)).velocities(velocity).pin for velocity in velocities]
    if any(turning):
        words = f"the pin turns, at {max(map(abs, turning)):g} m/s, and is warmed all around it"
        yield (
            f"{words}: a rod between its end and a holder belongs to a pin at rest; leave it out, "
            "or leave out [motion]"
        )


@_check(*(f"pin.{name}" for name in (*DISC, *_PLATE, "length")), body="pin")
@_check(*(f"disk.{name}" for name in (*DISC, *_PLATE)), "pin.length", body="disk")
def _unfit_disc(*values: Any, body: str) -> Misfits:
    """A disc of all that it needs, and said in one way."""
    (diameter, width, bore, *_), contact = values, values[-1]
    known = {k for k, v in zip((*DISC, *_PLATE), values, strict=False) if v is not None}
    both, given = ([name for name in names if name in known] for names in (_PLATE, DISC))
    if diameter and both:
        yield (
            f"{body}.diameter",
            f"{display(diameter, 'mm')} of a disc and {' and '.join(both)} of a plate are given, "
            "which would count one heat twice; give one of them",
        )
    elif given and not diameter:
        problem = f"belongs to a disc; give {body}.diameter and {body}.width, or leave it out"
        yield f"{body}.{given[0]}", problem
    elif diameter and not width:
        yield f"{body}.width", "missing; a disc of a diameter needs it"
    elif diameter and bore and not bore < diameter:
        problem = f"is not smaller than the diameter, {display(diameter, 'mm')}"
        yield f"{body}.bore", f"{display(bore, 'mm')} {problem}; give less"
    if diameter and width and contact and width < contact:
        problem = f"is narrower than the contact, {display(contact, 'mm')} of pin.length"
        yield f"{body}.width", f"{display(width, 'mm')} {problem}; give at least that"


@_check("temperature.critical", "temperature.bulk")
def _cold_limit(critical: Any, bulk: Any) -> Misfits:
    warmest = max(bulk.pin, bulk.disk) if isinstance(bulk, Bulks) else bulk
    if critical is not None and critical <= warmest:
        words = f"{display(critical, '°C')} is not above temperature.bulk, {display(warmest, '°C')}"
        yield f'{words}; give a higher one, such as "145 degC"'


@_check("friction.band")
def _falling_band(band: Any) -> Misfits:
    if band and band[0] > band[1]:
        yield f"{quoted(list(band))} falls; give the lower one first"


@_check("friction.by_velocity", "friction.coefficient", name="velocity", unit="m/s")
@_check("friction.by_temperature", "friction.coefficient", name="temperature", unit="°C")
def _unfit_curve(rows: Any, coefficient: Any, name: str, unit: str) -> Misfits:
    nodes = [getattr(row, name) for row in rows or ()]
    if twice := sorted({node for node in nodes if nodes.count(node) > 1}):
        yield f"has {display(twice[0], unit)} twice; give each once"
    if rows and coefficient == 0:
        words = f"0 cannot be scaled by friction.by_{name}; give a typical one, such as 0.1"
        yield "friction.coefficient", words


@_check("loading", "sweep.loads", "fidelity")
def _many_steps(loading: Any, loads: Any, fidelity: Any) -> Misfits:
    """Loads that take more steps than anybody waits for."""
    if isinstance(loading, Ramp):
        steps = fidelity.increments, fidelity.hold_increments
        ramp = tribo.Ramp(**vars(loading))
        yield from _refused(lambda: deque(ramp.stations(max(loads), *steps), maxlen=0))


@_check("measured", name="measured")
@_check("tested", name="tested")
def _lone_scatter(tests: Any, name: str) -> Misfits:
    for number, test in enumerate(tests or ()):
        if test.friction_scatter is not None and not test.friction:
            problem = f"{test.friction_scatter:g} needs a measured friction; give it above 0"
            yield f"{name}[{number}].friction_scatter", problem


@_check("tested")
def _unlike_runs(tests: Any) -> Misfits:
    for number, problem in run_faults(tests or ()):
        yield f"tested[{number}].run", problem
