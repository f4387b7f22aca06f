"""The library of materials and oils: what a scene takes from it by name, and from which source.

A scene's own entries override those of the library.
"""

from __future__ import annotations

import functools
import tomllib
from importlib import resources
from typing import Any

from pipeline.scene.entries import entry_at
from pipeline.scene.faults import Faults
from pipeline.scene.format import MaterialTable
from pipeline.scene.tables import table_of
from pipeline.sweep.notes import FromLibrary
from pipeline.words import key_path, quoted

Entries = dict[str, Any]


@functools.cache
def library() -> dict[str, Any]:
    """Read the library of materials and oils, as a dictionary of three tables.

    ``materials`` and ``oils`` have a table for each name, with a pair (value, key of its source)
    for each entry. ``sources`` has the reference for each such key.
    """
    file = resources.files("pipeline.scene").joinpath("library.toml")
    tables = tomllib.loads(file.read_text(encoding="utf-8"))
    materials = tables["materials"]
    materials |= {name: materials[usual] for name, usual in tables.pop("names").items()}
    return tables


def resolve_library(entries: Entries, faults: Faults) -> tuple[Entries, tuple[FromLibrary, ...]]:
    """Add values of the library to a scene's entries; return the entries, and the added values."""
    taken: list[FromLibrary] = []
    entries = dict(entries)
    if isinstance(oil := entries.get("oil"), str):
        entries["oil"] = _added(oil, "oils", "oil", "oil", {}, taken, faults)
    tables = entries.get("materials", {})
    if not isinstance(tables, dict):
        return entries, tuple(taken)
    for body in ("pin", "disk"):
        name = entry_at(entries, f"{body}.material")
        if isinstance(name, str) and name in library()["materials"] and name not in tables:
            tables = {name: dict[str, Any](), **tables}
    if tables:
        entries["materials"] = {
            name: _filled(table, name, taken, faults) for name, table in tables.items()
        }
    return entries, tuple(taken)


def _filled(table: Any, name: str, taken: list[FromLibrary], faults: Faults) -> Any:
    """The table of a material with the entries that it lacks, from the library."""
    if not isinstance(table, dict):
        return table
    # Without `like`, an incomplete table takes the material of its own name.
    is_whole = table.keys() >= {*table_of(MaterialTable).needed}
    usual = name if name in library()["materials"] and not is_whole else None
    like, place = table.get("like", usual), key_path("materials", name)
    if not isinstance(like, str) or not like:
        return table
    return _added(like, "materials", place, f"{place}.like", table, taken, faults)


def _added(
    name: str, kind: str, place: str, entry: str, table: Entries, taken: list[FromLibrary],
    faults: Faults,
) -> Entries:  # fmt: skip
    """The table at `place` with what the library has of `name`, which `entry` gives."""
    known = library()[kind]
    if name not in known:
        problem = f"{quoted(name)} is not in the library; available {kind}: "
        faults.refuse(entry, problem + ", ".join(map(quoted, known)))
        name = next(iter(known))  # so that nothing else seems to be missing
    added = {}
    for key, (value, source) in known[name].items():
        if key not in table:
            added[key] = value
            text = " and ".join(value) if isinstance(value, list) else str(value)
            taken.append(FromLibrary(f"{place}.{key}", text, library()["sources"][source]))
    return added | table
