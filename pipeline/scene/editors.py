"""The format of scene files as a JSON schema, by which editors complete, explain and check them.

A schema sees one file, and not what the scene that it extends or the library adds to it: so it
asks for no entry, and `pipeline.load_scene` alone says what is missing.
"""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

from pipeline.scene.faults import write_new
from pipeline.scene.format import SCENE
from pipeline.scene.kinds import (
    Flag,
    Kind,
    Number,
    OneOf,
    Quantity,
    Scalar,
    Share,
    UnitText,
    Whole,
)
from pipeline.scene.schema import ByPath, Distribution, Either, Entry, List, Range, Table, Tables
from tribo import InputError

_QUANTITY = r"^\s*[+-]?(\d+\.?\d*|\.\d+)([eE][+-]?\d{1,3})?(\s+\S|[^\d.,\s])"
"""A number that something follows: whether that is a unit is not for a schema to know."""

_BOUNDS = {
    "above": "exclusiveMinimum",
    "at_least": "minimum",
    "below": "exclusiveMaximum",
    "at_most": "maximum",
}


def write_schema(path: str | Path) -> Path:
    """Write the JSON schema of scene files to a new file, which must be called ``.json``.

    Examples
    --------
    >>> import tempfile
    >>> write_schema(Path(tempfile.mkdtemp(), "scene.schema.json")).name
    'scene.schema.json'
    """
    path = Path(path)
    if path.suffix != ".json":
        raise InputError(f"{path}: a schema is a JSON file; give a name such as scene.schema.json")
    write_new(path, json.dumps(schema(), indent=2, ensure_ascii=False) + "\n")
    return path


def schema() -> dict[str, Any]:
    """The schema of a scene file, as plain data.

    Examples
    --------
    >>> schema()["properties"]["sweep"]["properties"]["loads"]["anyOf"][0]["items"]["examples"]
    ['200 N']
    """
    scene = _entry(SCENE)
    entries = scene["properties"]
    about = {"description": entries["oil"].pop("description")}
    # Or a name of the library in its place.
    entries["oil"] = {"anyOf": [entries["oil"], {"type": "string"}]} | about
    heads = {"$schema": "http://json-schema.org/draft-07/schema#", "title": "Scene of irg"}
    return heads | scene


def _table(*forms: Table) -> dict[str, Any]:
    """A table with the keys of all its forms."""
    keys = {key: entry for table in forms for key, entry in table.keys.items()}
    return {
        "type": "object",
        "properties": {key: _entry(entry) for key, entry in keys.items()},
        "additionalProperties": False,
    }


def _entry(entry: Entry) -> dict[str, Any]:
    """Values that an entry allows, and its meaning."""
    return _allowed(entry.kind) | ({"description": entry.meaning} if entry.meaning else {})


def _allowed(kind: Kind) -> dict[str, Any]:
    match kind:
        case Table():
            return _table(kind)
        case Either(Table() as usual, Table() as other):
            return _table(usual, other)
        case Either():
            return {"anyOf": [_allowed(kind.usual), _allowed(kind.other)]}
        case Tables():
            return {"type": "object", "additionalProperties": _table(kind.of)}
        case List():
            size = {"minItems": kind.length, "maxItems": kind.length} if kind.length else {}
            return {
                "type": "array",
                "items": _allowed(kind.of),
                "minItems": 1,
                "uniqueItems": kind.distinct,
            } | size
        case Range():
            return _table(kind.ends) | {"required": kind.ends.needed}
        case ByPath(Distribution() as of):
            forms = [_table(table) | {"required": table.needed} for table in of.forms]
            deeper = {"$ref": "#/properties/unknown"}  # a path in tables in tables
            one = {"anyOf": [*forms, _allowed(of.listed), deeper]}
            return {"type": "object", "additionalProperties": one}
        case ByPath():
            return {"type": "object", "additionalProperties": {"type": ["number", "object"]}}
        case Scalar():
            return {"type": ["number", "string"]}
        case OneOf():
            return {"enum": list(kind.options)}
        case Flag():
            return {"type": "boolean"}
        case Quantity():
            return {"type": "string", "pattern": _QUANTITY, "examples": [kind.example]}
        case UnitText():
            return {"type": "string", "examples": [kind.example]}
        case Share():
            return {"anyOf": [_allowed(Number(**kind.bounds)), {"type": "string", "pattern": "%"}]}
        case Number():
            bounds = {_BOUNDS[name]: bound for name, bound in kind.bounds.items()}
            return {"type": "integer" if isinstance(kind, Whole) else "number"} | bounds
    return {"type": "string", "minLength": 1}
