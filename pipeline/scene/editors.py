"""The format of scene files as a JSON schema, by which editors complete, explain and check them.

A schema sees one file, and not what the scene that it extends or the library adds to it: so it
asks for no entry, and `pipeline.load_scene` alone says what is missing.
"""

from __future__ import annotations

import json
import math
from pathlib import Path
from typing import Any

from pipeline.scene.faults import unwritable
from pipeline.scene.format import FORMAT
from pipeline.scene.kinds import Choice, Flag, Kind, Number, Quantity, Unit, Whole
from pipeline.scene.meanings import MEANINGS, TABLES
from pipeline.scene.reference import kind_of
from pipeline.scene.schema import ByPath, Distributions, Either, List, Range, Scalar, Table, Tables
from tribo import InputError

_QUANTITY = r"^\s*[+-]?(\d+\.?\d*|\.\d+)([eE][+-]?\d{1,3})?(\s+\S|[^\d.,\s])"
"""A number that something follows: whether that is a unit is not for a schema to know."""

_SHORT = {"oil": {"type": "string"}}
"""Tables that a name of the library may stand in place of."""


def write_schema(path: str | Path) -> Path:
    """Write the JSON schema of scene files, for an editor.

    Parameters
    ----------
    path : path
        File to write; it must not exist yet.

    Raises
    ------
    InputError
        If the file exists, cannot be written, or is not called ``.json``.

    Examples
    --------
    >>> import tempfile
    >>> write_schema(Path(tempfile.mkdtemp(), "scene.schema.json")).name
    'scene.schema.json'
    """
    path = Path(path)
    if path.suffix != ".json":
        raise InputError(f"{path}: a schema is a JSON file; give a name such as scene.schema.json")
    try:
        with path.open("x", encoding="utf-8") as file:
            file.write(json.dumps(schema(), indent=2, ensure_ascii=False) + "\n")
    except FileExistsError as error:
        raise InputError(f"{path} exists already; give another name, or remove it") from error
    except OSError as error:
        raise unwritable(path, error) from error
    return path


def schema() -> dict[str, Any]:
    """The schema of a scene file, as plain data.

    Examples
    --------
    >>> schema()["properties"]["sweep"]["properties"]["loads"]["anyOf"][0]["items"]["examples"]
    ['200 N']
    """
    return {
        "$schema": "http://json-schema.org/draft-07/schema#",
        "title": "Scene of irg",
        **_of(FORMAT, ""),
    }


def _of(kind: Kind, path: str) -> dict[str, Any]:
    """Values that a kind allows at a path, and their meaning there."""
    if isinstance(kind, Tables):
        path += ".NAME"
    about = MEANINGS.get(path) or TABLES.get(path)
    rule = _allowed(kind, path)
    if short := _SHORT.get(path):
        rule = {"anyOf": [rule, short]}
    return rule | ({"description": about} if about else {})


def _allowed(kind: Kind, path: str) -> dict[str, Any]:
    match kind:
        case Table():
            return _object(path, kind)
        case Either(Table() as usual, Table() as other):
            return _object(path, usual, other)
        case Either():
            return {"anyOf": [_allowed(kind.usual, path), _allowed(kind.other, path)]}
        case Tables():
            return {"type": "object", "additionalProperties": _object(path, kind.of)}
        case List():
            size = {"minItems": kind.length, "maxItems": kind.length} if kind.length else {}
            return {
                "type": "array",
                "items": _allowed(kind.of, path),
                "minItems": 1,
                "uniqueItems": kind.distinct,
            } | size
        case Range():
            ends = dict.fromkeys(("from", "to", "step"), kind.of)
            return _object(path, Table(ends)) | {"required": list(ends)}
        case Distributions():
            forms = [_object(path, table) | {"required": table.needed} for table in kind.of]
            deeper = {"$ref": "#/properties/unknown"}  # a path in tables in tables
            one = {"anyOf": [*forms, _allowed(kind.listed, path), deeper]}
            return {"type": "object", "additionalProperties": one}
        case ByPath():
            return {"type": "object", "additionalProperties": {"type": ["number", "object"]}}
        case Scalar():
            return {"type": ["number", "string"]}
        case Choice():
            return {"enum": list(kind.options)}
        case Flag():
            return {"type": "boolean"}
        case Quantity():
            return {"type": "string", "pattern": _QUANTITY, "examples": [kind.example]}
        case Unit():
            return {"type": "string", "examples": [kind.example]}
        case Number():
            return {"type": "integer" if isinstance(kind, Whole) else "number"} | _limits(kind)
    return {"type": "string", "minLength": 1}


def _object(path: str, *forms: Table) -> dict[str, Any]:
    """A table with the keys of all its forms."""
    keys = {key: entry for table in forms for key, entry in table.keys.items()}
    return {
        "type": "object",
        "properties": {
            key: _of(kind_of(entry), f"{path}.{key}" if path else key)
            for key, entry in keys.items()
        },
        "additionalProperties": False,
    }


def _limits(kind: Number) -> dict[str, float]:
    limits = {
        "exclusiveMinimum": kind.above,
        "minimum": kind.at_least,
        "exclusiveMaximum": kind.below,
        "maximum": kind.at_most,
    }
    return {word: limit for word, limit in limits.items() if math.isfinite(limit)}
