"""Nested tables of entries, by paths such as ``pin.radius``, as a scene file has them."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from typing import Any

from pipeline.limits import MOST_LEVELS

Entries = Mapping[str, Any]
_REPLACED = {"count": "step", "step": "count"}
"""Keys of a range that replace each other in a scene that extends another."""


def entry_at(tables: Any, path: str) -> Any:
    """Look up the entry at a path such as "pin.radius" in nested tables; None if it is missing."""
    entry = tables
    for key in path.split("."):
        entry = entry.get(key) if isinstance(entry, Mapping) else getattr(entry, key, None)
    return entry


def find_deep(tables: Any, level: int = 0) -> str:
    """Key below which tables or lists are nested more than `MOST_LEVELS` deep; else empty."""
    inner = tables.items() if isinstance(tables, dict) else enumerate(tables)
    for key, value in inner:
        depth = level + 1 + (key.count(".") if isinstance(key, str) else 0)
        if depth > MOST_LEVELS:
            return f"{key}"[:80]
        if isinstance(value, dict | list) and (deep := find_deep(value, depth)):
            return deep if level else f"{key}"[:80]
    return ""


def flat(tables: Entries, above: str = "") -> Iterator[tuple[str, Any]]:
    """Yield pairs (path, value) of nested tables; an empty table counts as a value."""
    for key, inner in tables.items():
        path = f"{above}.{key}" if above else key
        if isinstance(inner, dict) and inner:
            yield from flat(inner, path)
        else:
            yield path, inner


def merged(lower: Entries, upper: Entries) -> dict[str, Any]:
    """Merge tables key by key; values of `upper` replace values of `lower`."""
    replaced = {_REPLACED.get(key) for key in upper}
    tables = {key: value for key, value in lower.items() if key not in replaced}
    for key, value in upper.items():
        are_tables = isinstance(value, dict) and isinstance(lower.get(key), dict)
        tables[key] = merged(lower[key], value) if are_tables else value
    return tables


def replace_value(tables: Entries, path: str, value: Any) -> dict[str, Any]:
    """Return tables with the entry at a path set to a value, or removed if the value is None.

    A table from which the last entry is removed is removed, too.
    """
    first, _, rest = path.partition(".")
    if value is None and first not in tables:
        return dict(tables)
    inner = tables.get(first)
    table = inner if isinstance(inner, dict) else {}
    other = replace_value(table, rest, value) if rest else value
    if other is None or (value is None and not other):  # an empty table goes, too
        return {key: entry for key, entry in tables.items() if key != first}
    return {**tables, first: other}


def replace_values(tables: Entries, values: Entries) -> dict[str, Any]:
    """Return tables with the entries at several paths replaced by `values`.

    A new preset replaces all other choices.
    """
    changed = dict(tables)
    if "fidelity.preset" in values:
        changed.pop("fidelity", None)
    for path, value in values.items():
        changed = replace_value(changed, path, value)
    return changed
