"""Scene files: TOML with units, read into a `Sweep`, with all faults at once."""

from __future__ import annotations

from collections.abc import Callable, Collection, Mapping
from dataclasses import dataclass, field, replace
from os import PathLike
from typing import Any

import numpy as np

import tribo
from pipeline.scene.consistency import check_tables
from pipeline.scene.declare import table_of
from pipeline.scene.document import Document, override_entries, read_document
from pipeline.scene.extensions import Reading, begin
from pipeline.scene.facts import track_faults
from pipeline.scene.faults import Faults, SceneFileError, did_you_mean, entry_at, replace_value
from pipeline.scene.format import USUAL_PRESET, Bulks, Fidelity, SceneFile
from pipeline.scene.laws import named_code, replace_by_laws, take_laws
from pipeline.scene.library import resolve_library
from pipeline.scene.parts import (
    corrections_of,
    loading_of,
    material_of,
    motion_of,
    oil_of,
    realizations_of,
    roughness_of,
    wear_of,
)
from pipeline.scene.reference import all_keys
from pipeline.scene.runs import expand_tests, tested_holds
from pipeline.scene.shipped import scene_path
from pipeline.scene.units import in_si
from pipeline.sweep import plan
from pipeline.sweep.about import About, Measurement
from pipeline.sweep.conditions import Conditions, bulk_entries
from pipeline.sweep.laws import name_of
from pipeline.sweep.limits import MOST_POINTS
from pipeline.sweep.model import Plane, Record, Sweep
from pipeline.sweep.stages import Report, silent
from pipeline.sweep.variants import surfaces
from tribo.simulation.pins import sizes_of

_UNSET = ("extends", "materials", "fidelity", "measured", "tested")
"""Tables whose entries are not named by their path alone."""


@np.errstate(under="ignore")
def load_scene(
    path: str | PathLike[str],
    preset: str | None = None,
    overrides: Mapping[str, Any] | None = None,
    laws: Mapping[str, Any] | None = None,
) -> Sweep:
    """Read a scene file, and the scenes that it extends.

    Parameters
    ----------
    path : path-like
        Scene file, or name of a shipped scene. Files named in it are relative to the folder of the
        file that names them.
    preset : str, optional
        Preset of the numerical choices, in place of the scene's whole table ``[fidelity]``: draft,
        standard, fine or reference. Single entries of that table are left out, too.
    overrides : mapping, optional
        Fields of `tribo.Fidelity`, applied last; or entries of the scene by their key path, such
        as ``wear.pattern`` or ``title``, in place of the file's; ``without`` leaves out entries
        of the file, before the others are set.
    laws : mapping, optional
        Objects of your own in place of the scene's: a `tribo.WearLaw` as ``"wear"``, a
        `tribo.Surface` as ``"surface"``, a `tribo.Rule` as ``"criterion"``, a `tribo.Pin` as
        ``"pin"``. Entries such as ``wear.parameters.NAME`` replace fields of a wear law; see
        ``workflows/OWN_LAWS.md``.

    Raises
    ------
    SceneFileError
        If there is any fault in the file or the arguments; it carries all of them.

    Examples
    --------
    >>> import pipeline
    >>> scene = pipeline.load_scene("workflows/first_try.toml", preset="standard")
    >>> scene.about.preset, scene.plane.loads
    ('standard', (200.0, 400.0, 600.0, 750.0))
    """
    path, faults, laws = scene_path(path), Faults(), laws or {}
    replaced = _path_overrides(overrides or {}, preset, faults)
    try:
        document = replace_by_laws(read_document(path, faults), laws)
    except tribo.InputError as error:
        raise SceneFileError(path, [str(error)]) from error
    document = override_entries(document, replaced, faults)
    if named := [*named_code(document.entries())]:
        raise SceneFileError(path, named)  # alone, for a law stands in place of more entries
    document, extensions = begin(document, faults)
    entries = document.entries()
    if isinstance(entries.get("oil"), str):
        entries["oil"] = {"like": entries["oil"]}
    reader = _Reader(document, laws)

    def variant(values: Mapping[str, Any]) -> Sweep:
        """The sweep with other values of some entries; raises its first fault."""
        other, wrong = entries, Faults()
        for place, value in values.items():
            other = replace_value(other, place, value)
        made, _ = reader.sweep(other, wrong)
        if made is None or wrong:
            raise tribo.InputError(f"{wrong[0].key}: {wrong[0].problem}")
        return made

    try:
        sweep, scene = reader.sweep(entries, faults)
        if sweep is not None:
            for extend in extensions:
                sweep = extend(sweep, Reading(document, scene, variant, faults))
            sweep = sweep.changed(notes=tuple(faults.notes))
            _require_few_points(sweep)
    except (tribo.InputError, tribo.InvariantError) as error:
        raise SceneFileError(path, [str(error)]) from error
    if sweep is None or faults:
        raise SceneFileError(path, [*map(document.line, faults)])
    return sweep


def _require_few_points(sweep: Sweep) -> None:
    """Raise an `InputError` for more points than a store may have, before any is made."""
    if (count := sweep.ramps * len(sweep.plane.loads)) > MOST_POINTS:
        raise tribo.InputError(
            f"sweep: {count:.4g} points are too many; give {MOST_POINTS:.0e} at most, by fewer "
            "loads, velocities or variants"
        )


@dataclass(slots=True)
class _Reader:
    """Reads entries into a sweep, and files that they name once for all entries."""

    document: Document
    laws: Mapping[str, Any]
    parts: dict[tuple[Any, ...], Any] = field(default_factory=dict)
    first: tuple[dict[str, Any], Any] = ({}, None)  # the first sound entries, and as they were read

    def sweep(self, entries: dict[str, Any], faults: Faults) -> tuple[Sweep | None, Any]:
        """The sweep, without samples and `over`, and the file as it is declared."""
        laws, entries = take_laws(self.laws, entries, faults)
        entries, taken = resolve_library(entries, faults)
        scene, changed = self._read(entries, faults)
        fidelity, preset = _fidelity(scene.fidelity, faults)
        seeds = realizations_of(scene, faults)
        roughness = laws.get("surface") or self._once(
            ("surface", seeds, entry_at(scene, "disk.roughness"), scene.window),
            lambda: roughness_of(scene, seeds, self.document, faults),
        )
        stops = tested_holds(scene)
        loading = self._once(
            ("loading", scene.loading, stops),
            lambda: loading_of(scene.loading, self.document, faults, stops),
        )
        made = {"fidelity": fidelity, "surface": roughness}
        check_tables(vars(scene) | made, changed, faults)
        oil = self._once(("oil", scene.oil), lambda: oil_of(scene.oil, faults))
        wear = laws.get("wear") or wear_of(scene.wear, faults)
        if faults or loading is None:
            return None, scene
        physics = _scene_of(
            scene,
            laws.get("pin"),
            loading=loading,
            roughness=roughness,
            wear=wear,
            fidelity=fidelity,
        )
        asked, name = scene.sweep, self.document.file.stem
        sweep = Sweep(
            scene=physics,
            plane=Plane(asked.loads, asked.velocities),
            conditions=_conditions_of(scene, physics, laws.get("criterion")),
            variants=surfaces(seeds),
            record=Record(asked.fields, asked.steps),
            about=About(
                name=name,
                title=scene.title or name,
                measured=tuple(Measurement.of(vars(test)) for test in scene.measured),
                tested=tuple(Measurement.of(vars(test)) for test in scene.tested),
                caveat=scene.caveat,
                friction_band=scene.friction.band,
                same_rig=scene.friction.same_rig,
                model_scatter=scene.model and scene.model.scatter,
                oil=oil,
                preset=preset,
                sources=taken,
            ),
        )
        for body, fault in track_faults(sweep):
            given = "diameter" if entry_at(scene, f"{body}.diameter") else "track_length"
            faults.refuse(f"{body}.{given}", fault)
        return sweep, scene

    def _read(self, entries: dict[str, Any], faults: Faults) -> tuple[Any, Collection[str]]:
        """The file as it is declared, and the tables that are not as in the first sound entries."""
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

    def _once(self, made_of: tuple[Any, ...], make: Callable[[], Any]) -> Any:
        """The part of a scene that is made of some tables; a faulty one is told each time."""
        self.parts[made_of] = self.parts.get(made_of) or make()
        return self.parts[made_of]


SceneLike = Sweep | str | PathLike[str]
"""A scene that was read, or its path or the name of a shipped one."""


def sweep_of(scene: SceneLike) -> Sweep:
    """Return a scene that was read, or read one from its path; raise as `load_scene` does."""
    return scene if isinstance(scene, Sweep) else load_scene(scene)


def scene_entry(
    path: str | PathLike[str], key: str, overrides: Mapping[str, Any] | None = None
) -> Any:
    """Return the value of a scene at a key path, as in TOML; None if it has none there.

    Parameters
    ----------
    path : path-like
        Scene file, or name of a shipped scene.
    key : str
        Key path, such as ``wear.specific_wear_rate``.
    overrides : mapping, optional
        Entries by their key path in place of what the file says there.

    Raises
    ------
    SceneFileError
        If the file cannot be read.

    Examples
    --------
    >>> import pipeline
    >>> pipeline.scene_entry("workflows/first_try.toml", "temperature.bulk")
    '25 degC'
    """
    replaced = _path_overrides(overrides or {}, None, Faults())
    document = override_entries(read_document(scene_path(path), Faults()), replaced, Faults())
    return entry_at(resolve_library(document.entries(), Faults())[0], key)


def _path_overrides(
    overrides: Mapping[str, Any], preset: str | None, faults: Faults
) -> dict[str, Any]:
    """Entries to replace by their paths; those of the fidelity may be named by their key alone."""
    replaced: dict[str, Any] = {} if preset is None else {"fidelity.preset": preset}
    for key, value in overrides.items():
        if key in table_of(Fidelity).keys:
            replaced[f"fidelity.{key}"] = value
        elif "." in key or (key in table_of(SceneFile).keys and key != "extends"):
            replaced[key] = value
        else:
            fields = [field for field in table_of(Fidelity).keys if field != "preset"]
            paths = [path for path, _ in all_keys() if path.partition(".")[0] not in _UNSET]
            hint = did_you_mean(key, [*fields, *paths])
            problem = f"unknown key{hint}; give one of {', '.join(fields)}"
            faults.refuse(
                key, f"{problem}; or an entry such as wear.pattern, loading.hold or title"
            )
    return replaced


def _fidelity(asked: Any, faults: Faults) -> tuple[tribo.Fidelity, str | None]:
    """Fidelity of a table, and the name of its preset if it equals that."""
    name = (asked and asked.preset) or USUAL_PRESET
    fidelity = tribo.PRESETS[name]
    listed = (vars(asked) if asked else {}).items()
    given = {key: value for key, value in listed if key != "preset" and value is not None}
    if "increments" in given:  # instead of steps by the wear
        given = {"hold_increments": 0, "imprint": 0.0} | given
    for key, value in given.items():
        with faults.at(f"fidelity.{key}"):
            fidelity = replace(fidelity, **{key: value})
    return fidelity, name if fidelity == tribo.PRESETS[name] else None


def _scene_of(scene: Any, own_pin: tribo.Pin | None, **parts: Any) -> tribo.Scene:
    """What is simulated of a sound scene, with parts that were made, or a pin of the user's own."""
    pin, window, friction = scene.pin, scene.window, scene.friction
    cylinder, periodic_y = pin.shape == "cylinder", window.periodic_y
    kind: Any = tribo.PINS[pin.shape]
    sizes = {name: getattr(pin, name) for name in sizes_of(pin.shape)}
    return tribo.Scene(
        pin=own_pin or kind(**sizes, material=material_of(scene.materials[pin.material])),
        disk=material_of(scene.materials[scene.disk.material]),
        pixels=tribo.Grid(
            window.pixels,
            window.pixel_size,
            periodic=(False, cylinder if periodic_y is None else periodic_y),
        ),
        motion=motion_of(scene),
        friction_heat=max([friction.coefficient, *(friction.band or [])]) > 0,
        unequal_bulks=_bulks_of(scene)["disk_temperature"] is not None,
        **parts,
    )


def _conditions_of(scene: Any, made: tribo.Scene, rule: tribo.Rule | None) -> Conditions:
    """The conditions of a sound scene, or with a rule of the user's own."""
    asked = scene.temperature
    return Conditions(
        friction=scene.friction.coefficient,
        critical_temperature=asked.critical,
        critical_sd=asked.critical_sd,
        failing_share=asked.failing_share,
        criterion=name_of(rule) if rule else asked.criterion,
        rule=rule,
        corrections=corrections_of(scene, made.pin, made.disk),
        **_bulks_of(scene),
    )


def _bulks_of(scene: Any) -> dict[str, Any]:
    """Bulk temperatures as conditions have them."""
    bulk = scene.temperature.bulk
    return bulk_entries(vars(bulk) if isinstance(bulk, Bulks) else bulk)


@np.errstate(under="ignore")
def run_point(
    sweep: SceneLike,
    load: float | str,
    velocity: float | str,
    realization: int | None = None,
    sample: int | None = None,
    progress: Report | None = None,
) -> plan.PointResult:
    """Simulate one point.

    Parameters
    ----------
    sweep : Sweep, str or path
        The scene, or its path.
    load : float or str
        Normal load on the whole pin at the end of the ramp. A number in N, or text with a unit,
        such as ``"600 N"``.
    velocity : float or str
        Sliding velocity. A number in m/s, or text with a unit.
    realization : int, optional
        Seed of the random surface in place of the sweep's own.
    sample : int, optional
        Number of the sample whose inputs stand in place of the sweep's own.
    progress : callable, optional
        Called with a `Progress` after each of the point's steps.

    Raises
    ------
    TriboError
        If text is not a load or a velocity, and what `tribo.simulate` raises.

    Examples
    --------
    >>> import pipeline
    >>> scene = pipeline.load_scene("workflows/first_try.toml")
    >>> point = pipeline.run_point(scene, "600 N", "1.5 m/s")
    >>> verdict = point.verdict(scene.conditions)
    >>> verdict.is_severe, f"{verdict.max_temperature - 273.15:.0f} °C"
    (False, '158 °C')
    """
    place = in_si("load", load, "600 N"), in_si("velocity", velocity, "1.5 m/s")
    named = {"realization": realization, "variant": sample}
    variant = tuple((name, value) for name, value in named.items() if value is not None)
    return plan.run_point(sweep_of(sweep), *place, variant, progress or silent)
