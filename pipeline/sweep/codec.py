"""Objects as plain data for JSON, and back: only dataclasses and named tuples of known classes.

What is stored or hashed omits fields that have their default. So a class may gain or lose a field
with a default, and stores of both versions remain readable, with equal hashes: a missing field has
its default, and a field that is unknown has a value that this version cannot take into account.
"""

from __future__ import annotations

import functools
import hashlib
import json
import math
from collections.abc import Iterator, Mapping
from dataclasses import MISSING, fields, is_dataclass
from typing import Any

import numpy as np

from tribo import InputError
from tribo.surface import array_digest
from tribo.types import Array

NOT_STORED = {"stored": False}
"""Metadata of a field that is not stored; decoded objects have its default."""
NOT_IDENTITY = {"identity": False}
"""Metadata of a field that is stored for people, but not part of what is hashed."""
_CLASS_KEY = "is"  # of the name of an object's class
_MISSING_SURFACE = "MissingSurface"  # class that takes the place of an array that was left out


class CodecError(InputError):
    """Plain data are not those of an object of this version."""


class ArrayError(InputError):
    """An array is not the one that plain data name."""


def encode(
    value: Any,
    arrays: dict[str, Array] | None = None,
    with_defaults: bool = False,
    only_identity: bool = False,
) -> Any:
    """Convert an object to plain data; its arrays go into `arrays`, by `array_digest`.

    Dataclasses and named tuples become dictionaries with the name of their class, tuples lists.
    Fields that have their default are omitted, unless `with_defaults` is True. Fields for people
    are omitted if `only_identity` is True.
    """

    def encode_part(part: Any) -> Any:
        return encode(part, arrays, with_defaults, only_identity)

    if isinstance(value, np.generic):
        value = value.item()
    if value is None or isinstance(value, bool | int | str):
        return value
    if isinstance(value, float):
        return value if math.isfinite(value) else {_CLASS_KEY: "number", "text": str(value)}
    if isinstance(value, np.ndarray):
        key = array_digest(value)
        if arrays is not None:
            arrays[key] = value
        return {_CLASS_KEY: "array", "digest": key, "shape": [*value.shape]}
    if isinstance(value, Mapping):
        items = [[key, encode_part(item)] for key, item in value.items()]
        return {_CLASS_KEY: "mapping", "items": items}
    cls: Any = type(value)
    if cls.__name__ == _MISSING_SURFACE:  # counts as the surface itself
        array = {_CLASS_KEY: "array", "digest": value.digest, "shape": [*value.shape]}
        return {_CLASS_KEY: "MeasuredRoughness", "array": array}
    if names := _stored_fields(cls, only_identity):
        values = {name: getattr(value, name) for name in names}
        if not with_defaults:
            defaults = _defaults(cls)
            values = {
                name: value
                for name, value in values.items()
                if name not in defaults or value != defaults[name]
            }
        plain = {name: encode_part(item) for name, item in values.items()}
        return {_CLASS_KEY: cls.__name__, **plain}
    return [*map(encode_part, value)]


def decode(plain: Any, classes: Mapping[str, type], arrays: Mapping[str, Array]) -> Any:
    """Build the object of plain data from `encode`.

    Only objects of `classes`, by name, are built. `arrays` has the arrays by SHA-256. Raises a
    `CodecError` if the data need a class or a field that this version lacks, or lack a field that
    it needs; an `ArrayError` if an array is another one than the data name.
    """
    # Written and read again, since the JSON reader builds inner objects first and does not recurse
    # in Python.
    build = functools.partial(_build_object, classes, arrays)
    return json.loads(json.dumps(plain), object_hook=build)


def _build_object(
    classes: Mapping[str, type], arrays: Mapping[str, Array], values: dict[str, Any]
) -> Any:
    """Build the object of a dictionary, whose values are built already."""
    name = values.pop(_CLASS_KEY, None)
    values = {key: _to_tuples(value) for key, value in values.items()}
    match name:
        case "number":
            return float(values["text"])
        case "mapping":
            return dict(values["items"])
        case "array" if values["digest"] in arrays:
            array = arrays[values["digest"]].reshape(values["shape"])
            if array_digest(array) != values["digest"]:
                raise ArrayError("an array has other numbers than were written")
            return array
        case "array":
            name = _MISSING_SURFACE
        case "MeasuredRoughness" if type(values["array"]).__name__ == _MISSING_SURFACE:
            return values["array"]
    if name not in classes:
        raise CodecError(f"this version has no class {name!r:.60}")
    stored_fields = {*_stored_fields(classes[name])}
    if unknown := values.keys() - stored_fields:
        raise CodecError(f"this version has no {name}.{min(unknown)}, which has a value there")
    if missing := stored_fields - values.keys() - _defaults(classes[name]).keys():
        raise CodecError(f"this version needs {name}.{min(missing)}, which is missing there")
    return classes[name](**values)


def _to_tuples(value: Any) -> Any:
    return tuple(map(_to_tuples, value)) if isinstance(value, list) else value


def digest(value: Any) -> str:
    """SHA-256 of an object's plain data without defaults; the numbers 2 and 2.0 are the same."""
    plain = json.dumps(encode(value, only_identity=True))
    text = json.dumps(json.loads(plain, parse_int=_float_if_equal))
    return hashlib.sha256(text.encode()).hexdigest()


def _float_if_equal(text: str) -> float | str:
    return float(text) if int(float(text)) == int(text) else text


def differences(first: Any, second: Any, path: str = "") -> Iterator[tuple[str, Any, Any]]:
    """Yield the paths at which plain data differ, with both values."""
    are_dicts = isinstance(first, dict) and isinstance(second, dict)
    is_divided = are_dicts and first.get(_CLASS_KEY) not in ("UserLaw", "UserSurface")
    if is_divided and first.keys() == second.keys():
        for key in first:
            yield from differences(first[key], second[key], f"{path}.{key}" if path else key)
    elif first != second:
        yield path.removesuffix(f".{_CLASS_KEY}"), first, second


def encode_difference(base: Any, plain: Any) -> Any:
    """Differences of an object's plain data from a `base`; all of them if its class is another."""
    if not (isinstance(base, dict) and isinstance(plain, dict) and base.keys() == plain.keys()):
        return plain
    if base[_CLASS_KEY] != plain[_CLASS_KEY]:
        return plain
    return {
        key: encode_difference(base[key], value)
        for key, value in plain.items()
        if value != base[key]
    }


def apply_difference(base: Any, difference: Any) -> Any:
    """Plain data of an object from a `base` and the `difference` from `encode_difference`."""
    if not (isinstance(base, dict) and isinstance(difference, dict)) or _CLASS_KEY in difference:
        return difference
    if unknown := difference.keys() - base.keys():
        raise CodecError(f"{base.get(_CLASS_KEY)} has no {min(unknown)}")
    return base | {key: apply_difference(base[key], value) for key, value in difference.items()}


@functools.cache
def _stored_fields(cls: Any, only_identity: bool = False) -> tuple[str, ...]:
    """Names of the stored fields of a class; empty if it has no fields."""
    if is_dataclass(cls):
        stored = [field for field in fields(cls) if field.metadata.get("stored", field.init)]
        if only_identity:
            stored = [field for field in stored if field.metadata.get("identity", True)]
        return tuple(field.name for field in stored)
    return tuple(getattr(cls, "_fields", ()))


@functools.cache
def _defaults(cls: Any) -> dict[str, Any]:
    """Defaults of the fields of a class that have one, by name.

    A changed default changes what stores mean, and needs a new `pipeline.store.schema.FORMAT`.
    """
    if not is_dataclass(cls):
        return dict(getattr(cls, "_field_defaults", {}))
    defaults = dict[str, Any]()
    for field in fields(cls):
        if field.default is not MISSING:
            defaults[field.name] = field.default
        elif field.default_factory is not MISSING:
            defaults[field.name] = field.default_factory()
    return defaults
