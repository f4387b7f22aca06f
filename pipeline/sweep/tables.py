"""Nested tables of entries, by paths such as ``pin.radius``, as a scene file has them."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from typing import Any

Entries = Mapping[str, Any]
FRICTION = "friction.coefficient"
CURVE = "friction.by_velocity"
_CONTENTS = {
    "disk.roughness.content": ("disk.roughness.", "window."),
    "loading.content": ("loading.file",),
}
"""Entries with the digest of a file's content, and the entries on which the content depends."""


def entry_at(tables: Any, path: str) -> Any:
    """Look up the entry at a path such as "pin.radius" in nested tables; None if it is missing."""
    entry = tables
    for key in path.split("."):
        entry = entry.get(key) if isinstance(entry, Mapping) else getattr(entry, key, None)
    return entry


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
        return {key: one for key, one in tables.items() if key != first}
    return {**tables, first: other}


def flat(tables: Entries, above: str = "") -> Iterator[tuple[str, Any]]:
    """Yield pairs (path, value) of nested tables; an empty table counts as a value."""
    for key, inner in tables.items():
        path = f"{above}.{key}" if above else key
        if isinstance(inner, dict) and inner:
            yield from flat(inner, path)
        else:
            yield path, inner


def changes(before: Any, after: Any, place: str = "") -> Iterator[tuple[str, Any]]:
    """Yield paths at which nested tables differ, each with its value in `after`, or None.

    Paths begin with `place`. A table that has keys with a dot counts as one value.
    """
    for key in {**before, **after}:
        one, other = before.get(key), after.get(key)
        path, tables = f"{place}.{key}" if place else key, {type(one), type(other)}
        are_tables = dict in tables and tables <= {dict, type(None)}
        if are_tables and not any("." in inner for inner in {**(one or {}), **(other or {})}):
            yield from changes(one or {}, other or {}, path)
        elif one != other:
            yield path, other


def replace_values(tables: Entries, values: Entries) -> dict[str, Any]:
    """Return tables with the entries at several paths replaced by `values`.

    If the coefficient of friction is replaced, the coefficients in the table
    ``friction.by_velocity`` change in proportion, unless it is itself in `values`. The digest of
    a file's content is removed if an entry on which the content depends is replaced.
    """
    values = dict(values)
    old, new = entry_at(tables, FRICTION), values.get(FRICTION)
    are_numbers = isinstance(old, int | float) and old and isinstance(new, int | float)
    if are_numbers and CURVE not in values and (curve := entry_at(tables, CURVE)):
        values[CURVE] = [row | {"coefficient": row["coefficient"] * (new / old)} for row in curve]
    changed = dict(tables)
    for content, names in _CONTENTS.items():
        if content not in values and any(path.startswith(names) for path in values):
            changed = replace_value(changed, content, None)
    for path, value in values.items():
        changed = replace_value(changed, path, value)
    return changed
