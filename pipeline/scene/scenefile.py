"""Scene files: TOML with units, read into a `Sweep`, with all faults at once."""

from __future__ import annotations

from collections.abc import Mapping
from importlib import import_module
from os import PathLike
from typing import Any, Literal

import numpy as np

import tribo
from pipeline.scene.declare import table_of
from pipeline.scene.document import (
    Document,
    Extend,
    override_entries,
    read_document,
    without_empty_tables,
)
from pipeline.scene.faults import Faults, SceneFileError, did_you_mean
from pipeline.scene.fidelity import FidelityTable
from pipeline.scene.format import SceneFile
from pipeline.scene.parts import Contents
from pipeline.scene.reading import SceneReader
from pipeline.scene.reference import FILES, all_keys
from pipeline.scene.shipped import scene_path
from pipeline.scene.source import Source, read_sweep
from pipeline.scene.units import in_si
from pipeline.sweep import plan
from pipeline.sweep.limits import MOST_POINTS
from pipeline.sweep.model import Point, Sweep
from pipeline.sweep.plan import choose_stations
from pipeline.sweep.stages import Report, silent
from pipeline.sweep.tables import Entries, entry_at, flat, replace_value, replace_values
from pipeline.sweep.variants import SEED, surfaces


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
        Entries of the scene by key path, such as ``wear.pattern`` or ``title``, which replace the
        file's; or fields of `tribo.Fidelity`, which are applied last. ``without`` lists entries of
        the file to leave out first.

    Raises
    ------
    SceneFileError
        If there is any fault in the file or the arguments; the error carries all faults.

    Examples
    --------
    >>> import pipeline
    >>> scene = pipeline.load_scene("workflows/first_try.toml", preset="standard")
    >>> scene.preset, scene.loads
    ('standard', (200.0, 400.0, 600.0, 750.0))
    """
    path, faults = scene_path(path), Faults()
    replaced = _path_overrides(overrides or {}, preset, faults)
    document = override_entries(read_document(path, faults), replaced, faults)
    document = without_empty_tables(document, faults)
    document, extensions = _begin_extensions(document, faults)
    entries = document.entries()
    folders = {file: document.file_of(file).parent for file in FILES}
    reader = SceneReader(Contents(folders=folders))
    try:
        parts = reader.read_all(entries, faults)
        if parts is not None:
            first, wanted = entry_at(parts.declared, SEED), parts.declared.sweep.realizations or ()
            seeds = range(first, first + wanted) if isinstance(wanted, int) else sorted(wanted)
            if seeds and seeds[0] != first:
                entries = replace_value(entries, SEED, seeds[0])
                parts = reader.read(entries)
            sweep = read_sweep(
                path.stem,
                Source(replace_values(entries, parts.contents), reader),
                surfaces(seeds),
                notes=faults.notes,
                sources=parts.sources,
                faults=faults,
            )
            for extend in () if faults else extensions:
                sweep = extend(sweep)
            _require_few_points(sweep)
    except (tribo.InputError, tribo.InvariantError) as error:
        raise SceneFileError(path, [_with_path(str(error), entries)]) from error
    if parts is None or faults:
        raise SceneFileError(path, [*map(document.line, faults)])
    return sweep


def _begin_extensions(document: Document, faults: Faults) -> tuple[Document, list[Extend]]:
    """Let extensions (`over`, `along`, logs) change a scene; return what adds variants."""
    extensions, entries = list[Extend](), document.entries()
    # Modules with a function ``begin``, imported only where a scene needs them.
    named = [([f"sweep.{name}"], f"pipeline.scene.{name}") for name in ("over", "along")]
    named.append((["measured", "tested"], "pipeline.scene.logs"))
    for paths, module in named:
        if not any(entry_at(entries, path) is not None for path in paths):
            continue
        with faults.at(paths[0]):
            document, extend = import_module(module).begin(document, faults)
            extensions += [extend] if extend else []
            continue
        for path in paths:  # a faulty entry is removed, so that it has no further faults
            document = document.replaced(path, None)
    return document, extensions


def _with_path(words: str, entries: Entries) -> str:
    """Put the full paths of entries before an error message that begins with their name."""
    name = words.partition(" ")[0]
    paths = [name] if name in entries else [p for p, _ in flat(entries) if p.endswith(f".{name}")]
    return f"{' and '.join(paths)}: {words}" if paths else words


def _require_few_points(sweep: Sweep) -> None:
    """Raise an `InputError` if a sweep has too many points, before they are made."""
    rows = sweep.variants
    loads = len(sweep.loads) if rows.labels("load") is None else 1
    velocities = len(sweep.velocities) if rows.labels("velocity") is None else 1
    if (count := len(rows) * loads * velocities) > MOST_POINTS:
        raise tribo.InputError(
            f"sweep: {count:.4g} points are too many; give {MOST_POINTS:.0e} at most, by fewer "
            "loads, velocities or variants"
        )


PresetName = Literal["standard", "fine", "reference"]
SceneLike = Sweep | str | PathLike[str]
"""A scene that was read, or its path or the name of a shipped one."""


def sweep_of(scene: SceneLike) -> Sweep:
    """Read a sweep from a path, with the errors of `load_scene`; return a sweep unchanged."""
    return scene if isinstance(scene, Sweep) else load_scene(scene)


def _path_overrides(
    overrides: Mapping[str, Any], preset: str | None, faults: Faults
) -> dict[str, Any]:
    """`overrides` and `preset` as entries by full key path; ``fidelity.`` may be left out."""
    replaced: dict[str, Any] = {} if preset is None else {"fidelity.preset": preset}
    choices = table_of(FidelityTable).listed
    for key, value in overrides.items():
        if key in choices:
            replaced[f"fidelity.{key}"] = value
        elif "." in key or (key in table_of(SceneFile).keys and key != "extends"):
            replaced[key] = value
        else:
            hint = did_you_mean(key, [*choices, *(path for path, _ in all_keys())])
            faults.refuse(key, f"unknown key{hint}; give an entry such as wear.pattern or title")
    return replaced


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
        Seed of one of the scene's several random surfaces, ``sweep.realizations``; by default the
        seed of the scene itself.
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
    (False, '158 °C')
    """
    place = in_si("load", load, "600 N"), in_si("velocity", velocity, "1.5 m/s")
    variant = () if realization is None else (("realization", realization),)
    sweep = sweep_of(sweep)
    scene, stations = sweep.case(variant).scene, choose_stations(sweep)
    return plan.run_point(scene, stations, Point(*place, variant), progress=progress or silent)
