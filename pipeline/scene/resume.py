"""Continuing the store of another run with a sweep, or why that cannot be."""

from __future__ import annotations

import re
from collections.abc import Callable, Iterator
from dataclasses import replace
from typing import Any

from pipeline.scene.written import differing_entries
from pipeline.sweep.model import Sweep, digest, variant_words
from pipeline.sweep.plan import choose_stations
from pipeline.sweep.tables import entry_at
from tribo import InputError, TriboError


def join(before: Sweep | None, sweep: Sweep) -> Sweep:
    """Sweep of a store that is continued: variants of both runs, other data from `sweep`.

    Which steps and fields are stored stays as in the sweep `before`.
    """
    first = before or sweep
    joined = replace(sweep, stations=choose_stations(first), fields=first.fields)
    if before is None or before.variants == sweep.variants:
        return joined
    # Materials and surfaces that variants of the first run need.
    materials = {**before.entries["materials"], **sweep.entries["materials"]}
    arrays = sweep.source.reader.contents.arrays | before.source.reader.contents.arrays
    contents = replace(sweep.source.reader.contents, arrays=arrays)
    return replace(
        joined,
        entries={**sweep.entries, "materials": materials},
        variants=(union := before.variants.union(sweep.variants)),
        cases=tuple(
            (sweep if name in sweep.variants.by_name else before).case(name) for name in union.names
        ),
        source=replace(sweep.source, reader=replace(sweep.source.reader, contents=contents)),
    )


def misfits(stored: Sweep, sweep: Sweep, goal: str = "") -> Iterator[str]:
    """Reasons why a sweep cannot continue a store of the sweep `stored`; empty if it can.

    `goal` is the option that the store was last run with for an accuracy, if there is one.
    """
    growing = [f"the store is grown by: irg run SCENE {goal}"] * bool(goal)
    old, new = stored.variants, sweep.variants
    if [*old.axes] != [*new.axes]:
        have, gives = (", ".join(table.axes) or "none" for table in (old, new))
        by = "by sweep.over or realizations"
        yield f"axes {by}: {have} in the store, {gives} in the scene"
        if {*old.axes} - {*new.axes} == {"realization"}:
            yield from growing
        return
    for name in (name for name in new.names if name in old.by_name):
        before, after = (one._alone(name) for one in (stored, sweep))
        if different := [*effective_changes(before, after, lambda one: one.scene)]:
            row = f"scene with {', '.join(variant_words(name))}: " if name else ""
            yield from (f"{row}{words}" for words in different)
            if all(words.startswith("fidelity.") for words in different):
                yield from growing
            break  # one variant that differs is enough
    labels = {column.name: values for column, values in old.coordinates.items()}
    for column, values in new.coordinates.items():
        present = labels.get(column.name, {})
        for label, value in values.items():
            if present.get(label, value) != value:
                yield _differs(f"{column.name}.{label}", present[label], value)
    if (steps := sweep.steps) not in (None, choose_stations(stored).steps):
        yield _differs("sweep.steps", choose_stations(stored).steps, steps)
    if sweep.fields and not stored.fields:
        yield _differs("sweep.fields", "false", "true")
    try:
        old.union(new)
    except InputError as error:
        yield str(error)


def _differs(path: str, old: Any, new: Any) -> str:
    return f"{path}: {old} in the store, {new} in the scene"


def effective_changes(old: Sweep, new: Sweep, part: Callable[[Sweep], Any]) -> Iterator[str]:
    """Yield, in words, entries that differ between two sweeps, and that change ``part(sweep)``."""
    present = digest(part(old))
    if present == digest(part(new)):
        return
    for path, before, after in differing_entries(old, new):
        whole = re.split(r"\.\d+(?=\.|$)", path)[0]  # without the number in a list
        try:
            is_same = digest(part(old.changed(whole, entry_at(new.entries, whole)))) == present
        except TriboError:  # the entry cannot change without others
            is_same = False
        if not is_same:
            yield _differs(path, before or "none", after or "none")
