"""Entries with several values: ``[sweep] over``, by the paths of entries, and ``wear_rates``.

Every combination is read as if its values stood in the file, or were given by ``--set``.
"""

from __future__ import annotations

import itertools
import math
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import replace
from typing import Any, cast

from pipeline.scene.compounds import flat
from pipeline.scene.distributions import Make, differing_inputs, require_around
from pipeline.scene.document import Document
from pipeline.scene.faults import entry_at, quoted
from pipeline.scene.units import UnitError, display, si_unit, to_si
from pipeline.sweep.model import Sweep
from pipeline.sweep.variants import VARIANT, WEAR_RATE, Column, Variants, combinations, wear_rates
from tribo import InputError, Wear

_FIXED = ("sweep", "title", "extends", "without", "measured", "tested", "unknown")
_SAME = ("loads", "velocities", "variants", "unequal_bulks", "independent", "steps")
_ASKED_BY = {VARIANT: "along", WEAR_RATE: "wear_rates"}  # entries that fill these dimensions
_MOST = 10_000  # combinations, each of which is read as a scene
_RATIO = 1.3  # of neighbouring velocities beyond those of the scene, at most


def over_of(asked: Mapping[str, tuple[Any, ...]] | None, sweep: Sweep, make: Make) -> Variants:
    """Table of every combination of entries' values; `InputError` at the first that is unfit."""
    if not asked:
        return Variants()
    axes = {path: _axis(path, values) for path, values in asked.items()}
    names = combinations({path: axis.values for path, axis in axes.items()})
    if len(names) > _MOST:
        raise InputError(
            f"sweep.over: {len(names)} combinations are too many; give {_MOST} at most"
        )
    texts = {path: axis.text_of for path, axis in axes.items()}
    written = [{path: texts[path][value] for path, value in name} for name in names]
    scenes = [scene_with(values, sweep, make, "sweep.over") for values in written]
    parts = tuple(tuple(differing_inputs(sweep, scene)) for scene in scenes)
    if len(parts) > 1 and all(part == parts[0] for part in parts):
        raise InputError(
            f"sweep.over: {' and '.join(asked)} changes nothing in this scene; leave it out"
        )
    columns = tuple(
        axis.taken([axis.values.index(dict(name)[path]) for name in names])
        for path, axis in axes.items()
    )
    return Variants(columns, parts)


def notes_on_first_values(table: Variants) -> Iterator[str]:
    """Notes that a command prints which computes one value of each entry alone."""
    for column in table.chosen:
        if asked_by := _ASKED_BY.get(column.name):
            yield (
                f"note: sweep.{asked_by} is ignored here; the scene's own values are taken, or "
                "those of its first row: --set takes others"
            )
        else:
            yield (
                f"note: sweep.over is ignored here; {column.name} is the scene's own or the first "
                f'listed: --set "{column.name}=..." takes another'
            )


def with_first_values(document: Document) -> Document:
    """The document with the first values of ``over`` as its lowest layer."""
    over = entry_at(document.entries(), "sweep.over")
    listed = flat(over) if isinstance(over, dict) else ()
    return document.above({path: v[0] for path, v in listed if isinstance(v, list) and v})


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


def scene_with(values: Mapping[str, Any], sweep: Sweep, make: Make, key: str) -> Sweep:
    """The scene with some values; raises if it is faulty, or has other axes."""
    place = ", ".join(f"{path} = {quoted(value)}" for path, value in values.items())
    try:
        scene = make(values)
    except InputError as error:
        raise InputError(f"{key}: {place}: {error}") from error
    settings = (f"--set={path}={value}" for path, value in values.items())
    scene = scene.changed(arguments=(*sweep.about.arguments, *settings))
    for name in _SAME:
        if scene.get(name) != sweep.get(name):
            raise InputError(
                f"{key}: {place} changes the {name.replace('_', ' ')}, which every value has "
                "in common; sweep it in stores of its own"
            )
    if sweep.record.fields and scene.scene.grid != sweep.scene.grid:
        raise InputError(
            f"{key}: {place} changes the grid of the stored fields, which every value has in "
            "common; leave out sweep.fields, or give an entry that keeps the grid"
        )
    return scene


def with_rates_of(asked: Mapping[str, float] | None, sweep: Sweep, notes: list[str]) -> Sweep:
    """The sweep with rows at several wear rates, from the lowest to the highest asked for [m²/N].

    Velocities are added, with a note, so that every rate covers the scene's own velocities.
    """
    if not asked or sweep.variants.draw:  # whose inputs have it
        return sweep
    require_around(asked, sweep)
    (low, high), wear = asked.values(), cast(Wear, sweep.scene.wear)
    own = wear.specific_wear_rate
    if any(sweep.variant(name).scene.wear != wear for name in sweep.variants.given):
        raise InputError(
            "sweep.wear_rates: sweep.over changes the wear, too; leave out one or the other"
        )
    moving = [velocity for velocity in sweep.plane.velocities if velocity > 0]
    further = [*_beyond(moving[0], low / own), *_beyond(moving[-1], high / own)] if moving else []
    if further:
        ends = " and ".join(display(end, "m/s", 4) for end in (min(further), max(further)))
        notes.append(
            f"sweep.wear_rates: {len(further)} velocities down and up to {ends} are added, so that "
            "every wear rate has the scene's velocities"
        )
    velocities = tuple(sorted({*sweep.plane.velocities, *further}))
    table = wear_rates(own, low, high) * sweep.variants
    return sweep.changed(variants=table, velocities=velocities)


def _beyond(velocity: float, factor: float) -> list[float]:
    """Velocities from one, without it, to a multiple of it [m/s]."""
    count = math.ceil(abs(math.log(factor)) / math.log(_RATIO) - 1e-9)
    return [float(f"{velocity * factor ** (n / count):.4g}") for n in range(1, count + 1)]
