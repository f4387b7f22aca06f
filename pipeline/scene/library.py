"""The library of materials and oils: values that a scene takes by name, and their sources.

A scene's own entries override those of the library.
"""

from __future__ import annotations

import functools
import tomllib
from importlib import resources
from typing import Any

from pipeline.messages import key_path, quoted
from pipeline.scene.declared_tables import table_of
from pipeline.scene.entries import entry_at
from pipeline.scene.faults import Faults
from pipeline.scene.format import MaterialTable
from pipeline.sweep.notes import FromLibrary

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
    materials |= {synonym: materials[name] for synonym, name in tables.pop("names").items()}
    return tables


def resolve_library(entries: Entries, faults: Faults) -> tuple[Entries, tuple[FromLibrary, ...]]:
    """Add values of the library to a scene's entries; return the entries, and the added values."""
    library_values: list[FromLibrary] = []
    entries = dict(entries)
    if isinstance(oil := entries.get("oil"), str):
        entries["oil"] = _completed(oil, "oils", "oil", "oil", {}, library_values, faults)
    tables = entries.get("materials", {})
    if not isinstance(tables, dict):
        return entries, tuple(library_values)
    for body in ("pin", "disk"):
        name = entry_at(entries, f"{body}.material")
        if isinstance(name, str) and name in library()["materials"] and name not in tables:
            tables = {name: dict[str, Any](), **tables}
    if tables:
        entries["materials"] = {
            name: _completed_material(table, name, library_values, faults)
            for name, table in tables.items()
        }
    return entries, tuple(library_values)


def _completed_material(
    table: Any, name: str, library_values: list[FromLibrary], faults: Faults
) -> Any:
    """The table of a material with the entries that it lacks, from the library."""
    if not isinstance(table, dict):
        return table
    # Without `like`, an incomplete table is completed by the material of the same name.
    is_complete = table.keys() >= {*table_of(MaterialTable).needed}
    same_name = name if name in library()["materials"] and not is_complete else None
    like, path = table.get("like", same_name), key_path("materials", name)
    if not isinstance(like, str) or not like:
        return table
    return _completed(like, "materials", path, f"{path}.like", table, library_values, faults)


def _completed(
    name: str, kind: str, path: str, entry: str, table: Entries, library_values: list[FromLibrary],
    faults: Faults,
) -> Entries:  # fmt: skip
    """The table at `path`, completed by the library's `name`, which stands in `entry`."""
    library_tables = library()[kind]
    if name not in library_tables:
        names = ", ".join(map(quoted, library_tables))
        faults.refuse(entry, f"{quoted(name)} is not in the library; available {kind}: {names}")
        name = next(iter(library_tables))  # so that its entries do not count as missing
    added_values = {}
    for key, (value, source) in library_tables[name].items():
        if key not in table:
            added_values[key] = value
            text = " and ".join(value) if isinstance(value, list) else str(value)
            library_values.append(FromLibrary(f"{path}.{key}", text, library()["sources"][source]))
    return added_values | table
