"""Checks between the tables of a scene; a check is skipped if one of its entries is faulty."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator
from typing import Any

import numpy as np

import tribo
from pipeline.messages import did_you_mean, quoted
from pipeline.quantities import display
from pipeline.scene.contact_estimate import expect_contacts
from pipeline.scene.faults import Fault, Faults
from pipeline.scene.format import Body, StagesTable
from pipeline.scene.library import library
from pipeline.scene.load_stages import stages_of
from pipeline.sweep.case import Case
from tribo.simulation.pins import sizes_of

_LOAD_ROUNDING = 1e-9  # relative error of loads in floating point
_LENGTH_TOLERANCE = 0.01  # relative difference allowed between two lengths of one track
# Least length of a track in contact widths, so that a pass is short compared with the time between
# passes.
_MIN_TRACK_WIDTHS = 10.0
_SIZES = dict.fromkeys(size for shape in tribo.PINS for size in sizes_of(shape))
Misfits = Iterator[tuple[str, str]]
"""Paths of entries that do not fit others, and why."""
_CHECKS: list[tuple[tuple[str, ...], Callable[[Any], Misfits]]] = []
"""Paths of the entries that each check compares, and the check."""


def _check(*paths: str) -> Callable[[Callable[[Any], Misfits]], Callable[[Any], Misfits]]:
    """Decorator: register a check of the entries at `paths`; it runs if they have no fault."""

    def add(find: Callable[[Any], Misfits]) -> Callable[[Any], Misfits]:
        _CHECKS.append((paths, find))
        return find

    return add


def check_tables(scene: Any, faults: Faults) -> None:
    """Add to `faults` each conflict between entries of a scene."""
    for paths, find in _CHECKS:
        if not any(map(faults.touches, paths)):
            faults.extend(Fault(path, problem) for path, problem in find(scene))


def track_faults(scene: Any, case: Case) -> Misfits:
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


@_check("materials", "pin.material", "disk.material")
def _unknown_materials(scene: Any) -> Misfits:
    scene_materials = scene.materials or {}
    for body in ("pin", "disk"):
        if (name := getattr(scene, body).material) and name not in scene_materials:
            materials = {**scene_materials, **library()["materials"]}
            hint, choices = did_you_mean(name, materials), ", ".join(map(quoted, materials))
            problem = (
                f"{quoted(name)} is neither defined under [materials] nor in the library{hint}; "
                f"give {choices}, or add a table for it"
            )
            yield f"{body}.material", problem


@_check("window.pixels", "fidelity.pixels_per_element")
def _unfit_pixels(scene: Any) -> Misfits:
    pixels, block = scene.window.pixels, scene.fidelity.pixels_per_element
    if any(count % block for count in pixels):
        problem = (
            f"{quoted(list(pixels))} cannot be averaged {block} × {block}; give multiples of "
            f"{block}, or change fidelity.pixels_per_element"
        )
        yield "window.pixels", problem


@_check("sweep.realizations", "disk.roughness")
def _realizations_of_a_smooth_disk(scene: Any) -> Misfits:
    realizations = scene.sweep.realizations
    if realizations is not None and scene.disk.roughness is None:
        value = quoted(realizations if isinstance(realizations, int) else list(realizations))
        problem = f"{value} needs a rough disk, [disk.roughness]; give one, or leave this out"
        yield "sweep.realizations", problem


@_check("loading", "sweep.loads", "sweep.steps")
def _loads_without_stage(scene: Any) -> Misfits:
    if not isinstance(scene.loading, StagesTable):
        return
    if scene.sweep.steps == "course":
        problem = "only the onset and the end of each stage are stored; leave it out"
        yield "sweep.steps", problem
    loads = np.array(scene.sweep.loads)
    stages = np.array(stages_of(scene.loading.stages, loads.max())[0])
    ascending = np.append(np.sort(stages), np.inf)
    next_stages = ascending[np.searchsorted(ascending, loads * (1 - _LOAD_ROUNDING))]
    if (unstaged_loads := loads[next_stages > loads * (1 + _LOAD_ROUNDING)]).size:
        stage_list = ", ".join(f"{stage:g}" for stage in stages)
        load = display(unstaged_loads[0], "N")
        yield "sweep.loads", f"{load} is not a load stage; choose from {stage_list} N"


@_check("pin.length", "window.pixels", "window.pixel_size")
def _short_pin(scene: Any) -> Misfits:
    length, side = scene.pin.length, scene.window.pixels[1] * scene.window.pixel_size[1]
    if length and length < side * (1 - 1e-9):
        problem = (
            f"{display(length, 'mm')} is shorter than the window, {display(side, 'mm')} along y; "
            "give at least that"
        )
        yield "pin.length", problem


@_check("pin.shape", *(f"pin.{size}" for size in _SIZES))
def _unfit_sizes(scene: Any) -> Misfits:
    shape = scene.pin.shape
    for size in _SIZES:
        is_given = getattr(scene.pin, size) is not None
        if size in sizes_of(shape) and not is_given:
            yield f"pin.{size}", f"missing; required for a {shape} pin"
        if size not in sizes_of(shape) and is_given:
            shapes = " or ".join(f'"{name}"' for name in tribo.PINS if size in sizes_of(name))
            yield f"pin.{size}", f"does not fit a {shape}; leave it out, or give shape = {shapes}"


@_check(
    "motion", *(f"{body}.{key}" for body in ("pin", "disk") for key in ("diameter", "track_length"))
)
def _unfit_track(scene: Any) -> Misfits:
    for name in ("pin", "disk"):
        body = getattr(scene, name)
        key = f"{name}.diameter" if body.diameter else f"{name}.track_length"
        if not (track := track_length(body)):
            continue
        if scene.motion is None:
            if name == "pin":
                problem = (
                    "has no effect: a stationary pin has no earlier revolutions; remove it, or "
                    "give a [motion]"
                )
                yield key, problem
            continue
        path = f"{name}_track_length"
        length = getattr(scene.motion, path)
        if length and abs(length / track - 1) > _LENGTH_TOLERANCE:
            problem = (
                f"{display(length, 'mm')} is not the {display(track, 'mm')} of {key}; leave it out"
            )
            yield f"motion.{path}", problem


@_check(
    "pin.length",
    *(f"{body}.{key}" for body in ("pin", "disk") for key in ("diameter", "width", "track_length")),
)
def _unfit_bodies(scene: Any) -> Misfits:
    """Find a disc that lacks a size or is too narrow, and a body that is both disc and plate."""
    for name in ("pin", "disk"):
        body, length = getattr(scene, name), scene.pin.length
        if body.diameter and body.track_length:
            problem = (
                "with diameter (disc) and track_length (plate) the same heat would count twice; "
                "give one of them"
            )
            yield f"{name}.diameter", problem
        elif body.width and not body.diameter:
            yield f"{name}.width", f"belongs to a disc; give {name}.diameter, or leave it out"
        elif body.diameter and not body.width:
            yield f"{name}.width", "missing; a disc with a diameter needs a width"
        if body.diameter and body.width and length and body.width < length:
            problem = (
                f"{display(body.width, 'mm')} is narrower than the contact, "
                f"{display(length, 'mm')} of pin.length; give at least that"
            )
            yield f"{name}.width", problem


@_check("temperature.critical", "temperature.bulk")
def _cold_limit(scene: Any) -> Misfits:
    critical, bulk = scene.temperature.critical, scene.temperature.bulk
    if critical is not None and critical <= bulk:
        problem = (
            f"{display(critical, '°C')} is not above temperature.bulk ({display(bulk, '°C')}); "
            'give a higher one, such as "145 degC"'
        )
        yield "temperature.critical", problem


@_check("friction")
def _unfit_friction(scene: Any) -> Misfits:
    friction = scene.friction
    if friction.band and friction.band[0] > friction.band[1]:
        yield "friction.band", f"{quoted(list(friction.band))} falls; give the lower one first"


def track_length(body: Body) -> float | None:
    """Length of the track around a body [m]: the rim of a disc, or the given value, or None."""
    return math.pi * body.diameter if body.diameter else body.track_length


def disc_of(body: Body) -> tribo.Disc | None:
    """The disc that a body is; None if it is none, or a size is missing."""
    if body.diameter and body.width:
        return tribo.Disc(diameter=body.diameter, width=body.width)
    return None
