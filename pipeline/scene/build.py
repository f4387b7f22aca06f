"""Tables of a scene to objects: one function a table, and all faults at once."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import partial
from pathlib import Path
from typing import Any

from scipy.fft import next_fast_len

import tribo
from pipeline.condition_kinds import CONDITIONS
from pipeline.constants import BIAS_WITHOUT_INPUTS
from pipeline.faults import Faults
from pipeline.paths import user_path
from pipeline.quantities import display
from pipeline.scene.checks import disc_of, misfits, track_length, track_misfits
from pipeline.scene.entries import Entries, entry_at, replace_values
from pipeline.scene.format import (
    USUAL_PRESET,
    MaterialTable,
    MeasuredSurfaceTable,
    Model,
    MotionTable,
    OilTable,
    RampTable,
    RandomSurface,
    Record,
    SceneFile,
    StagesTable,
    Window,
    stages_of,
)
from pipeline.scene.input_values import uncertainty_of
from pipeline.scene.library import resolve_library
from pipeline.scene.table_kinds import Declared, TableKind
from pipeline.surface.mean_spacing import correlation_lengths
from pipeline.surface.scan import read_scan
from pipeline.surface.window import window_heights
from pipeline.sweep.case import Case, Conditions
from pipeline.sweep.case_table import AREAS_ENTRY
from pipeline.sweep.notes import FromLibrary
from pipeline.table import read_table
from tribo.loading.record import find_fault
from tribo.simulation import widen_window
from tribo.simulation.pins import Relief, sizes_of
from tribo.types import Array
from tribo.wear import WEAR_LAWS

Loading = tribo.Ramp | tribo.Stages | tribo.MeasuredLoad
Roughness = tribo.SelfAffineRoughness | tribo.MeasuredRoughness


@dataclass(frozen=True)
class Files:
    """Folders of the files that a scene names, by the paths of their entries; each is read once."""

    folders: Mapping[str, Path] = field(default_factory=dict)
    contents: dict[Any, Any] = field(default_factory=dict, compare=False)

    def path(self, entry: str, name: str) -> Path:
        """Path of the file that the entry at a path names."""
        return self.folders.get(entry, Path()) / user_path(name)

    def read_once(self, key: Any, read: Callable[[], Any]) -> Any:
        """Result of `read`, which is called only once for each `key`."""
        if key not in self.contents:
            self.contents[key] = read()
        return self.contents[key]


@dataclass(frozen=True)
class BuiltScene:
    """Declared tables of a scene, its case, and the values taken from the library."""

    tables: SceneFile
    case: Case
    sources: tuple[FromLibrary, ...]


def build(entries: Entries, files: Files, faults: Faults) -> BuiltScene | None:
    """Make the case of a scene's entries; None if an entry is faulty, with all faults added.

    Conflicts between entries are looked for once each entry alone has no fault. A fault that is
    found in the case itself, such as a too short track, does not make it None.
    """
    fault_count = len(faults)
    resolved, sources = resolve_library(dict(entries), faults)
    if len(faults) > fault_count:  # the entries of a material or an oil are missing
        return None
    tables: SceneFile = TableKind(SceneFile).read(resolved, "", faults)
    if faults:
        return None
    fidelity, preset = fidelity_of(tables.fidelity, faults)
    for path, problem in misfits(tables, fidelity):
        faults.refuse(path, problem)
    part = partial(_part, faults)
    if not faults:
        tables = replace(tables, window=window_of(tables.window, tables.pin, fidelity, faults))
    scene_parts = {
        "pixels": part("window", grid_of, tables.window, tables.pin),
        "motion": part("motion", motion_of, tables.motion, tables.pin, tables.disk),
        "wear": part("wear", wear_of, tables.wear),
        "loading": part("loading", loading_of, tables.loading, tables.sweep.loads, files),
        "roughness": part(
            "disk.roughness", roughness_of, tables.disk.roughness, tables.window,
            tables.sweep.realizations, files, faults,
        ),
        "fidelity": fidelity,
    }  # fmt: skip
    oil = part("oil", oil_of, tables.oil)
    for body in ("pin", "disk"):
        part(body, disc_of, getattr(tables, body))  # only to find faults
    if faults:
        return None
    scene = scene_of(tables, **scene_parts)
    with faults.at("window.pixels"):
        scene = widen_window(scene, max(tables.sweep.velocities))
    model, uncertainty = tables.model or Model(), uncertainty_of(tables, faults)
    is_bias_stated = entry_at(resolved, "model.bias") is not None
    case = Case(
        name=(),
        scene=scene,
        conditions=conditions_of(tables, scene),
        friction_band=tables.friction.band,
        model_bias=model.bias,
        bias_without_inputs=model.bias if is_bias_stated else BIAS_WITHOUT_INPUTS,
        model_scatter=model.scatter,
        critical_from_tests=math.isnan(tables.temperature.critical or 0.0),
        lubricant=oil,
        preset=preset,
        uncertainty=uncertainty,
        includes_earlier_revolutions=tables.temperature.includes_earlier_revolutions,
    )
    for path, problem in track_misfits(tables, case):
        faults.refuse(path, problem)
    return BuiltScene(tables, case, sources)


def build_case(
    base: BuiltScene, entries: Entries, changes: Entries, files: Files, faults: Faults
) -> BuiltScene | None:
    """Make a case of the scene `base`, whose `entries` have some `changes`, as `build` does.

    The case shares the table ``[sweep]`` that the scene has read, and has no tests.
    """
    case_entries = {path: value for path, value in changes.items() if path != AREAS_ENTRY}
    sweep = base.tables.sweep
    if AREAS_ENTRY in changes:
        sweep = replace(sweep, realizations=changes[AREAS_ENTRY])
    bare = {key: value for key, value in entries.items() if key != "tests"}
    return build(replace_values(bare, case_entries) | {"sweep": sweep}, files, faults)


def _part(faults: Faults, path: str, convert: Callable[..., Any], table: Any, *more: Any) -> Any:
    """Convert a table to its part of the scene; None without a table, or if there is a fault."""
    if table is None:
        return None
    with faults.at(f"{path}.file" if hasattr(table, "file") else path):
        return convert(table, *more)
    return None


def set_entries(table: Declared) -> dict[str, Any]:
    """Entries of a table that have a value, by name."""
    return {name: value for name, value in vars(table).items() if value is not None}


def scene_of(tables: Any, **parts: Any) -> tribo.Scene:
    """Scene of a file's tables and of finished `parts`."""
    pin, friction = tables.pin, tables.friction
    pin_class: Any = tribo.PINS[pin.shape]
    sizes = {name: getattr(pin, name) for name in sizes_of(pin.shape)}
    if pin.relief:
        sizes["relief"] = Relief(**vars(pin.relief))
    return tribo.Scene(
        pin=pin_class(**sizes, material=material_of(tables.materials[pin.material])),
        disk=material_of(tables.materials[tables.disk.material]),
        friction_heat=max([friction.coefficient, *(friction.band or [])]) > 0,
        **parts,
    )


def material_of(table: MaterialTable) -> tribo.Material:
    """Material of its table."""
    return tribo.Material(
        **{name: value for name, value in set_entries(table).items() if name != "like"}
    )


def window_of(window: Window, pin: Any, fidelity: tribo.Fidelity, faults: Faults) -> Window:
    """The window; under a pin with free ends as long as the pin, in pixels of about the same size.

    The pixels are smaller along y by at most some percent, so that their number suits coarser
    elements and the transforms. A note on them is added to `faults`.
    """
    if pin.ends != "free":
        return window
    (nx, _), (dx, dy) = window.pixels, window.pixel_size
    block = fidelity.pixels_per_element * max(2, fidelity.history_coarsening)
    count = block * int(next_fast_len(math.ceil(pin.length / dy / block * (1 - 1e-9))))
    size = pin.length / count
    faults.note(
        "pin.ends",
        f"free: {count} pixels of {display(size, 'µm', 4)} along y, as long as the pin",
    )
    return replace(window, pixels=(nx, count), pixel_size=(dx, size))


def grid_of(window: Window, pin: Any) -> tribo.Grid:
    """Pixels of the window as a grid, periodic along y under a cylinder without free ends."""
    repeats = "length" in sizes_of(pin.shape) and pin.ends != "free"
    return tribo.Grid(window.pixels, window.pixel_size, periodic=(False, repeats))


def motion_of(table: MotionTable, pin: Any, disk: Any) -> tribo.Motion:
    """Motion; lengths of tracks that are not given are those of the bodies."""
    return tribo.Motion(
        slide_roll_ratio=table.slide_roll_ratio,
        pin_track_length=table.pin_track_length or track_length(pin),
        disk_track_length=table.disk_track_length or track_length(disk),
    )


def wear_of(table: Declared) -> tribo.Wear | tribo.WearLaw:
    """The wear law of a table."""
    return WEAR_LAWS[table.form](**vars(table))


def loading_of(
    table: RampTable | StagesTable | Record, loads: Sequence[float], files: Files
) -> Loading:
    """The ramp, the stages up to the highest of `loads` [N], or the record."""
    if isinstance(table, RampTable):
        return tribo.Ramp(**set_entries(table))
    if isinstance(table, StagesTable):
        return tribo.Stages(*stages_of(table.stages, max(loads)), table.rate)
    path = files.path("loading.file", table.file)
    times, record_loads = files.read_once(path, partial(_record, path, table))
    return tribo.MeasuredLoad(times, record_loads, table.reference_load)


def _record(path: Path, table: Record) -> tuple[Array, Array]:
    """Times [s] and loads [N] of a recorded load."""
    max_rows = 1_000_000  # which are read within a minute
    rows = read_table(path, max_rows, table.decimal, table.ignore)
    times, loads = rows.numbers({"time": "s", "load": "N"}).values()
    if fault := find_fault(times, loads):
        row, problem = fault
        raise tribo.InputError(f"row {rows.lines[row]}: {problem}")
    return times, loads


def roughness_of(
    table: Any, window: Window, realizations: Any, files: Files, faults: Faults
) -> Roughness:
    """Roughness of the disk: from a seed, or from the heights in an area of a scan.

    Of several `realizations` it is the first. Notes on a scan are added to `faults`.
    """
    if not isinstance(table, MeasuredSurfaceTable):
        if window.pixels == (1, 1):
            raise tribo.InputError(
                "a window of one pixel cannot be rough; increase window.pixels, or remove "
                "[disk.roughness]"
            )
        lengths = correlation_lengths_of(table, window, faults)
        return tribo.SelfAffineRoughness(table.ra, table.hurst_exponent, lengths, table.seed)
    path = files.path("disk.roughness.file", table.file)
    areas = tuple(realizations_of(realizations, 0)) or (0,)
    cut = partial(_scanned, files, path, table, window, areas)
    heights, notes = files.read_once((path, table, window, areas), cut)
    for note in notes:
        faults.note("disk.roughness.file", note)
    return tribo.MeasuredRoughness(heights)


def correlation_lengths_of(
    table: RandomSurface, window: Window, faults: Faults
) -> tuple[float, float]:
    """Correlation lengths [m] along x and y, as stated or by RSm; a note on the latter is added."""
    lengths, rsm = table.correlation_length, table.rsm
    if rsm is None:
        if lengths is None:
            raise tribo.InputError('give a correlation_length, such as "4 um", or an rsm')
        return lengths if isinstance(lengths, tuple) else (lengths, lengths)
    if lengths is not None:
        raise tribo.InputError("correlation_length and rsm state the same; leave out one of them")
    smallest = min(rsm) if isinstance(rsm, tuple) else rsm
    if smallest < table.ra:
        raise tribo.InputError(
            f"rsm ({display(smallest, 'µm')}) is below ra ({display(table.ra, 'µm')}): are they "
            "swapped?"
        )
    lengths = correlation_lengths(rsm, table.hurst_exponent, window.pixel_size)
    x, y = (display(length, "µm", 3) for length in lengths)
    words = (
        f"correlation lengths of {x} along x and {y} along y"
        if isinstance(rsm, tuple)
        else f"a correlation length of {x}"
    )
    faults.note("disk.roughness.rsm", f"surfaces with this RSm have {words}")
    return lengths


def realizations_of(choice: int | Sequence[int] | None, first: int) -> Sequence[int]:
    """Labels of the surface realizations that a scene asks for, counted from `first` on."""
    return range(first, first + choice) if isinstance(choice, int) else sorted(choice or ())


def _scanned(
    files: Files, path: Path, table: Any, window: Window, areas: Sequence[int]
) -> tuple[Array, list[str]]:
    """Heights (nx, ny) [m] of the first of `areas` of a scan, and notes on them."""
    scan_key = path, table.height_unit
    scan, scan_notes = files.read_once(scan_key, partial(read_scan, *scan_key))
    heights, notes = window_heights(scan, vars(table), window.pixels, window.pixel_size, areas)
    return heights, [*scan_notes, *notes]


def oil_of(table: OilTable) -> tribo.Oil:
    """The oil of its table."""
    return tribo.Oil(table.kinematic_viscosity, table.density, table.pressure_viscosity_coefficient)


def conditions_of(tables: Any, scene: tribo.Scene) -> Conditions:
    """Conditions by which the points of a scene are judged."""
    values = {name: entry_at(tables, entry) for name, (entry, *_) in CONDITIONS.items()}
    values["corrections"] = corrections_of(tables, scene)
    if math.isnan(values["critical_temperature"] or 0.0):  # from tests
        values["critical_temperature"] = None
    # Without [model], the added rise has its default.
    entered = {name: value for name, value in values.items() if value is not None}
    return Conditions(**entered).with_loading(scene.loading)


def corrections_of(tables: Any, scene: tribo.Scene) -> tribo.Corrections | None:
    """Tracks that earlier revolutions have warmed; None without any."""
    pin = scene.pin
    tracks: dict[str, Any] = {
        "track": _track_of(tables.disk, pin, scene.disk),
        "pin_track": _track_of(tables.pin, pin, pin.material),
    }
    return tribo.Corrections(motion=scene.motion, **tracks) if any(tracks.values()) else None


def _track_of(body: Any, pin: tribo.Pin, material: tribo.Material) -> tribo.Track | None:
    """Track of a body that passes under the pin again and again; else None."""
    around = disc_of(body) or track_length(body)
    return tribo.Track.from_pin(pin, material, around) if around else None


def fidelity_of(table: Any, faults: Faults) -> tuple[tribo.Fidelity, str | None]:
    """Numerical choices, and the name of the preset that has them, or None."""
    settings = set_entries(table) if table else {}
    preset = settings.pop("preset", USUAL_PRESET)
    fidelity = tribo.PRESETS[preset]
    for name, value in settings.items():
        with faults.at(f"fidelity.{name}"):
            fidelity = replace(fidelity, **{name: value})
    return fidelity, preset if fidelity == tribo.PRESETS[preset] else None
