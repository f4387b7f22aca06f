"""Parts of a scene, made from its tables; each is None where its table is missing or faulty."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import numpy as np

import tribo
from pipeline import extras
from pipeline.paths import user_path
from pipeline.scene.faults import Faults, quoted
from pipeline.scene.format import (
    Body,
    EvenStages,
    MaterialTable,
    MeasuredSurfaceTable,
    MotionTable,
    OilTable,
    RampTable,
    Record,
    StagesTable,
    Window,
)
from pipeline.scene.format_of_tests import EvenLevels
from pipeline.scene.table import Column, read_columns
from pipeline.scene.units import si_unit, to_si
from pipeline.sweep.limits import MOST_ROWS
from pipeline.sweep.measurement import Case
from pipeline.sweep.missing import MissingError, MissingSurface
from pipeline.sweep.remarks import FromLibrary
from tribo.loading.ramp import MOST_STEPS
from tribo.loading.record import fault as record_fault
from tribo.simulation.pins import sizes_of
from tribo.surface import array_digest
from tribo.types import Array

Loading = tribo.Ramp | tribo.Stages | tribo.MeasuredLoad
Roughness = tribo.SelfAffineRoughness | tribo.MeasuredRoughness | tribo.Surface
_RECORD = {"time": "s", "load": "N"}
_WRONG_SIZE = (
    "the surface has {} × {} heights along x and y, window.pixels is [{}, {}]; give both the same "
    "size, by crop, repeat or transpose of [disk.roughness]; x runs from column to column"
)
_ROUNDING = 1e-9
_NOMINAL = 1000.0  # kg/m³: with it, a viscosity in mPa s has the same number in mm²/s


@dataclass(frozen=True, slots=True)
class Parts:
    """What the entries of a scene file were read into."""

    declared: Any  # the file, in its declared classes
    case: Case  # the scene itself
    contents: Mapping[str, str]  # digests of the contents of files, by the paths of their entries
    sources: tuple[FromLibrary, ...]  # numbers from the library


def material_of(table: MaterialTable) -> tribo.Material:
    """Make the `tribo.Material` of a table without faults."""
    return tribo.Material(**{k: v for k, v in vars(table).items() if v is not None and k != "like"})


@dataclass
class Contents:
    """Contents of the files that a scene names, and the folders in which to find the files.

    `arrays` has the contents, each by its SHA-256. `folders` has the folder of each file, by the
    path of the scene's entry with the file's name, such as "loading.file".
    """

    arrays: dict[str, Array] = field(default_factory=dict)
    folders: Mapping[str, Path] = field(default_factory=dict)

    def keep(self, array: Array) -> str:
        """Keep an array that was read from a file; return its SHA-256."""
        self.arrays[key := array_digest(array)] = array
        return key

    def take(self, key: str, shape: tuple[int, ...]) -> Array:
        """Look up an array by its SHA-256, `key`, and give it a shape.

        Raises an `InputError` if the content of the array has another SHA-256.
        """
        array = self.arrays[key].reshape(shape)
        if array_digest(array) != key:
            raise tribo.InputError(f"the array {key} does not have this SHA-256; restore its data")
        return array

    def find(self, table: Any, path: str, faults: Faults) -> Path | None:
        """Path of the file that a table names; None if the file's content is known from a store.

        `path` is the table's key path. Raises a `MissingError` if a store lacks the content.
        """
        if table.content in self.arrays:
            return None
        if faults.is_complete or table.content:
            name = quoted(table.file)
            raise MissingError(
                f"{path}: the contents of {name} are missing; open the store of the sweep"
            )
        return self.folders[f"{path}.file"] / user_path(table.file)


def stages_of(stages: Any, highest: float) -> tuple[tuple[float, ...], tuple[float, ...]]:
    """Levels and holds [s] of the stages in an entry; even stages end at the `highest` level."""
    if isinstance(stages, EvenStages):
        return _even(stages.first, stages.step, stages.hold, highest)
    return tuple(level for level, _ in stages), tuple(hold for _, hold in stages)


def axis_of(text: str) -> str:
    """Which of "load" and "velocity" a quantity of a scene is."""
    return "load" if si_unit(text) == si_unit("1 N") else "velocity"


def levels_of(stages: Any, end: float) -> tuple[str, tuple[float, ...], tuple[float, ...]]:
    """Read the stages of a test: "load" or "velocity", and levels and holds of the stages in SI.

    Even stages end at the level `end`.
    """
    is_even = isinstance(stages, EvenLevels)
    texts = [stages.first, stages.step] if is_even else [level for level, _ in stages]
    name = axis_of(texts[0])
    numbers = [to_si(text, like=f"1 {'N' if name == 'load' else 'm/s'}") for text in texts]
    if is_even:
        return name, *_even(numbers[0], numbers[1], stages.hold, end)
    return name, tuple(numbers), tuple(hold for _, hold in stages)


def _even(
    first: float, step: float, hold: float, highest: float
) -> tuple[tuple[float, ...], tuple[float, ...]]:
    """Levels and holds of even stages, the last at the `highest` level or below it."""
    steps = max(0.0, (highest - first) / step)
    if steps > MOST_STEPS:
        raise tribo.InputError(f"stages are {steps:.3g} in number; give at most {MOST_STEPS}")
    count = 1 + math.floor(steps * (1 + _ROUNDING))
    return tuple(first + k * step for k in range(count)), (hold,) * count


def loading_of(
    contents: Contents,
    faults: Faults,
    table: RampTable | StagesTable | Record,
    loads: Sequence[float],
) -> tuple[Loading, str | None]:
    """Make the ramp, the stages or the recorded load; also return the SHA-256 of a record.

    `table` is the scene's ``[loading]``, `loads` are those of the plane [N], and `contents` has the
    contents of files. If the table asks for a fit, the result is the ramp fitted to the record, and
    a note on it is added to `faults`.
    """
    if isinstance(table, RampTable):
        given = {key: value for key, value in vars(table).items() if value is not None}
        return tribo.Ramp(**given), None
    if isinstance(table, StagesTable):
        return tribo.Stages(*stages_of(table.stages, max(loads)), table.rate), None
    path = contents.find(table, "loading", faults)
    content = str(table.content)
    if path:
        columns = {one.name: one for one in read_columns(path, MOST_ROWS)}
        times, forces = (_numbers(columns, name, unit) for name, unit in _RECORD.items())
        if reason := record_fault(times, forces):
            raise tribo.InputError(f"row {reason[0] + 2}: {reason[1]}")
        content = contents.keep(np.array([times, forces]))
    times, forces = contents.take(content, (2, -1))
    record = tribo.MeasuredLoad(times, forces, table.reference_load)
    if not table.fit:
        return record, content
    rate, onset = record.linear_fit()
    line = f"{rate:.4g} N/s from {round(onset, 3) + 0:g} s on"
    faults.note("loading.file", f"fitted by {line}")
    return record.ramp(), content


def _numbers(columns: Mapping[str, Column], name: str, unit: str) -> Array:
    """Values of a column in SI."""
    if name not in columns:
        raise tribo.InputError(
            f"no column {name} in the file; give a heading such as {name} [{unit}]"
        )
    column = columns[name]
    return np.array([to_si(f"{cell} {column.unit or unit}", f"1 {unit}") for cell in column.cells])


def grid_of(window: Window, pin: Any) -> tribo.Grid:
    """Pixels of the window as a grid, periodic along y if the pin has a length."""
    is_line = "length" in sizes_of(pin.shape)
    return tribo.Grid(window.pixels, window.pixel_size, periodic=(False, is_line))


def oil_of(table: OilTable) -> tribo.Oil:
    """Make the `tribo.Oil` of a table; a dynamic viscosity becomes kinematic at 1000 kg/m³."""
    kinematic = table.kinematic_viscosity
    dynamic: Any = tuple(value / _NOMINAL for value in table.dynamic_viscosity or ())
    if bool(kinematic) == bool(dynamic) or (kinematic and table.density is None):
        raise tribo.InputError(
            "the viscosity of the oil is not known; give kinematic_viscosity and density, or "
            "dynamic_viscosity alone"
        )
    density = table.density if kinematic and table.density else _NOMINAL
    coefficient = table.pressure_viscosity_coefficient
    pair = None if coefficient is None else _pair(coefficient)
    return tribo.Oil(table.temperatures, kinematic or dynamic, density, pair)


def _pair(value: Any) -> tuple[float, float]:
    """Return a pair unchanged, and a single value twice."""
    return value if isinstance(value, tuple) else (value, value)


def corrections_of(
    scene: Any, pin: tribo.Pin, disk: tribo.Material, motion: tribo.Motion | None
) -> tribo.Corrections | None:
    """Make the `tribo.Corrections` of a scene without faults; None if it has no corrections.

    `scene` has the tables of the scene; `pin`, `disk` and `motion` were made from them.
    """
    friction = scene.friction
    curve = sorted(
        (row.velocity, row.coefficient / friction.coefficient) for row in friction.by_velocity or ()
    )
    corrections = tribo.Corrections(
        friction=tribo.Friction(by_velocity=tuple(curve)),
        track=_track_of(scene.disk, pin, disk),
        pin_track=_track_of(scene.pin, pin, pin.material),
        motion=motion if track_length(scene.pin) or track_length(scene.disk) else None,
    )
    return corrections if corrections != tribo.Corrections() else None


def motion_of(table: MotionTable, pin: Body) -> tribo.Motion:
    """Make the `tribo.Motion` of a table; the track length is taken from `pin` if not given."""
    return tribo.Motion(**vars(table) | {"track_length": table.track_length or track_length(pin)})


def track_length(body: Body) -> float | None:
    """Length of the track around a body [m]: the rim of a disc, or the given value, or None."""
    return math.pi * body.diameter if body.diameter else body.track_length


def _track_of(body: Body, pin: tribo.Pin, material: tribo.Material) -> tribo.Track | None:
    """Make the `tribo.Track` of a body, which passes under the pin again and again; else None."""
    track = disc_of(body) or track_length(body)
    return tribo.Track.under(pin, material, track) if track else None


def disc_of(body: Body) -> tribo.Disc | None:
    """Make the `tribo.Disc` of a body; None if the body is not a disc, or a size is missing."""
    if body.diameter and body.width:
        return tribo.Disc(diameter=body.diameter, width=body.width)
    return None


def roughness_of(
    contents: Contents, faults: Faults, table: Any, window: Window
) -> Roughness | None:
    """Make the roughness of the disk: from a seed, or from the heights in the file of a scan.

    `table` is the scene's ``[disk.roughness]``. `contents` has the heights of files read before,
    and keeps those that are read here. Faults of a scan are added to `faults`; without usable
    heights the result is None. If the scene comes from a store that lacks the heights, the result
    is a `MissingSurface`, which raises an error once heights are needed.
    """
    if not isinstance(table, MeasuredSurfaceTable):
        if window.pixels == (1, 1):
            raise tribo.InputError(
                "one pixel cannot be rough; give more window.pixels, or no table"
            )
        pair = _pair(table.correlation_length)
        return tribo.SelfAffineRoughness(**vars(table) | {"correlation_length": pair})
    try:
        path = contents.find(table, "disk.roughness", faults)
    except MissingError as error:
        return MissingSurface(table.content or "", str(error))
    if path is None:
        return tribo.MeasuredRoughness(contents.take(str(table.content), window.pixels))
    scans = extras.module("surfaces")
    heights = scans.window_heights(vars(table), vars(window), path, faults)
    if heights is None:
        return None
    if heights.shape != window.pixels:
        raise tribo.InputError(_WRONG_SIZE.format(*heights.shape, *window.pixels))
    made = tribo.MeasuredRoughness(heights)
    contents.keep(made.array)
    return made
