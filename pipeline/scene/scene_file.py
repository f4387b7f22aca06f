"""Scene files: TOML with units, read into a `Sweep`, with all faults at once."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field, replace
from os import PathLike
from typing import Any, Literal

import numpy as np

import tribo
from pipeline.arguments import plain_value
from pipeline.faults import Faults, SceneFileError
from pipeline.kinds import LOAD, VELOCITY
from pipeline.messages import did_you_mean, key_path, quoted
from pipeline.progress import Report, silent
from pipeline.scene.build import Files, build
from pipeline.scene.cases import listed_cases, read_cases, with_first_case
from pipeline.scene.entries import Entries, flat, replace_value, replace_values
from pipeline.scene.format import SEED, FidelityTable, SceneFile, scene_entries
from pipeline.scene.library import resolve_library
from pipeline.scene.scene_warnings import warnings_of_all
from pipeline.scene.table_kinds import TableKind
from pipeline.scene.tests import read_tests, with_listed_tests
from pipeline.scene.toml import Document, override, read_document, text_of
from pipeline.shipped import scene_path
from pipeline.sweep import plan
from pipeline.sweep.case_table import SEED_ENTRY
from pipeline.sweep.notes import SceneNote, SceneWarning
from pipeline.sweep.plan import choose_stored_steps
from pipeline.sweep.sweep import TABLE_OF_PART, Point, Sweep

_MAX_LEVELS = 10  # tables in tables
PresetName = Literal["standard", "fine", "reference"]
SceneLike = Sweep | str | PathLike[str]
"""A scene that was read, or its path or the name of a shipped one."""


@np.errstate(under="ignore")
def load_scene(
    path: str | PathLike[str],
    preset: PresetName | None = None,
    overrides: Mapping[str, Any] | None = None,
) -> Sweep:
    """Read a scene file, and the scenes that it extends.

    Parameters
    ----------
    path : path-like
        Scene file, or name of a shipped scene. Files named in it are relative to the folder of the
        file that names them.
    preset : str, optional
        Preset of the numerical choices: standard, fine or reference. It replaces the scene's
        whole table ``[fidelity]``, including single entries.
    overrides : mapping, optional
        Entries by key path, such as ``wear.pattern`` or ``title``; ``without``, a list of entries
        to leave out; or fields of `tribo.Fidelity`. They are applied in this order: ``without``,
        entries, fields of Fidelity.

    Raises
    ------
    SceneFileError
        If there is any fault in the file or the arguments; the error carries all faults.
    InputError
        If `preset` is no text.

    Examples
    --------
    >>> import pipeline
    >>> scene = pipeline.load_scene("workflows/first_try.toml", preset="standard")
    >>> scene.preset, scene.loads
    ('standard', (200.0, 400.0, 600.0, 750.0))
    """
    path, faults, preset = scene_path(path), Faults(), plain_value("preset", preset)
    if isinstance(preset, Mapping):
        raise tribo.InputError(
            "preset: a mapping is not text; entries of a scene go into overrides="
        )
    settings = {} if preset is None else {"fidelity.preset": preset}
    try:
        document = _overridden(read_document(path), {**settings, **(overrides or {})}, faults)
        source = Source(path.stem, document.entries, Files(document.folders))
        sweep = source.read(faults)
    except (tribo.InputError, tribo.InvariantError, RecursionError) as error:
        raise SceneFileError(path, [str(error)]) from error
    if sweep is None or faults:
        raise SceneFileError(path, [*map(document.line, faults)])
    return replace(sweep, notes=(*sweep.notes, *_notes_on_unused_materials(document, sweep)))


def _overridden(document: Document, overrides: Mapping[str, Any], faults: Faults) -> Document:
    """The document with values by key path, before which ``fidelity.`` may be left out."""
    values, settings = dict(overrides), TableKind(FidelityTable).keys
    document = document.without(plain_value("without", values.pop("without", None)))
    table: Entries = {}
    for name, value in values.items():
        key = f"fidelity.{name}" if name in settings else name
        if key != name and key in values:
            faults.refuse(key, f"is given twice, also as {name}; give it once")
        elif not ("." in key or (key in TableKind(SceneFile).keys and key != "extends")):
            hint = did_you_mean(key, [*settings, *scene_entries()])
            faults.refuse(key, f"unknown key{hint}; give an entry such as wear.pattern or title")
        elif key.count(".") >= _MAX_LEVELS:
            faults.refuse(key[:80], f"no entry has more than {_MAX_LEVELS} parts")
        elif value is None:
            faults.refuse(key, f'is None; to leave it out, set without = ["{key}"]')
        else:
            with faults.at(key):
                table = replace_value(table, key, plain_value(key, value))
    return override(document, table)


@dataclass(frozen=True)
class Source:
    """Entries of a scene file, merged; a sweep is read from them again when an entry changes.

    `user_parts` and `conditions` replace what was read, as in `Sweep.with_scene` and `Sweep.judge`.
    """

    name: str
    entries: Entries
    files: Files
    user_parts: Mapping[str, Any] = field(default_factory=dict)
    conditions: Mapping[str, Any] = field(default_factory=dict)

    def read(self, faults: Faults) -> Sweep | None:
        """Read the sweep; None if an entry is faulty, with all faults added to `faults`.

        An `InputError` is raised for the first fault that only a case of the sweep shows.
        """
        entries, rows = with_first_case(self.entries, self.files, faults)
        if rows is None:  # faulty rows give no loads and velocities
            return None
        entries = with_listed_tests(entries, self.files, faults)
        scene = build(entries, self.files, faults)
        if scene is None:
            return None
        cases = listed_cases(scene, rows)
        seeds = cases.table.column("realization")
        if seeds and isinstance(scene.case.scene.roughness, tribo.SelfAffineRoughness):
            seed = seeds[0]  # the scene itself has the first surface, as with areas of a scan
            entries = replace_values(entries, {SEED_ENTRY: seed})
            scene = replace(scene, case=scene.case.on_surface(seed))
        tests = read_tests(entries, self.files, scene, faults)
        key = "sweep.along" if rows else "sweep.over"
        declared = scene.tables.sweep
        sweep = Sweep(
            name=self.name,
            title=scene.tables.title or self.name,
            note=scene.tables.note,
            base=scene.case,
            cases=() if faults else tuple(read_cases(entries, self.files, scene, cases, key)),
            case_table=cases.table,
            loads=declared.loads,
            velocities=declared.velocities,
            fields=declared.fields,
            steps=declared.steps,
            tests=tests,
            notes=tuple(faults.notes),
            warnings=tuple(faults.warnings),
            sources=scene.sources,
            text=text_of(resolve_library(dict(entries), Faults())[0]),
            source=self,
        )
        sweep.require_few_points()
        return sweep

    def changed(self, path: str, value: Any) -> Sweep:
        """The sweep with another value of an entry; `InputError` for the first fault."""
        if path.count(".") >= _MAX_LEVELS:
            raise tribo.InputError(f"{path[:80]}: no entry has more than {_MAX_LEVELS} parts")
        for table in (TABLE_OF_PART[name] for name in self.user_parts):
            if f"{path}.".startswith(f"{table}."):
                raise tribo.InputError(
                    f"{path} has no effect, since with_scene has replaced {table}"
                )
        values = {path: plain_value(path, value)}
        source = replace(self, entries=replace_values(self.entries, values))
        sweep = source.read(faults := Faults())
        if faults or sweep is None:
            raise tribo.InputError(f"{faults[0].key}: {faults[0].problem}")
        return sweep.with_scene(**self.user_parts).judge(self.conditions)

    def warnings(self, sweep: Sweep) -> tuple[SceneWarning, ...]:
        """Warnings of probable mistakes in a sweep of this scene."""
        return warnings_of_all(sweep)


def _notes_on_unused_materials(document: Document, sweep: Sweep) -> Iterator[SceneNote]:
    """Notes on materials of a file that neither pin nor disk has in any case or test."""
    entries = document.entries
    tests = [test for test in entries.get("tests", []) if isinstance(test, dict)]
    bodies = [{key: table for key, table in entries.items() if key in ("pin", "disk")}, *tests]
    rows = sweep.case_table.rows
    names = {value for row in rows for value in row.values() if isinstance(value, str)}
    names |= {str(v) for body in bodies for path, v in flat(body) if path.endswith(".material")}
    for name in (name for name in document.of_file.get("materials", {}) if name not in names):
        words = f"no part has this material; set pin.material = {quoted(name)}, or remove it"
        yield SceneNote(key_path("materials", name), words)


def sweep_of(scene: SceneLike) -> Sweep:
    """Read a sweep from a path, with the errors of `load_scene`; return a sweep unchanged."""
    if isinstance(scene, Sweep):
        return scene
    if not isinstance(scene, str | PathLike):
        problem = f"a scene is of type {type(scene).__name__}"
        raise tribo.InputError(f"{problem}; give a Sweep, or the path of a scene")
    return load_scene(scene)


@np.errstate(under="ignore")
def run_point(
    sweep: SceneLike,
    load: float | str,
    velocity: float | str,
    realization: int | None = None,
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
        One of ``sweep.realizations``: the seed of a random surface, or the area of a scan; by
        default that of the scene itself.
    progress : callable, optional
        Called with a `Progress` after each of the point's steps.

    Raises
    ------
    TriboError
        If a text is not a load or a velocity, the scene has no such surface, or
        `tribo.simulate` raises an error.

    Examples
    --------
    >>> import pipeline
    >>> scene = pipeline.load_scene("workflows/first_try.toml")
    >>> point = pipeline.run_point(scene, "600 N", "1.5 m/s")
    >>> verdict = point.verdict(scene.conditions)
    >>> verdict.is_severe, f"{verdict.max_temperature - 273.15:.0f} °C"
    (False, '162 °C')
    """
    case_name: tuple[tuple[str, int], ...] = ()
    if realization is not None:
        case_name = (("realization", SEED.argument("realization", realization)),)
    point = Point(LOAD.argument("load", load), VELOCITY.argument("velocity", velocity), case_name)
    sweep = sweep_of(sweep)
    scene, stored_steps = sweep.case(case_name).scene, choose_stored_steps(sweep)
    return plan.run_point(scene, stored_steps, point, progress=progress or silent)
