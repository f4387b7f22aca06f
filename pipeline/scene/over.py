"""Entries with several values: ``[sweep] over``, by the paths of entries.

Every combination is read as if its values stood in the file, or were given by ``--set``.
"""

from __future__ import annotations

import itertools
from collections.abc import Mapping
from typing import Any

from pipeline.scene.document import Document, Layer
from pipeline.scene.faults import Faults, quoted, with_value
from pipeline.scene.schema import flat
from pipeline.scene.units import UnitError, si_unit, to_si
from pipeline.scene.unknown import Make, differing
from pipeline.sweep.model import Sweep
from pipeline.sweep.over import Axis, Over, Variant, combinations
from tribo import InputError, Scene, inseparable, mechanics, wear_number

_FIXED = ("sweep", "title", "extends", "without", "measured", "tested", "unknown")
_SAME = (
    "loads", "velocities", "realizations", "wear_rates", "unequal_bulks", "independent",
)  # fmt: skip
_MOST = 10_000  # combinations, each of which is read as a scene


def over_of(asked: Mapping[str, tuple[Any, ...]] | None, sweep: Sweep, make: Make) -> Over | None:
    """Entries with several values, by their paths as TOML has them, and the scenes with them.

    `InputError` is raised at the first value that does not go with the scene.
    """
    if not asked:
        return None
    axes = tuple(_axis(path, values) for path, values in asked.items())
    written = {axis.path: dict(zip(axis.values, axis.written, strict=True)) for axis in axes}
    variants = combinations({axis.path: axis.values for axis in axes})
    if len(variants) > _MOST:
        raise InputError(
            f"sweep.over: {len(variants)} combinations are too many; give {_MOST} at most"
        )
    scenes = {
        variant: _scene({path: written[path][value] for path, value in variant}, sweep, make)
        for variant in variants
    }
    parts = {variant: tuple(differing(sweep, scene)) for variant, scene in scenes.items()}
    if len(scenes) > 1 and all(scene == scenes[variants[0]] for scene in scenes.values()):
        raise InputError(
            f"sweep.over: {' and '.join(asked)} changes nothing in this scene; leave it out"
        )
    return Over(axes, parts, _leads(scenes))


def with_first_values(document: Document) -> Document:
    """The document with the first values of ``over`` below all that it has itself."""
    sweep, first = document.entries().get("sweep"), dict[str, Any]()
    over = sweep.get("over") if isinstance(sweep, dict) else None
    for path, values in flat(over) if isinstance(over, dict) else ():
        if isinstance(values, list) and values:
            first = with_value(first, path, values[0])
    return Document((*document.layers, Layer(document.file, first)))


def _axis(path: str, values: tuple[Any, ...]) -> Axis:
    """An entry with its values in SI, or as words."""
    key = f"sweep.over.{quoted(path)}"
    if path.partition(".")[0] in _FIXED:
        raise InputError(
            f"{key}: this cannot take several values; give an entry of the scene, such as "
            '"pin.radius"'
        )
    first, unit = values[0], "1"
    if any(isinstance(value, str) != isinstance(first, str) for value in values):
        raise InputError(f"{key}: {quoted(list(values))}: give all with a unit, or none")
    labels = values
    if isinstance(first, str):
        try:
            labels, unit = tuple(to_si(value, like=first) for value in values), si_unit(first)
        except UnitError:
            return Axis(path, values, values, None)
    pairs = sorted(zip(map(float, labels), values, strict=True), key=lambda pair: pair[0])
    for (one, text), (other, again) in itertools.pairwise(pairs):
        if one == other:
            both = f"{quoted(text)} and {quoted(again)}"
            raise InputError(f"{key}: {both} are the same; give each value once")
    labels, values = zip(*pairs, strict=True)
    return Axis(path, labels, values, unit)


def _scene(values: Mapping[str, Any], sweep: Sweep, make: Make) -> Sweep:
    """The scene with some values; raises if it is faulty, or has other axes."""
    place = ", ".join(f"{path} = {quoted(value)}" for path, value in values.items())
    faults = Faults()
    try:
        scene = make(values, faults)
    except InputError as error:
        raise InputError(f"sweep.over: {place}: {error}") from error
    if scene is None:
        key, problem, _ = faults[0]
        problem = problem if key == next(iter(values)) else f"{key}: {problem}"
        raise InputError(f"sweep.over: {place}: {problem}")
    settings = (f"--set={path}={value}" for path, value in values.items())
    scene = scene.changed(arguments=(*sweep.about.arguments, *settings))
    for name in _SAME:
        if scene.get(name) != sweep.get(name):
            raise InputError(
                f"sweep.over: {place} changes the {name.replace('_', ' ')}, which every value has "
                "in common; sweep it in stores of its own"
            )
    if sweep.record.fields and scene.scene.grid != sweep.scene.grid:
        raise InputError(
            f"sweep.over: {place} changes the grid of the stored fields, which every value has in "
            "common; leave out sweep.fields, or give an entry that keeps the grid"
        )
    return scene


def _leads(scenes: Mapping[Variant, Sweep]) -> dict[Variant, Variant]:
    """First combination with the contacts of each."""
    first: dict[tuple[Scene, float], Variant] = {}
    leads = {}
    for variant, scene in scenes.items():
        is_shared = inseparable(scene.scene, scene.plane.velocities) is None
        contact = mechanics(scene.scene), wear_number(scene.scene, 1.0)
        leads[variant] = first.setdefault(contact, variant) if is_shared else variant
    return leads
