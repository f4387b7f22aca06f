"""The library of materials and oils: values that a scene takes by name, and their sources.

A scene's own entries override those of the library.
"""

from __future__ import annotations

import functools
import tomllib
from importlib import resources
from typing import Any

from pipeline.faults import Faults
from pipeline.messages import key_path, quoted
from pipeline.scene.entries import entry_at
from pipeline.sweep.notes import FromLibrary

Entries = dict[str, Any]


@functools.cache
def library() -> dict[str, Any]:
    """Read the library of materials and oils, as a dictionary of three tables.

    ``materials`` and ``oils`` have a table for each name, with a list of value, key of its source
    and, if the source has it, standard deviation for each entry. ``sources`` has the reference for
    each such key.
    """
    file = resources.files("pipeline.scene").joinpath("library.toml")
    tables = tomllib.loads(file.read_text(encoding="utf-8"))
    materials = tables["materials"]
    materials |= {synonym: materials[name] for synonym, name in tables.pop("names").items()}
    return tables


def resolve_library(entries: Entries, faults: Faults) -> tuple[Entries, tuple[FromLibrary, ...]]:
    """Add values of the library to a scene's entries; return the entries, and the added values."""
    added_values: list[FromLibrary] = []
    entries, tables = dict(entries), entries.get("materials", {})
    if isinstance(oil := entries.get("oil"), str):
        entries["oil"] = _completed({}, oil, "oils", "oil", added_values, faults)
    if not isinstance(tables, dict):
        return entries, tuple(added_values)
    for body in ("pin", "disk"):
        name = entry_at(entries, f"{body}.material")
        if isinstance(name, str) and name in library()["materials"] and name not in tables:
            tables = {name: dict[str, Any](), **tables}
    materials = {}
    for name, table in tables.items():
        materials[name], like = table, None
        if isinstance(table, dict):
            like = table.get("like", None if table else name)
        if like and isinstance(like, str):
            path = key_path("materials", name)
            materials[name] = _completed(table, like, "materials", path, added_values, faults)
    return entries | ({"materials": materials} if materials else {}), tuple(added_values)


def _completed(
    table: Entries, name: str, kind: str, path: str, added_values: list[FromLibrary], faults: Faults
) -> Entries:
    """The table at `path`, completed by entries of the library's `name`."""
    tables, sources = library()[kind], library()["sources"]
    if name not in tables:
        names = ", ".join(map(quoted, tables))
        problem = f"{quoted(name)} is not in the library; available {kind}: {names}"
        faults.refuse(f"{path}.like" if table else path, problem)
        return table
    added = {key: entry for key, entry in tables[name].items() if key not in table}
    for key, (value, source, *deviation) in added.items():
        text = " and ".join(value) if isinstance(value, list) else str(value)
        text = f"{text} (± {deviation[0]})" if deviation else text
        added_values.append(FromLibrary(f"{path}.{key}", text, sources[source]))
    return {key: value for key, (value, *_) in added.items()} | table
