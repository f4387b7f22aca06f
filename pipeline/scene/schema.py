"""A JSON Schema of scene files, by which editors complete, explain and check entries.

It follows from the declaration of the format. Limits of quantities, which are text with a unit,
stand in the description of their entries: a schema cannot compare them.
"""

from __future__ import annotations

import math
from typing import Any

from pipeline.quantities import DIMENSIONS
from pipeline.scene.declare import (
    ByPath,
    Changes,
    Either,
    Entry,
    List,
    Range,
    Table,
    Tables,
    table_of,
)
from pipeline.scene.format import SceneFile
from pipeline.scene.kinds import Flag, Kind, Number, OneOf, Quantity, Scalar, Share, Text, Whole
from pipeline.scene.reference import example, forms_of, plain_text
from pipeline.scene.units import si_unit
from pipeline.scene.written import entries_of

_WITH_UNIT = r"[0-9].*[^-+0-9.,eE\s]"
_BOUNDS = {
    "above": "exclusiveMinimum",
    "at_least": "minimum",
    "below": "exclusiveMaximum",
    "at_most": "maximum",
}

Schema = dict[str, Any]


def scene_schema() -> dict[str, Any]:
    """JSON Schema (draft 7) of scene files, as a dictionary to write as JSON.

    Examples
    --------
    >>> from pipeline.scene.schema import scene_schema
    >>> radius = scene_schema()["properties"]["pin"]["properties"]["radius"]
    >>> radius["type"], radius["description"].rpartition("; ")[2]
    ('string', 'usually 0.1 to 1000 mm.')
    """
    top = table_of(SceneFile)
    whole = _schema_of(top)
    whole["properties"]["oil"] = {"anyOf": [{"type": "string"}, whole["properties"]["oil"]]}
    return {
        "$schema": "http://json-schema.org/draft-07/schema#",
        "title": "A scene of irg",
        **whole,
        # A scene that extends another needs no entry of its own.
        "if": {"required": ["extends"]},
        "else": _needs(top),
    }


def _schema_of(kind: Kind, is_whole: bool = False) -> Schema:
    """Schema of the values that a kind allows; `is_whole` if no other scene can complete them."""
    match kind:
        case Table():
            named = {key: _entry(entry, is_whole) for key, entry in kind.listed.items()}
            needed = {"required": kind.needed} if is_whole and kind.needed else {}
            return {
                "type": "object",
                "properties": named,
                "additionalProperties": False,
                **needed,
            }
        case Tables(of):
            return {"type": "object", "additionalProperties": _schema_of(of, is_whole)}
        case List(of):
            length = {"minItems": kind.length or 1}
            length |= {"maxItems": kind.length} if kind.length else {}
            return {"type": "array", "items": _schema_of(of, is_whole=True), **length}
        case Range(of):
            ends = dict.fromkeys(("from", "to", "step"), _schema_of(of))
            ends["count"] = {"type": "integer", "minimum": 2}
            return {"type": "object", "properties": ends, "additionalProperties": False}
        case Either():
            return {"anyOf": [_schema_of(one, is_whole) for one in kind.kinds]}
        case ByPath() | Changes():
            return {"type": "object"}
    return _single(kind)


def _single(kind: Kind) -> Schema:
    """Schema of a kind of single value."""
    match kind:
        case Quantity():
            return {"type": "string", "pattern": _WITH_UNIT}
        case OneOf():
            return {"enum": [*kind.options]}
        case Flag():
            return {"type": "boolean"}
        case Share():
            return {"anyOf": [_number(kind, "number"), {"type": "string", "pattern": "%"}]}
        case Number():
            return _number(kind, "integer" if isinstance(kind, Whole) else "number")
        case Scalar():
            return {"type": ["number", "string"]}
    return {"type": "string", "minLength": 1}


def _number(kind: Number, type_name: str) -> Schema:
    bounds = ((word, getattr(kind, name)) for name, word in _BOUNDS.items())
    return {"type": type_name, **{word: end for word, end in bounds if math.isfinite(end)}}


def _entry(entry: Entry, is_whole: bool) -> Schema:
    """Schema of an entry, with its meaning, example and default."""
    schema = _schema_of(entry.kind, is_whole)
    schema["description"] = plain_text(entry.meaning)
    if forms_of(entry.kind):
        return schema
    schema["description"] += f" Give {entry.kind}{_limits(entry.kind)}."
    default = entries_of(entry.kind, entry.default)
    if default is not None:
        return schema | {"default": default}
    return schema if isinstance(entry.kind, Text) else schema | {"examples": [example(entry, None)]}


def _limits(kind: Kind) -> str:
    """Words on the range that a number may have, and the usual one; empty for other kinds."""
    texts = []
    if isinstance(kind, Quantity):
        low, high = kind.ends or DIMENSIONS[si_unit(kind.example)].limits
        texts.append(f"from {low} to {high}")
    if usual := getattr(kind, "usual", None):
        texts.append(f"usually {usual[0]:g} to {usual[1]:g} {getattr(kind, 'unit', '')}".rstrip())
    return "".join(f"; {text}" for text in texts)


def _needs(kind: Kind) -> Schema:
    """Schema that demands the entries that a whole scene must have, and nothing else."""
    match kind:
        case Table():
            inner = {key: _needs(entry.kind) for key, entry in kind.listed.items()}
            inner = {key: one for key, one in inner.items() if one}
            return {
                **({"required": kind.needed} if kind.needed else {}),
                **({"properties": inner} if inner else {}),
            }
        case Either() if forms := forms_of(kind):
            return {"anyOf": [_needs(form) for form in forms]}
    return {}
