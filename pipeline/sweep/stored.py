"""The sweep of a store: how it is kept, and continued by another sweep."""

from __future__ import annotations

import functools
from collections.abc import Iterator, Mapping
from dataclasses import fields, replace
from typing import Any

from pipeline.sweep.codec import content_hash, differences, encode
from pipeline.sweep.model import Point, Sweep, named
from pipeline.sweep.samples import Design
from pipeline.sweep.station_choice import choose_stations
from pipeline.sweep.variants import Variant, Variants
from tribo import InputError


def join(before: Sweep | None, sweep: Sweep) -> Sweep:
    """The sweep of a store after another run: rows of both, else as the present scene says.

    What is kept of each point, and the reasons for a fidelity, stay those of the first run. Of
    points that were chosen it says that they were, and the store which.
    """
    first = before or sweep
    about, plane = sweep.about, sweep.plane
    return replace(
        sweep,
        plane=plane if plane.chosen is None else replace(plane, chosen=()),
        variants=first.variants.union(sweep.variants),
        record=replace(first.record, stations=choose_stations(first)),
        about=replace(about, selection=about.selection or first.about.selection),
    )


def misfits(stored: Sweep, sweep: Sweep) -> Iterator[str]:
    """Say why a sweep cannot go on with the store of another one; nothing where it can."""
    old, new = stored.variants, sweep.variants
    if [*old.axes] != [*new.axes]:
        have, gives = (", ".join(table.axes) or "none" for table in (old, new))
        by = "by sweep.over, realizations or samples"
        yield f"axes {by}: {have} in the store, {gives} in the scene"
        return
    if different := [*differences(_design(old), _design(new), "scene.samples")]:
        yield from different
        return
    yield from _different_scenes(stored, sweep)
    labels = {column.name: values for column, values in old.coordinates.items()}
    for column, values in new.coordinates.items():
        held = labels.get(column.name, {})
        for label in (label for label in values if label in held):
            yield from differences(held[label], values[label], f"{column.name}.{label}")
    if sweep.record.steps is not None:
        steps = choose_stations(stored).steps
        yield from differences(steps, sweep.record.steps, "sweep.steps")
    fields = stored.record.fields
    yield from differences(fields, fields or sweep.record.fields, "sweep.fields")
    try:
        old.union(new)
    except InputError as error:
        yield str(error)


def _design(table: Variants) -> Design | None:
    """The rule by which samples of a table were drawn, without what decides no sample."""
    if table.draw is None:
        return None
    inputs = (replace(one, written=None, correlated=()) for one in table.draw.design.inputs)
    return replace(table.draw.design, inputs=tuple(inputs))


def _different_scenes(stored: Sweep, sweep: Sweep) -> Iterator[str]:
    """Fields in which the first row differs that both have, but not with the same scene."""
    old, new = stored.variants, sweep.variants
    shared = [name for name in new.names if name in old]
    plain = [
        encode((one.scene, tuple(one.variants.part(name) for name in shared)), {})
        for one in (stored, sweep)
    ]
    if plain[0] == plain[1]:
        return
    for name in shared:
        scenes = stored.variant(name).scene, sweep.variant(name).scene
        key = f"scene with {', '.join(named(name))}: scene" if name else "scene"
        if different := [*differences(*scenes, key)]:
            yield from different
            return


def scene_ids(sweep: Sweep, choices: Mapping[str, Any]) -> list[int]:
    """Digest of what acts on the simulation and the verdict of each row of a sweep, int32.

    `choices` are of tests: the oil whose tests count, and the scatter by which they weigh samples.
    """
    draw, ids = sweep.variants.draw, []
    inputs = (draw.unknown, draw.fixed) if draw else ()
    part_hash = functools.lru_cache(None, typed=True)(content_hash)  # rows share large surfaces
    for name in sweep.variants.names:
        row = sweep.variant(name)
        parts = [part_hash(getattr(row.scene, one.name)) for one in fields(row.scene)]
        about = replace(row.about, name="", title="", sources=(), notes=())
        digest = content_hash((*parts, row.conditions, about, inputs, choices))
        ids.append(int.from_bytes(bytes.fromhex(digest[:8]), signed=True))
    return ids


class Simulated:
    """Hash of what is simulated at each point of a sweep."""

    def __init__(self, sweep: Sweep) -> None:
        self._sweep = sweep
        self._hashes: dict[Variant, str] = {}  # which goes to other processes; no cache does

    def at(self, point: Point) -> str:
        """Hash of what is simulated at a point."""
        name = point.variant
        if name not in self._hashes:
            self._hashes[name] = content_hash(self._sweep.variant(name).scene)
        return self._hashes[name]
