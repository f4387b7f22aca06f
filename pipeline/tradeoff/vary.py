"""The boundary of a scene, and of the same scene with one entry changed at a time."""

from __future__ import annotations

import json
import math
import re
from collections import ChainMap
from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any

import numpy as np
import pandas as pd

from pipeline.analysis.at import at
from pipeline.analysis.boundary import boundary, boundary_frame
from pipeline.analysis.warned_points import Warned, warned
from pipeline.constants import USUAL_TOLERANCE
from pipeline.run.cluster import Client
from pipeline.run.goal import Searches
from pipeline.run.sweep import Cluster, run_points
from pipeline.scene.over import notes_on_first_values
from pipeline.scene.scenefile import PresetName, load_scene
from pipeline.scene.units import NUMBER
from pipeline.store.place import PathLike
from pipeline.store.schema import DONE
from pipeline.store.write import opened
from pipeline.sweep.conditions import PATHS
from pipeline.sweep.model import Sweep
from pipeline.sweep.shown import shown
from pipeline.sweep.stages import Progress, Report
from pipeline.sweep.tables import changes, entry_at
from pipeline.sweep.variants import Label, labelled_rows
from tribo import InputError
from tribo.simulation import mechanics

_ROW, _UNCHANGED = "variation", "unchanged"  # dimension, and label of the first scene
_RELATIVE = re.compile(r"([+-]\d+(?:\.\d+)?)\s*%")
# A number with its unit, except degrees and Rockwell hardness, whose zero is arbitrary.
_NUMBER = re.compile(rf"\s*{NUMBER}(?!.*([CF℃]|HRc|degRe|celsius|fahrenheit)\s*$)")


@shown
@dataclass(frozen=True, slots=True)
class Variations:
    """Boundaries of a scene: unchanged, and with one entry changed at a time."""

    title: str  #: Title of the scene.
    #: A row for each variation and load: ``entry`` and ``value`` as a scene file would give them,
    #: ``load [N]``, ``critical velocity [m/s]``, ``change [%]`` and ``outcome``. First the
    #: ``unchanged`` scene, then the entry that moves the boundary most.
    table: pd.DataFrame
    points: int  #: Points computed, over all scenes.
    contacts: int  #: Contacts computed for these points; scenes may share them.
    #: Points that carry a warning, over all scenes.
    warned: Warned = field(default_factory=Warned)


@np.errstate(under="ignore")
def vary(
    scene: PathLike,
    over: Mapping[str, Iterable[Any]],
    preset: PresetName | None = None,
    overrides: Mapping[str, Any] | None = None,
    laws: Mapping[str, Any] | None = None,
    out: PathLike | None = None,
    workers: int | None = None,
    client: Client | None = None,
    progress: Report | None = None,
) -> Variations:
    """Find the boundary of a scene, and of the same scene with single entries changed.

    The boundary is the computed one, on the first surface: tests and uncertain inputs do not count.
    Scenes that differ only in friction or temperatures share all points, and scenes that differ
    only in thermal constants share the contacts of their points. Points are computed on Dask as in
    `pipeline.run_sweep`: in a script, call this function under ``if __name__ == "__main__":``.

    Parameters
    ----------
    scene : path-like
        Scene file, or name of a shipped scene. The boundary is searched at its loads, between its
        lowest and highest velocity.
    over : mapping
        Values to try, by the key path of their entry. A value is written as in a scene file, or as
        a change of the scene's value, such as ``"+20%"``. If friction depends on velocity or
        temperature, a changed coefficient of friction scales the whole curve.
    preset, overrides, laws : optional
        Preset of numerical choices, values that replace entries, and own Python objects, as
        in `pipeline.load_scene`.
    out : path, optional
        Store of the points, resumed if it exists. By default it is temporary.
    workers, client, progress : optional
        Number of processes, Dask client, and callback for progress, as in `pipeline.run_sweep`. A
        note is reported if the scene has several values of an entry, of which one is used.

    Raises
    ------
    SceneFileError
        If a scene is faulty with one of the values.
    InputError
        If there is no friction or only one velocity, or a percentage is given for an entry that is
        not a number.

    Examples
    --------
    >>> import pipeline
    >>> over = {"pin.radius": ["1 mm", "+20%"], "temperature.bulk": ["40 degC"]}
    >>> variations = pipeline.vary("first_try", over)  # doctest: +SKIP
    """
    overrides, laws = overrides or {}, laws or {}
    sweep = load_scene(scene, preset, overrides, laws)
    if progress:
        for note in notes_on_first_values(sweep.variants):
            progress(Progress(note))
    others = {
        (key, str(value)): load_scene(scene, preset, {**overrides, key: value}, laws)
        for key, values in over.items()
        for value in _absolute_values(sweep, key, values)
    }
    variations = [(_UNCHANGED, ""), *others]
    scenes = [sweep, *others.values()]
    varied = _combine(sweep, variations, scenes)
    with TemporaryDirectory(prefix="irg-") as folder:
        path = Path(folder) / "points.zarr" if out is None else out
        varied = replace(varied, inputs=())  # they move no computed boundary
        searches = Searches(varied, USUAL_TOLERANCE, only_first=True)
        run_points(varied, path, searches, Cluster(workers, client), progress)
        store = opened(path)
        done = store.points_at(np.nonzero(store.flags == DONE))
        contacts = {
            (mechanics(varied.case(one.variant).scene), one.velocity, one.load) for one in done
        }
        ds = at(path, criterion=laws.get("criterion"))
        table, carried = _table(boundary_frame(boundary(ds)), variations), warned(ds)
    return Variations(sweep.title, table, len(done), len(contacts), carried)


def _table(found: pd.DataFrame, variations: Sequence[tuple[str, str]]) -> pd.DataFrame:
    """Make `Variations.table` from the boundaries `found`, with a (changed entry, value) each."""
    velocity = found["critical velocity [m/s]"].to_numpy().reshape(len(variations), -1)
    change = 100 * (velocity / velocity[0] - 1)
    change[0] = math.nan  # the unchanged scene
    entries, values = np.repeat(variations, velocity.shape[1], axis=0).T
    table = found[["load [N]", "critical velocity [m/s]", "outcome"]]
    table.insert(0, "entry", entries)
    table.insert(1, "value", values)
    table.insert(4, "change [%]", change.ravel())
    moved = table["change [%]"].abs().groupby(table["entry"]).transform("max").fillna(0.0)
    moved[table["entry"] == _UNCHANGED] = math.inf
    return table.iloc[np.argsort(-moved, kind="stable")].reset_index(drop=True)


def _combine(sweep: Sweep, variations: Sequence[tuple[str, str]], scenes: Sequence[Sweep]) -> Sweep:
    """One sweep with a variant for each of `scenes`, labelled by `variations`: (entry, value)."""
    words = (" = ".join(filter(None, variation)) for variation in variations)
    arrays = [one.source.reader.contents.arrays for one in (sweep, *scenes)]
    contents = replace(sweep.source.reader.contents, arrays=dict(ChainMap(*arrays)))
    rows: dict[Label, Any] = {
        label: {
            path: value
            for path, value in changes(sweep.entries, scene.entries)
            if not path.startswith("sweep.")
        }
        for label, scene in zip(words, scenes, strict=True)
    }
    table = labelled_rows(_ROW, rows)
    bases = zip(table.names, scenes, strict=True)
    return replace(
        sweep,
        cases=tuple(replace(scene.base, name=name) for name, scene in bases),
        variants=table,
        source=replace(sweep.source, reader=replace(sweep.source.reader, contents=contents)),
    )


def _absolute_values(sweep: Sweep, key: str, values: Iterable[Any]) -> Iterator[Any]:
    """Yield values of the entry `key`; ``"+20%"`` becomes 1.2 times the scene's value."""
    is_change = key == PATHS["unmodelled_rise"]
    for value in values:
        relative = _RELATIVE.fullmatch(value) if isinstance(value, str) and not is_change else None
        if relative is None:
            yield value
            continue
        present = entry_at(sweep.entries, key)
        number = _NUMBER.match(present if isinstance(present, str) else repr(present))
        if number is None:
            raise InputError(f"{key}={value}: the scene gives {present}, no number; give a value")
        changed = f"{float(number[0]) * (1 + float(relative[1]) / 100):.12g}"
        yield changed + present[number.end() :] if isinstance(present, str) else json.loads(changed)
