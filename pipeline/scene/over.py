"""Entries with several values: ``[sweep] over``, by the paths of entries.

Every combination is read as if its values stood in the file, or were given by ``--set``.
"""

from __future__ import annotations

import itertools
import math
from collections.abc import Container, Iterator, Mapping, Sequence
from dataclasses import replace
from typing import Any

from pipeline.scene.declare import flat
from pipeline.scene.document import Document
from pipeline.scene.extensions import Extend, Make, Reading
from pipeline.scene.faults import Faults, entry_at, quoted
from pipeline.scene.units import UnitError, si_unit, to_si
from pipeline.sweep.limits import MOST_SCENES
from pipeline.sweep.model import Sweep, differing_inputs
from pipeline.sweep.remarks import remarks
from pipeline.sweep.variants import VARIANT, Column, Variants, combinations
from tribo import InputError

_FIXED = ("sweep", "title", "extends", "without", "measured", "tested", "unknown")
_SAME = ("loads", "velocities", "variants", "unequal_bulks", "steps")


def begin(document: Document, faults: Faults) -> tuple[Document, Extend]:
    """The document with the first values as its lowest layer, and what makes their table."""
    over = entry_at(document.entries(), "sweep.over")
    listed = flat(over) if isinstance(over, dict) else ()
    return document.above({path: v[0] for path, v in listed if isinstance(v, list) and v}), _extend


def _extend(sweep: Sweep, reading: Reading) -> Sweep:
    """The sweep with a row for every combination; `InputError` at the first that is unfit."""
    asked = reading.scene.sweep.over
    if not asked:
        return sweep
    axes = {path: _axis(path, values) for path, values in asked.items()}
    if (count := math.prod(len(axis.values) for axis in axes.values())) > MOST_SCENES:
        raise InputError(f"sweep.over: {count} values are too many; give {MOST_SCENES} at most")
    names = combinations({path: axis.values for path, axis in axes.items()})
    texts = {path: axis.text_of for path, axis in axes.items()}
    written = [{path: texts[path][value] for path, value in name} for name in names]
    scenes = [scene_with(values, sweep, reading.make, "sweep.over") for values in written]
    parts = tuple(tuple(differing_inputs(sweep, scene)) for scene in scenes)
    if len(parts) > 1 and all(part == parts[0] for part in parts):
        raise InputError(
            f"sweep.over: {' and '.join(asked)} changes nothing in this scene; leave it out"
        )
    columns = tuple(
        axis.taken([axis.values.index(dict(name)[path]) for name in names])
        for path, axis in axes.items()
    )
    return sweep.changed(variants=Variants(columns, parts) * sweep.variants)


def notes_on_first_values(table: Variants) -> Iterator[str]:
    """Notes that a command prints which computes one value of each entry alone."""
    for column in table.chosen:
        words = (
            f"sweep.over is ignored here; {column.name} is the scene's own or the first listed: "
            f'--set "{column.name}=..." takes another'
        )
        if column.name == VARIANT:
            words = (
                "sweep.along is ignored here; the scene's own values are taken, or those of its "
                "first row: --set takes others"
            )
        yield from remarks("note", words)


def column_of(path: str, values: Sequence[Any], owner: str) -> Column:
    """Values of an entry in SI, or words where they are not of one dimension."""
    meaning, first = f"{path} of the {owner}", values[0]
    try:
        if isinstance(first, str):
            in_si = tuple(to_si(str(value), like=first) for value in values)
            return Column(path, in_si, si_unit(first), meaning=meaning, texts=tuple(values))
        return Column(path, tuple(map(float, values)), meaning=meaning)
    except (UnitError, TypeError, ValueError):
        return Column(path, tuple(map(str, values)), None, meaning=meaning)


def _axis(path: str, values: tuple[Any, ...]) -> Column:
    """An entry with its values in SI in rising order, or as words."""
    key = f"sweep.over.{quoted(path)}"
    if path.partition(".")[0] in _FIXED:
        raise InputError(
            f"{key}: this cannot take several values; give an entry of the scene, such as "
            '"pin.radius"'
        )
    if len({isinstance(value, str) for value in values}) > 1:
        raise InputError(f"{key}: {quoted(list(values))}: give all with a unit, or none")
    column = column_of(path, values, "scene")
    if column.unit is None:
        return column
    pairs = sorted(zip(column.values, values, strict=True), key=lambda pair: pair[0])
    for (one, text), (other, again) in itertools.pairwise(pairs):
        if one == other:
            both = f"{quoted(text)} and {quoted(again)}"
            raise InputError(f"{key}: {both} are the same; give each value once")
    labels, texts = zip(*pairs, strict=True)
    return replace(column, values=labels, texts=texts)


def scale_friction(scene: Sweep, sweep: Sweep, changed: Container[str]) -> Sweep:
    """A scene with entries of a sweep changed: its friction coefficient scales its curves.

    In a file `friction.by_velocity` and `by_temperature` are the friction itself, and the
    coefficient a typical one.
    """
    present, own = scene.conditions.corrections, sweep.conditions.corrections
    if "friction.coefficient" not in changed or not (present and own):
        return scene
    corrections = replace(present, friction=own.friction)
    return scene.changed(conditions=replace(scene.conditions, corrections=corrections))


def scene_with(values: Mapping[str, Any], sweep: Sweep, make: Make, key: str) -> Sweep:
    """The scene with some values; raises if it is faulty, or has other axes."""
    place = ", ".join(f"{path} = {quoted(value)}" for path, value in values.items())
    try:
        scene = scale_friction(make(values), sweep, values)
    except InputError as error:
        raise InputError(f"{key}: {place}: {error}") from error
    for name in _SAME:
        if scene.get(name) != sweep.get(name):
            raise InputError(
                f"{key}: {place} changes the {name.replace('_', ' ')}, which must be "
                "the same for all values; sweep each value into a separate store"
            )
    if sweep.record.fields and scene.scene.grid != sweep.scene.grid:
        raise InputError(
            f"{key}: {place} changes the grid of the stored fields, which every value has in "
            "common; leave out sweep.fields, or give an entry that keeps the grid"
        )
    return scene
