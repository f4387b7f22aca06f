"""The library of materials and oils: what a scene takes from it by name, and from which source.

A scene's own entries override those of the library; viscosities and their temperatures are taken
together.
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
from pipeline.sweep.remarks import FromLibrary
from pipeline.words import key_path, quoted

Entries = dict[str, Any]
_VISCOSITY = ("temperatures", "kinematic_viscosity", "dynamic_viscosity")
"""Entries of the viscosity: if a scene gives one, the library adds none of them."""


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
    if (oil := entries.get("oil")) is not None:
        table = {"like": oil} if isinstance(oil, str) else oil
        entries["oil"] = _filled(table, None, "oils", "oil", taken, faults)
    tables = entries.get("materials", {})
    if not isinstance(tables, dict):
        return entries, tuple(taken)
    for body in ("pin", "disk"):
        name = entry_at(entries, f"{body}.material")
        if isinstance(name, str) and name in library()["materials"] and name not in tables:
            tables = {name: dict[str, Any](), **tables}
    if tables:
        entries["materials"] = {
            name: _filled(table, name, "materials", key_path("materials", name), taken, faults)
            for name, table in tables.items()
        }
    return entries, tuple(taken)


def _filled(
    table: Any, name: str | None, kind: str, place: str, taken: list[FromLibrary], faults: Faults
) -> Any:
    """Table with the entries that it lacks, from the library; they are added to `taken`, too."""
    known = library()[kind]
    if not isinstance(table, dict):
        return table
    # Without `like`, an incomplete table takes the material of its own name.
    is_whole = table.keys() >= {*table_of(MaterialTable).needed}
    like = table.get("like", name if name in known and not is_whole else None)
    if not isinstance(like, str) or not like:
        return table
    if like not in known:
        problem = f"{quoted(like)} is not in the library; its {kind}: "
        faults.refuse(f"{place}.like", problem + ", ".join(map(quoted, known)))
        like = next(iter(known))  # so that nothing else seems to be missing
    has_viscosity = any(key in table for key in _VISCOSITY)
    added = {}
    for key, (value, source) in known[like].items():
        if key not in table and not (has_viscosity and isinstance(value, list)):
            added[key] = value
            text = " and ".join(value) if isinstance(value, list) else str(value)
            taken.append(FromLibrary(f"{place}.{key}", text, library()["sources"][source]))
    return added | table
