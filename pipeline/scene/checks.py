"""Conflicts between the tables of a scene, whose entries have no faults of their own."""

from __future__ import annotations

import itertools
import math
from collections.abc import Iterator

import numpy as np

import tribo
from pipeline.messages import did_you_mean, quoted
from pipeline.quantities import display
from pipeline.scene.contact_estimate import expect_contacts
from pipeline.scene.format import Body, PinTable, SceneFile, StagesTable, stages_of
from pipeline.scene.library import library
from pipeline.sweep.case import Case
from pipeline.sweep.case_table import LEAST_DISTANCE
from tribo.simulation.pins import sizes_of

_ROUNDING = 1e-9  # relative error of loads and lengths in floating point
_LENGTH_TOLERANCE = 0.01  # relative difference allowed between two lengths of one track
# Least length of a track in contact widths, so that a pass is short compared with the time between
# passes.
_MIN_TRACK_WIDTHS = 10.0
_SIZES = dict.fromkeys(size for shape in tribo.PINS for size in sizes_of(shape))
Misfits = Iterator[tuple[str, str]]
"""Paths of entries that do not fit others, and why."""


def misfits(scene: SceneFile, fidelity: tribo.Fidelity) -> Misfits:
    """Yield the paths of entries that do not fit others, and why."""
    yield from _unknown_materials(scene)
    yield from _unfit_window(scene, fidelity)
    yield from _unfit_sizes(scene)
    yield from _unfit_ends(scene.pin)
    for name, body in (("pin", scene.pin), ("disk", scene.disk)):
        yield from _unfit_disc(scene, name, body)
        yield from _unfit_track(scene, name, body)
    yield from _unfit_stages(scene)
    yield from _unfit_load_factors(scene)
    if (realizations := scene.sweep.realizations) is not None and scene.disk.roughness is None:
        value = quoted(realizations if isinstance(realizations, int) else list(realizations))
        problem = f"{value} needs a rough disk, [disk.roughness]; give one, or leave this out"
        yield "sweep.realizations", problem
    critical, bulk = scene.temperature.critical, scene.temperature.bulk
    if critical is not None and critical <= bulk:
        problem = (
            f"{display(critical, '°C')} is not above temperature.bulk ({display(bulk, '°C')}); "
            'give a higher one, such as "145 degC"'
        )
        yield "temperature.critical", problem
    if scene.friction.band and scene.friction.band[0] > scene.friction.band[1]:
        yield "friction.band", f"{quoted(list(scene.friction.band))} falls; give the lower first"


def _unknown_materials(scene: SceneFile) -> Misfits:
    scene_materials = scene.materials or {}
    for body in ("pin", "disk"):
        if (name := getattr(scene, body).material) not in scene_materials:
            materials = {**scene_materials, **library()["materials"]}
            hint, choices = did_you_mean(name, materials), ", ".join(map(quoted, materials))
            problem = (
                f"{quoted(name)} is neither defined under [materials] nor in the library{hint}; "
                f"give {choices}, or add a table for it"
            )
            yield f"{body}.material", problem


def _unfit_window(scene: SceneFile, fidelity: tribo.Fidelity) -> Misfits:
    pixels, block = scene.window.pixels, fidelity.pixels_per_element
    if any(count % block for count in pixels):
        problem = (
            f"{quoted(list(pixels))} cannot be averaged {block} × {block}; give multiples of "
            f"{block}, or change fidelity.pixels_per_element"
        )
        yield "window.pixels", problem
    length, side = scene.pin.length, pixels[1] * scene.window.pixel_size[1]
    if length and length < side * (1 - _ROUNDING) and scene.pin.ends != "free":
        problem = (
            f"{display(length, 'mm')} is shorter than the window, {display(side, 'mm')} along y; "
            "give at least that"
        )
        yield "pin.length", problem


def _unfit_sizes(scene: SceneFile) -> Misfits:
    shape = scene.pin.shape
    for size in _SIZES:
        is_given = getattr(scene.pin, size) is not None
        if size in sizes_of(shape) and not is_given:
            yield f"pin.{size}", f"missing; required for a {shape} pin"
        if size not in sizes_of(shape) and is_given:
            shapes = " or ".join(f'"{name}"' for name in tribo.PINS if size in sizes_of(name))
            yield f"pin.{size}", f"does not fit a {shape}; leave it out, or give shape = {shapes}"


def _unfit_ends(pin: PinTable) -> Misfits:
    """Find free ends of a pin that has none, and a relief that does not fit the ends."""
    if pin.ends and "length" not in sizes_of(pin.shape):
        yield "pin.ends", f'a {pin.shape} has no ends; leave it out, or give shape = "cylinder"'
    elif pin.relief and not pin.ends:
        problem = 'has no effect in a window that repeats along y; give ends = "free" as well'
        yield "pin.relief", problem
    elif pin.relief and pin.length and pin.relief.length > pin.length / 2:
        problem = (
            f"{display(pin.relief.length, 'mm')} is more than half of pin.length, "
            f"{display(pin.length, 'mm')}; give at most half"
        )
        yield "pin.relief.length", problem


def _unfit_disc(scene: SceneFile, name: str, body: Body) -> Misfits:
    """Find a disc that lacks a size or is too narrow, and a body whose heat would count twice."""
    length = scene.pin.length
    if scene.temperature.includes_earlier_revolutions and (body.diameter or body.track_length):
        problem = "temperature.bulk includes this heat already (includes_earlier_revolutions)"
        key = "diameter" if body.diameter else "track_length"
        yield f"{name}.{key}", f"{problem}; leave out one of the two entries"
    elif body.diameter and body.track_length:
        problem = "the same heat would count twice with track_length (of a plate); give one of them"
        yield f"{name}.diameter", problem
    elif bool(body.width) != bool(body.diameter):
        yield f"{name}.width", "a disc has a diameter and a width; give both, or none"
    if body.diameter and body.width and length and body.width < length:
        problem = (
            f"{display(body.width, 'mm')} is narrower than the contact, "
            f"{display(length, 'mm')} of pin.length; give at least that"
        )
        yield f"{name}.width", problem


def _unfit_track(scene: SceneFile, name: str, body: Body) -> Misfits:
    key = f"{name}.diameter" if body.diameter else f"{name}.track_length"
    if not (track := track_length(body)):
        return
    if scene.motion is None:
        if name == "pin":
            problem = "has no effect on a pin at rest; remove it, or give a [motion]"
            yield key, problem
        return
    length = getattr(scene.motion, f"{name}_track_length")
    if length and abs(length / track - 1) > _LENGTH_TOLERANCE:
        lengths = f"{display(length, 'mm')} is not the {display(track, 'mm')} of {key}"
        yield f"motion.{name}_track_length", f"{lengths}; leave it out"


def _unfit_stages(scene: SceneFile) -> Misfits:
    if not isinstance(scene.loading, StagesTable):
        return
    if scene.sweep.steps == "course":
        problem = "only the onset and the end of each stage are stored; leave it out"
        yield "sweep.steps", problem
    loads = np.array(scene.sweep.loads)
    stages = np.array(stages_of(scene.loading.stages, loads.max())[0])
    is_stage = np.isclose(loads[:, None], stages, rtol=_ROUNDING, atol=0).any(axis=1)
    if not is_stage.all():
        stage_list = ", ".join(f"{stage:g}" for stage in stages)
        load = display(loads[~is_stage][0], "N")
        yield "sweep.loads", f"{load} is not a load stage; choose from {stage_list} N"


def _unfit_load_factors(scene: SceneFile) -> Misfits:
    if not (factors := scene.sweep.load_factors):
        return
    key, listed = "sweep.load_factors", quoted([*factors])
    if scene.sweep.along is None:
        yield key, "has no effect without the rows of sweep.along; leave it out"
    elif 1.0 not in factors:
        yield key, f"{listed} lacks the load of the rows themselves; add 1"
    for low, high in itertools.pairwise(factors):
        if high - low <= LEAST_DISTANCE * high:
            problem = f"{low:.9g} and {high:.9g} differ by less than 0.01 %; give one of them"
            yield key, problem


def track_misfits(scene: SceneFile, case: Case) -> Misfits:
    """Find entries that make a track too short for the model."""
    corrections, width = case.conditions.corrections or tribo.Corrections(), 0.0
    tracks = {"pin": corrections.pin_track, "disk": corrections.track}
    if any(tracks.values()):
        # For smooth bodies, since measuring a surface is slow.
        highest = [max(scene.sweep.loads)], [max(scene.sweep.velocities)]
        width = float(expect_contacts(case.scene, *highest)["contact_width"].max())
    for name, track in tracks.items():
        if track and track.length < _MIN_TRACK_WIDTHS * width:
            key = "diameter" if getattr(scene, name).diameter else "track_length"
            yield (
                f"{name}.{key}",
                f"the track is {display(track.length, 'mm', 4)} long, shorter than "
                f"{_MIN_TRACK_WIDTHS:g} contact widths ({display(width, 'mm', 3)}); give the full "
                f"circumference of the {name}",
            )


def track_length(body: Body) -> float | None:
    """Length of the track around a body [m]: the rim of a disc, or the given value, or None."""
    return math.pi * body.diameter if body.diameter else body.track_length


def disc_of(body: Body) -> tribo.Disc | None:
    """The disc that a body is; None if it is none, or a size is missing."""
    if body.diameter and body.width:
        return tribo.Disc(diameter=body.diameter, width=body.width)
    return None
