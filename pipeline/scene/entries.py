"""Nested tables of entries, by paths such as ``pin.radius``, as a scene file has them."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from typing import Any

_ALTERNATIVES = {
    "count": "step",
    "step": "count",
    "correlation_length": "rsm",
    "rsm": "correlation_length",
}
"""Entries of a table that replace each other."""
Entries = Mapping[str, Any]
"""Values and further tables by key; or values by path."""


def entry_at(tables: Any, path: str) -> Any:
    """Look up the entry at a path such as "pin.radius" in nested tables; None if it is missing."""
    entry = tables
    for key in path.split("."):
        entry = entry.get(key) if isinstance(entry, Mapping) else getattr(entry, key, None)
    return entry


def are_nested(first: str, second: str) -> bool:
    """True if two paths of entries are equal, or one is within the other."""
    first, second = f"{first}.", f"{second}."
    return first.startswith(second) or second.startswith(first)


def flat(tables: Entries, table_path: str = "") -> Iterator[tuple[str, Any]]:
    """Yield pairs (path, value) of nested tables; an empty table counts as a value."""
    for key, value in tables.items():
        path = f"{table_path}.{key}" if table_path else key
        if isinstance(value, dict) and value:
            yield from flat(value, path)
        else:
            yield path, value


def merged(lower: Entries, upper: Entries) -> dict[str, Any]:
    """Merge tables key by key; values of `upper` replace values of `lower`.

    Alternatives, such as the step and the count of a range, replace each other.
    """
    replaced_keys = {_ALTERNATIVES.get(key) for key in upper}
    tables = {key: value for key, value in lower.items() if key not in replaced_keys}
    for key, value in upper.items():
        are_tables = isinstance(value, dict) and isinstance(lower.get(key), dict)
        tables[key] = merged(lower[key], value) if are_tables else value
    return tables


def replace_value(tables: Entries, path: str, value: Any) -> dict[str, Any]:
    """Return tables with the entry at a path set to a value, or removed if the value is None.

    An alternative of the entry is removed as well, and a table that becomes empty.
    """
    key, _, inner_path = path.partition(".")
    if value is None and key not in tables:
        return dict(tables)
    new_value = value
    if inner_path:
        table = tables.get(key)
        new_value = replace_value(table if isinstance(table, dict) else {}, inner_path, value)
    if new_value is None or (value is None and not new_value):
        return {other_key: entry for other_key, entry in tables.items() if other_key != key}
    alternative = _ALTERNATIVES.get(key)
    return {name: entry for name, entry in tables.items() if name != alternative} | {key: new_value}


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
