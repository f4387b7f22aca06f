"""Entries of a scene, read into its parts, and written in full."""

from __future__ import annotations

from collections.abc import Callable, Collection
from dataclasses import dataclass, field, replace
from functools import partial
from typing import Any

import tribo
from pipeline.scene.consistency import check_tables
from pipeline.scene.declare import table_of
from pipeline.scene.facts import track_faults
from pipeline.scene.faults import Faults
from pipeline.scene.fidelity import complete_fidelity, fidelity_of
from pipeline.scene.format import Bulks, MeasuredSurfaceTable, Model, SceneFile
from pipeline.scene.library import resolve_library
from pipeline.scene.parts import (
    Contents,
    Parts,
    corrections_of,
    disc_of,
    grid_of,
    loading_of,
    material_of,
    motion_of,
    oil_of,
    roughness_of,
)
from pipeline.scene.runs import expand_tests
from pipeline.scene.written import entries_of, keep_written
from pipeline.sweep.conditions import PATHS, Conditions, bulk_entries, criterion_of
from pipeline.sweep.measurement import Case
from pipeline.sweep.remarks import FromLibrary
from pipeline.sweep.tables import Entries, changes, entry_at
from tribo.simulation import widen_window
from tribo.simulation.pins import sizes_of


@dataclass
class SceneReader:
    """Converts the entries of a scene to the objects that are simulated; reads each file once.

    Attributes
    ----------
    contents : Contents
        Contents of files that were read.
    is_stored : bool
        True for entries of a store, which are complete: a missing entry has no value, not even its
        default.
    """

    contents: Contents = field(default_factory=Contents)
    is_stored: bool = False
    parts: dict[tuple[Any, ...], Any] = field(default_factory=dict)
    first: tuple[Entries, Any] = ({}, None)  # entries without faults, and as they were read

    def read(self, entries: Entries) -> Parts:
        """Convert entries to `Parts`; raise an `InputError` with the first fault."""
        faults = Faults(self.is_stored, allows_store_only=True)
        parts = self.read_all(entries, faults)
        if parts is None or faults:
            raise tribo.InputError(f"{faults[0].key}: {faults[0].problem}")
        return parts

    def read_all(self, entries: Entries, faults: Faults) -> Parts | None:
        """Convert entries to `Parts`; if an entry is faulty, add to `faults` and return None.

        The parts are returned despite a fault that only they show, such as a too short track.
        """
        tables: dict[str, Any] = dict(entries)
        taken: tuple[FromLibrary, ...] = ()
        if not self.is_stored:
            tables, taken = resolve_library(tables, faults)
        scene, changed = self._read_tables(tables, faults)
        fidelity, preset = fidelity_of(scene.fidelity, faults)
        part, read = partial(self._part, scene, faults), (self.contents, faults)
        loading, record = part(partial(loading_of, *read), "loading", "sweep.loads") or (None, None)
        heights = partial(roughness_of, *read)
        roughness = part(heights, "disk.roughness", "window")
        made = {
            "pixels": part(grid_of, "window", "pin"),
            "motion": part(motion_of, "motion", "pin"),
            "wear": part(lambda wear: tribo.Wear(**vars(wear)), "wear"),
            "loading": loading,
            "roughness": roughness,
            "fidelity": fidelity,
        }
        oil = part(oil_of, "oil")
        for body in ("pin", "disk"):
            part(disc_of, body)  # called for the faults that it notes
        check_tables(replace(scene, fidelity=fidelity), changed, faults)
        if faults:
            return None
        digests = {"loading.content": record} if record else {}
        if isinstance(scene.disk.roughness, MeasuredSurfaceTable):
            digests["disk.roughness.content"] = roughness.digest
        physics = _scene_of(scene, **made)
        with faults.at("window.pixels"):
            physics = widen_window(physics, max(scene.sweep.velocities))
        friction, model = scene.friction, scene.model or Model()
        case = Case(
            name=(),
            scene=physics,
            conditions=_conditions_of(scene, physics),
            friction_band=friction.band,
            model_bias=model.bias,
            model_scatter=model.scatter,
            lubricant=oil,
            preset=preset,
        )
        parts = Parts(scene, case, digests, taken)
        for path, fault in track_faults(parts):
            faults.refuse(path, fault)
        return parts

    def complete(self, entries: Entries, parts: Parts, like: Parts | None = None) -> dict[str, Any]:
        """Entries of a scene with all defaults, library values and preset choices written out.

        `parts` are the objects that were read from `entries`. If `like`, the parts of another
        scene, is given, tables that are equal in both scenes are left out.
        """
        fidelity = complete_fidelity(parts.case.preset, parts.case.scene.fidelity)
        declared, kind = vars(replace(parts.declared, fidelity=fidelity)), table_of(SceneFile)
        before = vars(like.declared) if like else {}
        kept = [k for k in kind.keys if not like or getattr(parts.declared, k) != before[k]]
        full = {key: entries_of(kind.keys[key].kind, declared[key]) for key in kept}
        tables = {key: one for key, one in full.items() if one is not None}
        tables.get("sweep", {}).pop("along", None)  # the rows of variants stand for it
        kept_tables: dict[str, Any] = keep_written(tables, entries)
        return kept_tables

    def complete_changes(
        self, given: Entries, written: Entries, parts: Parts, entries: Entries, base: Parts
    ) -> dict[str, Any]:
        """Changes of a scene as a store needs them, whatever library and presets are later.

        `parts` were read from `written`, the entries of the scene with the changes `given` by path.
        `entries` are the complete ones of the scene, and `base` the objects read from them.
        """
        full = self.complete(written, parts, base)
        before = {path: entries.get(path) for path in full}
        added = {path: one for path, one in changes(before, full) if path not in given}
        # SHA-256 of the files that the changes name.
        files = {path: x for path, x in parts.contents.items() if entry_at(written, path) != x}
        return {**given, **added, **files}

    def _read_tables(self, entries: dict[str, Any], faults: Faults) -> tuple[Any, Collection[str]]:
        """Read entries into a `SceneFile`; return it, and the names of the tables read anew."""
        # Tables that equal those of the scene that was read first are taken from it.
        kind = table_of(SceneFile)
        before, scene = self.first
        other = {key for key, value in entries.items() if value != before.get(key)}
        if scene and entries.keys() == before.keys() and not other & {"measured", "tested"}:
            new = {key: kind.keys[key].kind.read(entries[key], key, faults) for key in other}
            return replace(scene, **new), other
        scene = expand_tests(kind.read(entries, "", faults), faults)
        if not faults:
            self.first = entries, scene
        return scene, kind.keys

    def _part(self, scene: Any, faults: Faults, make: Callable[..., Any], *paths: str) -> Any:
        """Make a part of the tables at `paths`; None if one is faulty, or the first is missing."""
        tables = [entry_at(scene, path) for path in paths]
        if tables[0] is None or any(map(faults.touches, paths)):
            return None
        made_of = (*paths, *tables)
        if self.parts.get(made_of) is None:  # a faulty part is made again, and refused each time
            with faults.at(f"{paths[0]}.file" if hasattr(tables[0], "file") else paths[0]):
                self.parts[made_of] = make(*tables)
        return self.parts.get(made_of)


def _scene_of(scene: Any, **parts: Any) -> tribo.Scene:
    """Make a `tribo.Scene` of a `SceneFile` and of finished `parts`."""
    pin, friction = scene.pin, scene.friction
    kind: Any = tribo.PINS[pin.shape]
    sizes = {name: getattr(pin, name) for name in sizes_of(pin.shape)}
    return tribo.Scene(
        pin=kind(**sizes, material=material_of(scene.materials[pin.material])),
        disk=material_of(scene.materials[scene.disk.material]),
        friction_heat=max([friction.coefficient, *(friction.band or [])]) > 0,
        unequal_bulks=_bulks_of(scene)["disk_temperature"] is not None,
        **parts,
    )


def _conditions_of(scene: Any, made: tribo.Scene) -> Conditions:
    """Make the `Conditions` of a `SceneFile`."""
    values = {name: entry_at(scene, path) for name, path in PATHS.items()} | _bulks_of(scene)
    values["criterion"] = criterion_of(values["criterion"], values.pop("share"))
    values["corrections"] = corrections_of(scene, made.pin, made.disk, made.motion)
    # Of a scene without [model], the rise beside it has its default.
    known = {name: one for name, one in values.items() if one is not None}
    return Conditions(**known).under(made.loading)


def _bulks_of(scene: Any) -> dict[str, Any]:
    """Bulk temperatures of a scene as arguments of `Conditions`; `scene` has its tables."""
    bulk = scene.temperature.bulk
    return bulk_entries(vars(bulk) if isinstance(bulk, Bulks) else bulk)
