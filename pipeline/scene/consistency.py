"""Checks between the tables of a scene; a check is skipped if one of its entries is faulty."""

from __future__ import annotations

import itertools
import math
from collections import deque
from collections.abc import Callable, Iterator
from dataclasses import replace
from typing import Any

import tribo
from pipeline.quantities import display
from pipeline.scene.faults import Faults, did_you_mean, entry_at, quoted
from pipeline.scene.format import Bulks, Ramp
from pipeline.scene.library import library
from pipeline.scene.parts import DISC, Roughness, track_of
from pipeline.scene.runs import run_faults
from tribo.simulation.pins import sizes_of

_PLATE = "track_length", "capacity", "loss"
"""Entries of a body that is a plate."""
_ALIKE = 0.01  # by which two lengths of one track may differ
Sound = Callable[..., list[Any]]
Misfits = Iterator[tuple[str, ...]]
"""Path of an entry, what is wrong with it, and the path of another one that excludes it, if any."""


def check_tables(
    scene: Any, fidelity: tribo.Fidelity, roughness: Roughness | None, faults: Faults
) -> None:
    """Note every conflict between the tables of a scene."""
    _check_materials(scene, faults)
    _check_pixels(scene, fidelity.pixels_per_element, roughness, faults)

    def sound(*paths: str) -> list[Any]:
        """Entries at some paths; all None where one is faulty."""
        is_faulty = any(map(faults.touch, paths))
        return [None if is_faulty else entry_at(scene, path) for path in paths]

    for misfit in itertools.chain(
        _body_faults(sound), _motion_faults(sound), _track_faults(sound), _condition_faults(sound),
        _step_faults(sound, fidelity), _test_faults(scene),
    ):  # fmt: skip
        faults.refuse(*misfit)


def _check_materials(scene: Any, faults: Faults) -> None:
    if any(fault.key == "materials" for fault in faults):
        return
    materials = scene.materials or {}
    for body in ("pin", "disk"):
        name = entry_at(scene, f"{body}.material")
        if name and name not in materials:
            known = {**materials, **library()["materials"]}
            hint, choices = did_you_mean(name, known), ", ".join(map(quoted, known))
            problem = f"{quoted(name)} is neither a table of [materials] nor in the library{hint}"
            faults.refuse(f"{body}.material", f"{problem}; give {choices}, or add a table for it")


def _check_pixels(scene: Any, block: int, roughness: Roughness | None, faults: Faults) -> None:
    pixels, sides = entry_at(scene, "window.pixels"), entry_at(scene, "window.pixel_size")
    if not pixels:
        return
    size = quoted(list(pixels))
    if sides:
        with faults.at("window.pixel_size"):
            tribo.Grid(pixels, sides)
    if any(n % block for n in pixels):
        faults.refuse(
            "window.pixels",
            f"{size} cannot be averaged {block} × {block}; give multiples of {block}, or another "
            "fidelity.pixels_per_element",
        )
    if pixels == (1, 1) and isinstance(roughness, tribo.SelfAffineRoughness):
        problem = "[1, 1] cannot be rough; give more pixels, or no disk.roughness"
        faults.refuse("window.pixels", problem)
    if isinstance(roughness, tribo.MeasuredRoughness) and roughness.array.shape != pixels:
        nx, ny = roughness.array.shape
        faults.refuse(
            "disk.roughness.file",
            f"the surface has {nx} × {ny} heights along x and y, window.pixels is {size}; give "
            "both the same size: cut out a patch (disk.roughness.crop), exchange x and y "
            "(disk.roughness.transpose = true, since x is along the columns of the file), or go on "
            'beyond the ends (disk.roughness.repeat = "mirror")',
        )


def _short_of_window(key: str, length: float, pixels: Any, sides: Any, axis: int) -> Misfits:
    side = pixels[axis] * sides[axis]
    if length < side * (1 - 1e-9):
        yield (
            key,
            f"{display(length, 'mm')} is shorter than the window, {pixels[axis]} pixels of "
            f"{display(sides[axis], 'µm')} along {'xy'[axis]}; give at least that",
        )


def _body_faults(sound: Sound) -> Misfits:
    length, pixels, sides = sound("pin.length", "window.pixels", "window.pixel_size")
    if length:
        yield from _short_of_window("pin.length", length, pixels, sides, 1)
    shape, periodic = sound("pin.shape", "window.periodic_y")
    if periodic and shape and "length" not in sizes_of(shape):
        yield "window.periodic_y", f"true does not fit a {shape} pin; give false, or leave it out"
    for size in dict.fromkeys(name for other in tribo.PINS for name in sizes_of(other)):
        shape, value = sound("pin.shape", f"pin.{size}")
        is_needed = bool(shape) and size in sizes_of(shape)
        if is_needed and value is None:
            yield f"pin.{size}", f"missing; a {shape} pin needs it"
        if shape and not is_needed and value is not None:
            shapes = " or ".join(f'"{other}"' for other in tribo.PINS if size in sizes_of(other))
            yield f"pin.{size}", f"does not fit a {shape}; leave it out, or give shape = {shapes}"


def _motion_faults(sound: Sound) -> Misfits:
    (motion,) = sound("motion")
    both = "motion.slide_roll_ratio", "motion.entrainment_velocity"
    ratio, entrainment = sound(*both)
    if ratio is not None and entrainment is not None:
        problem = (
            f"{ratio:g} and an entrainment_velocity are given; give one of them, with the other in "
            'without, such as --set "without=motion.slide_roll_ratio"'
        )
        yield both[0], problem, both[1]
    elif motion is not None:
        try:
            tribo.Motion(**vars(motion))
        except tribo.InputError as error:
            yield "motion", str(error)
    motion, radius, pixels, sides = sound(
        "motion", "pin.radius", "window.pixels", "window.pixel_size"
    )
    if motion:
        around = track_of(pin) if (pin := sound("pin")[0]) else None
        track = motion.track_length or around or 2 * math.pi * radius
        yield from _short_of_window("motion.track_length", track, pixels, sides, 0)
    rod, motion, velocities = sound("pin.stem", "motion", "sweep.velocities")
    if rod and motion:
        turning = [tribo.Motion(**vars(motion)).velocities(velocity).pin for velocity in velocities]
        if any(turning):
            yield (
                "pin.stem",
                f"the pin turns, at {max(map(abs, turning)):g} m/s, and is warmed all around it: a "
                "rod between its end and a holder belongs to a pin at rest; leave it out, or leave "
                "out [motion]",
            )


def _track_faults(sound: Sound) -> Misfits:
    for body in ("pin", "disk"):
        yield from _disc_faults(body, sound)
    motion, pin = sound("motion", "pin")
    around = track_of(pin) if pin else None
    if not around:
        return
    key = "pin.diameter" if pin.diameter else "pin.track_length"
    if motion is None:
        yield (
            key,
            "the pin is at rest, so that no earlier turn has warmed it; leave it out, or give a "
            "[motion]",
        )
    elif (worn := motion.track_length) and abs(worn / around - 1) > _ALIKE:
        yield (
            "motion.track_length",
            f"{display(worn, 'mm')} is not the {display(around, 'mm')} of {key}; leave it out",
        )


def _disc_faults(body: str, sound: Sound) -> Misfits:
    """A disc of all that it needs, and said in one way."""
    sizes = dict(zip(DISC, sound(*(f"{body}.{name}" for name in DISC)), strict=True))
    diameter, width, bore = (sizes[name] for name in DISC[:3])
    plate = dict(zip(_PLATE, sound(*(f"{body}.{name}" for name in _PLATE)), strict=True))
    both = [name for name in _PLATE if plate[name] is not None]
    given = [name for name in DISC if sizes[name] is not None]
    if diameter and both:
        yield (
            f"{body}.diameter",
            f"{display(diameter, 'mm')} of a disc and {' and '.join(both)} of a plate are given, "
            "which would count one heat twice; give one of them",
            f"{body}.{both[0]}",
        )
    elif given and not diameter:
        problem = f"belongs to a disc; give {body}.diameter and {body}.width, or leave it out"
        yield f"{body}.{given[0]}", problem
    elif diameter and not width:
        yield f"{body}.width", "missing; a disc of a diameter needs it"
    elif diameter and bore and not bore < diameter:
        problem = f"is not smaller than the diameter, {display(diameter, 'mm')}"
        yield f"{body}.bore", f"{display(bore, 'mm')} {problem}; give less"
    (contact,) = sound("pin.length")
    if diameter and width and contact and width < contact:
        problem = f"is narrower than the contact, {display(contact, 'mm')} of pin.length"
        yield f"{body}.width", f"{display(width, 'mm')} {problem}; give at least that"


def _condition_faults(sound: Sound) -> Misfits:
    bulk, critical = sound("temperature.bulk", "temperature.critical")
    warmest = max(bulk.pin, bulk.disk) if isinstance(bulk, Bulks) else bulk
    if critical is not None and critical <= warmest:
        yield (
            "temperature.critical",
            f"{display(critical, '°C')} is not above temperature.bulk, {display(warmest, '°C')}; "
            'give a higher one, such as "145 degC"',
        )
    (band,) = sound("friction.band")
    if band and band[0] > band[1]:
        yield "friction.band", f"{quoted(list(band))} falls; give the lower one first"
    for name, unit in (("velocity", "m/s"), ("temperature", "°C")):
        coefficient, rows = sound("friction.coefficient", f"friction.by_{name}")
        nodes = [getattr(row, name) for row in rows or ()]
        if twice := sorted({node for node in nodes if nodes.count(node) > 1}):
            yield f"friction.by_{name}", f"has {display(twice[0], unit)} twice; give each once"
        if rows and coefficient == 0:
            yield (
                "friction.coefficient",
                f"0 cannot be scaled by friction.by_{name}; give a typical one, such as 0.1",
            )


def _step_faults(sound: Sound, fidelity: tribo.Fidelity) -> Misfits:
    """Loads and holds that take more steps than anybody waits for."""
    loading, loads, measured, tested = sound("loading", "sweep.loads", "measured", "tested")
    if not isinstance(loading, Ramp):
        return
    ramp = tribo.Ramp(**vars(loading))
    ways = [("loading", ramp, load) for load in (max(loads), min(loads))]
    for name, tests in (("measured", measured), ("tested", tested)):
        for number, test in enumerate(tests or ()):
            if test.hold:
                held = replace(ramp, hold=test.hold)
                ways.append((f"{name}[{number}].hold", held, test.load))
    for key, way, load in ways:
        try:
            stations = way.stations(load, fidelity.increments, fidelity.hold_increments)
            deque(stations, maxlen=0)
        except tribo.InputError as error:
            yield key, str(error)
            return


def _test_faults(scene: Any) -> Misfits:
    for name in ("measured", "tested"):
        for number, test in enumerate(getattr(scene, name) or ()):
            if test and test.friction_scatter is not None and not test.friction:
                problem = "needs a measured friction; give it above 0"
                key = f"{name}[{number}].friction_scatter"
                yield key, f"{test.friction_scatter:g} {problem}"
    if None not in (scene.tested or ()):
        for number, problem in run_faults(scene.tested or ()):
            yield f"tested[{number}].run", problem
