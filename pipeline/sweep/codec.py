"""Objects as plain data for JSON, and back: dataclasses and named tuples of known classes alone."""

from __future__ import annotations

import functools
import hashlib
import json
import math
from collections.abc import Iterator, Mapping
from dataclasses import fields, is_dataclass
from typing import Any

import numpy as np

from tribo import InputError
from tribo.surface import UnknownHeights, array_digest
from tribo.types import Array

NOT_STORED = {"stored": False}
"""Metadata of a field that plain data lack; decoded objects have its default."""
_CLASS = "is"  # key with the name of an object's class


class CodecError(InputError):
    """Plain data are not those of an object."""


def encode(value: Any, arrays: dict[str, Array] | None = None) -> Any:
    """Convert an object to plain data; its arrays go into `arrays`, by SHA-256.

    Dataclasses and named tuples become dictionaries with the name of their class, tuples lists.
    """
    if isinstance(value, np.generic):
        value = value.item()
    if value is None or isinstance(value, bool | int | str):
        return value
    if isinstance(value, float):
        return value if math.isfinite(value) else {_CLASS: "number", "text": str(value)}
    if isinstance(value, np.ndarray):
        key = array_digest(value)
        if arrays is not None:
            arrays[key] = value
        return {_CLASS: "array", "digest": key, "shape": [*value.shape]}
    if isinstance(value, Mapping):
        return {_CLASS: "mapping", "items": [[k, encode(v, arrays)] for k, v in value.items()]}
    if isinstance(value, UnknownHeights):  # counts as the surface itself
        array = {_CLASS: "array", "digest": value.digest, "shape": [*value.shape]}
        return {_CLASS: "MeasuredRoughness", "array": array}
    made: Any = type(value)
    if names := _fields(made):
        own = {name: encode(getattr(value, name), arrays) for name in names}
        return {_CLASS: made.__name__, **own}
    return [encode(one, arrays) for one in value]


def decode(plain: Any, classes: Mapping[str, type], arrays: Mapping[str, Array]) -> Any:
    """Make the object of plain data from `encode`; `CodecError` for any other data.

    Only objects of `classes`, by name, are made. `arrays` has the arrays by SHA-256.
    """

    def made(own: dict[str, Any]) -> Any:
        name = own.pop(_CLASS, None)
        own = {key: _tuples(one) for key, one in own.items()}
        match name:
            case "number":
                return float(own["text"])
            case "mapping":
                return dict(own["items"])
            case "array" if own["digest"] in arrays:
                array = arrays[own["digest"]].reshape(own["shape"])
                if array_digest(array) != own["digest"]:
                    raise CodecError("an array is not what was written: its numbers are others")
                return array
            case "array":
                name = "MissingSurface"
            case "MeasuredRoughness" if isinstance(own["array"], UnknownHeights):
                return own["array"]
        if name not in classes:
            raise CodecError(f"there is no class {name!r:.60}")
        if other := own.keys() ^ {*_fields(classes[name])}:
            raise CodecError(f"{name}.{min(other)} is missing, or unknown")
        return classes[name](**own)

    # Written and read once more: the reader of JSON makes inner objects first, without a frame for
    # each level.
    return json.loads(json.dumps(plain), object_hook=made)


def _tuples(value: Any) -> Any:
    return tuple(map(_tuples, value)) if isinstance(value, list) else value


def digest(value: Any) -> str:
    """SHA-256 of an object's plain data; the numbers 2 and 2.0 are the same."""
    text = json.dumps(json.loads(json.dumps(encode(value)), parse_int=_float_if_equal))
    return hashlib.sha256(text.encode()).hexdigest()


def _float_if_equal(text: str) -> float | str:
    return float(text) if int(float(text)) == int(text) else text


def differences(one: Any, other: Any, place: str = "") -> Iterator[tuple[str, Any, Any]]:
    """Yield the paths at which plain data differ, with both values."""
    if isinstance(one, dict) and isinstance(other, dict) and one.keys() == other.keys():
        for key in one:
            yield from differences(one[key], other[key], f"{place}.{key}" if place else key)
    elif one != other:
        yield place.removesuffix(f".{_CLASS}"), one, other


def change(base: Any, plain: Any) -> Any:
    """Plain data of an object as its differences from a `base`; whole if it is of another class."""
    if not (isinstance(base, dict) and isinstance(plain, dict) and base.keys() == plain.keys()):
        return plain
    if base[_CLASS] != plain[_CLASS]:
        return plain
    return {key: change(base[key], one) for key, one in plain.items() if one != base[key]}


def changed(base: Any, difference: Any) -> Any:
    """Plain data of an object from its `difference` from a `base`, as `change` gives it."""
    if not (isinstance(base, dict) and isinstance(difference, dict)) or _CLASS in difference:
        return difference
    if wrong := difference.keys() - base.keys():
        raise CodecError(f"{base.get(_CLASS)} has no {min(wrong)}")
    return base | {key: changed(base[key], one) for key, one in difference.items()}


@functools.cache
def _fields(cls: Any) -> tuple[str, ...]:
    if is_dataclass(cls):
        stored = (one for one in fields(cls) if one.metadata.get("stored", one.init))
        return tuple(one.name for one in stored)
    return tuple(getattr(cls, "_fields", ()))
