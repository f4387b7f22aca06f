"""Objects as plain data for JSON, and back: dataclasses and named tuples of known classes alone."""

from __future__ import annotations

import functools
import hashlib
import json
import math
from collections.abc import Iterator, Mapping
from dataclasses import fields, is_dataclass
from types import UnionType
from typing import Any, Literal, Union, get_args, get_origin, get_type_hints

import numpy as np

from tribo.surface import UnknownHeights, array_digest
from tribo.types import Array

NOT_STORED = {"stored": False}
"""Metadata of a field that plain data lack; decoded objects have its default."""
_CLASS = "is"  # key with the name of an object's class
_LARGEST = 2**63  # whole number
_LONGEST = 2**20  # list, mapping or text, as long as a table of tests may be
_DEEPEST = 24  # lists within lists; a sweep has four
_NUMBERS = {str(one): one for one in (math.inf, -math.inf, math.nan)}  # JSON has none of these


class CodecError(ValueError):
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
        name = str(own.pop(_CLASS, None))
        own = {key: _tuples(one) for key, one in own.items()}
        try:
            match name:
                case "number":
                    return _NUMBERS[own["text"]]
                case "array" if own["digest"] in arrays:
                    array = arrays[own["digest"]].reshape(own["shape"])
                    if array_digest(array) != own["digest"]:
                        raise ValueError("its numbers are others")
                    return array
                case "array":
                    name = "MissingSurface"
                case "MeasuredRoughness" if isinstance(own["array"], UnknownHeights):
                    return own["array"]
                case "mapping":
                    return dict(own["items"])
            cls = classes[name]
        except (KeyError, TypeError, ValueError) as error:
            raise CodecError(f"{name!r:.60}: {error}") from error
        hints = _hints(cls)
        if other := own.keys() ^ hints.keys():
            raise CodecError(f"{name}.{min(other)} is missing, or unknown")
        if wrong := [key for key, hint in hints.items() if not _fits(own[key], hint)]:
            raise CodecError(f"{name}.{wrong[0]} is {own[wrong[0]]!r:.60}")
        return cls(**own)  # any error but of the input is a fault of this program

    # Written and read once more, since the reader of JSON makes inner objects first, without a
    # frame for each level.
    text = json.dumps(plain)
    return json.loads(text, object_hook=made, parse_int=_whole, parse_constant=_refuse)


def _tuples(value: Any, depth: int = 0) -> Any:
    """A value with tuples in place of its lists; `CodecError` if it is larger than in any sweep."""
    if depth > _DEEPEST:
        raise CodecError(f"lists lie more than {_DEEPEST} within each other")
    if isinstance(value, list | str) and len(value) > _LONGEST:
        raise CodecError(f"{type(value).__name__} of {len(value)} is longer than {_LONGEST}")
    return tuple(_tuples(one, depth + 1) for one in value) if isinstance(value, list) else value


def _whole(text: str) -> int:
    if len(text) > len(str(-_LARGEST)) or abs(int(text)) >= _LARGEST:
        raise CodecError(f"{text:.20}… is too large")
    return int(text)


def _refuse(text: str) -> None:
    raise CodecError(f"{text} is no number of JSON")


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


@functools.cache
def _hints(cls: Any) -> dict[str, Any]:
    hints = get_type_hints(cls)
    return {name: hints[name] for name in _fields(cls)}


def _fits(value: Any, hint: Any) -> bool:
    """True if a decoded value is of the type that a field is annotated with."""
    origin, args = get_origin(hint), get_args(hint)
    if origin in (Union, UnionType):
        return any(_fits(value, one) for one in args)
    if origin is Literal:
        return value in args
    if origin is not None and issubclass(origin, Mapping):
        fit = isinstance(value, dict) and all(isinstance(key, str) for key in value)
        return fit and all(_fits(one, args[1]) for one in value.values())
    if origin is np.ndarray:
        return isinstance(value, np.ndarray)
    if origin is not None:  # a tuple or a sequence
        if not isinstance(value, tuple):
            return False
        kinds = args if origin is tuple and args[-1] is not ... else args[:1] * len(value)
        return len(value) == len(kinds) and all(map(_fits, value, kinds))
    if hint is None:
        return value is None
    if hint in (int, float) and type(value) is int:
        return True  # bounded by `decode`
    if hint in (int, float):
        return type(value) is hint
    if getattr(hint, "_is_protocol", False):
        names = {*dir(hint), *get_type_hints(hint)}
        return all(hasattr(value, name) for name in names if not name.startswith("_"))
    return hint is Any or not isinstance(hint, type) or isinstance(value, hint)
