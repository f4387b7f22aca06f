"""A sweep as plain data, such as JSON holds, and back: by the fields that its classes have.

A dataclass is a table that names its ``type``, a tuple a list. Arrays lie beside the plain data,
which have their digests. A law of the user's own becomes a `Law`: name and hash, but no code.
"""

from __future__ import annotations

import functools
import hashlib
import json
import math
import sys
from collections.abc import Collection, Iterator, Mapping
from dataclasses import fields, is_dataclass
from types import UnionType
from typing import Any, Literal, Union, get_args, get_origin, get_type_hints

import numpy as np

from pipeline.sweep.laws import Law, is_given, is_own, law_record
from pipeline.sweep.model import Sweep
from tribo import LAWS, PINS, InputError, Surface, WearLaw
from tribo.errors import shortened
from tribo.simulation.pins import Pin
from tribo.types import Array

Arrays = dict[str, Array]
"""Arrays of a sweep by their digests."""
_OF_PROTOCOL: dict[Any, dict[str, Any]] = {Pin: PINS, WearLaw: LAWS, Surface: {}}
"""Classes that ship of each protocol."""
_SEVERAL: dict[Any, Any] = {tuple: tuple, list: list, Collection: tuple}
_GREATEST = {float: sys.float_info.max, int: 2**63 - 1}


class CodecError(InputError):
    """Plain data that are not those of a sweep."""


def encode(value: Any, arrays: Arrays) -> Any:
    """Plain data of a part of a sweep; its arrays are added to `arrays`.

    Raises
    ------
    InputError
        If the value, or a part of it, has a type that no sweep has.
    """
    if isinstance(value, np.generic):
        value = value.item()
    if value is None or isinstance(value, bool | int | str):
        return value
    if isinstance(value, float):
        return value if math.isfinite(value) else {"type": "float", "value": str(value)}
    if isinstance(value, np.ndarray):
        array = np.ascontiguousarray(value, float)
        arrays[digest := _digest(array)] = array
        return {"type": "array", "digest": digest, "shape": list(array.shape)}
    if isinstance(value, Mapping):
        items = [[encode(key, arrays), encode(one, arrays)] for key, one in value.items()]
        return {"type": "map", "items": items}
    if type(value) is tuple:
        return [encode(one, arrays) for one in value]
    name = type(value).__name__
    if is_given(value):
        value, name = law_record(value), Law.__name__
    if _kind(name) is not type(value):
        raise InputError(f"{value!r} is a {name}, which a store cannot keep")
    kind: Any = type(value)
    parts = {part: encode(getattr(value, part), arrays) for part in _parameters(kind)}
    return {"type": name} | parts


def decode(data: Any, arrays: Mapping[str, Array]) -> Any:
    """The part of a sweep that `encode` has made plain data of.

    Raises
    ------
    CodecError
        If a type or a field is unknown, a value is of another kind than its field asks for, or an
        array is missing or has another digest.
    """
    if isinstance(data, list):
        return tuple(decode(one, arrays) for one in data)
    if not isinstance(data, dict):
        return data
    values = {name: value for name, value in data.items() if name != "type"}
    match data.get("type"), values:
        case "float", {"value": "inf" | "-inf" | "nan" as value, **others} if not others:
            return float(value)
        case "array", {"digest": str(digest), "shape": shape, **others} if not others:
            return _array(digest, shape, arrays)
        case "map", {"items": [*items], **others} if not others:
            pairs = [decode(one, arrays) for one in items]
            if all(len(pair) == 2 for pair in pairs):
                return dict(pairs)
        case str(name), _ if kind := _kind(name):
            return build(kind, {k: decode(value, arrays) for k, value in values.items()})
    raise CodecError(f"the type {data.get('type')!r} is unknown, or has other entries")


def build(kind: Any, values: dict[str, Any]) -> Any:
    """An object of a dataclass or named tuple by its fields; a `CodecError` if any does not fit."""
    hints = _parameters(kind)
    if unlike := sorted(values.keys() ^ hints.keys()):
        raise CodecError(f"{kind.__name__}.{unlike[0]} is unknown or missing")
    for name, value in values.items():
        if not fits(value, hints[name]):
            raise CodecError(f"{kind.__name__}.{name} is {value!r:.60}, which it cannot be")
    return kind(**values)


def _array(digest: str, shape: Any, arrays: Mapping[str, Array]) -> Array:
    array = arrays.get(digest)
    if array is None:
        raise CodecError(f"the array {digest} is missing")
    if array.size != math.prod(shape) or _digest(array := array.reshape(shape)) != digest:
        raise CodecError(f"the array {digest} is another one")
    return array


def _digest(array: Array) -> str:
    return hashlib.sha256(repr(array.shape).encode() + array.tobytes()).hexdigest()


def _kind(name: str) -> Any:
    """Class that a sweep may contain, by its name; None for any other name."""
    if name not in _kinds():
        _kinds.cache_clear()  # one that was derived, or added to the pins, since
    return _kinds().get(name)


@functools.cache
def _kinds() -> dict[str, Any]:
    """Classes found from field to field of a sweep and of pins, and those derived from them."""
    found: dict[str, Any] = {}
    waiting: list[Any] = [Sweep, *PINS.values(), *LAWS.values()]
    while waiting:
        kind = waiting.pop()
        waiting += get_args(kind)
        # The first of a name counts: a dataclass with slots leaves the class that it was behind.
        name = getattr(kind, "__name__", "")
        if is_own(kind) or name in found or not (hints := _parameters(kind)):
            continue
        found[name] = kind
        waiting += [*hints.values(), *kind.__subclasses__()]
    return found


@functools.cache
def _parameters(kind: Any) -> dict[str, Any]:
    """What a dataclass or named tuple is made from: types by name; nothing of any other class."""
    if not isinstance(kind, type):
        return {}
    if is_dataclass(kind):
        hints = get_type_hints(kind)
        return {one.name: hints[one.name] for one in fields(kind) if one.init}
    return get_type_hints(kind) if issubclass(kind, tuple) and hasattr(kind, "_fields") else {}


def fits(value: Any, hint: Any) -> bool:
    """True if a value is of the kind of a type hint, and no number is beyond those of JSON."""
    origin, inner = get_origin(hint), get_args(hint)
    if alias := getattr(origin, "__value__", None):  # NDArray, with NumPy 2.5 and Python 3.12
        origin = get_origin(alias)
    if hint is Any:
        return True
    if hint in _OF_PROTOCOL:
        return isinstance(value, (*_OF_PROTOCOL[hint].values(), Law))
    if origin in (Union, UnionType):
        return any(fits(value, one) for one in inner)
    if origin is Literal:
        return value in inner
    if origin is tuple and ... not in inner:
        return _is_row(value, inner)
    if origin in _SEVERAL:
        return isinstance(value, _SEVERAL[origin]) and all(fits(one, inner[0]) for one in value)
    if origin is Mapping or origin is dict:
        return isinstance(value, dict) and all(_is_row(pair, inner) for pair in value.items())
    if hint in _GREATEST:
        is_number = type(value) in (int, hint)
        return (is_number and not abs(value) > _GREATEST[hint]) or value in (math.inf, -math.inf)
    return isinstance(value, origin or hint) and (hint is bool or not isinstance(value, bool))


def _is_row(value: Any, hints: tuple[Any, ...]) -> bool:
    return isinstance(value, tuple) and len(value) == len(hints) and all(map(fits, value, hints))


def sweep_text(sweep: Sweep, arrays: Arrays) -> str:
    """JSON of a sweep; its arrays are added to `arrays`."""
    return json.dumps(encode(sweep, arrays), allow_nan=False, ensure_ascii=False)


def text_sweep(text: str, arrays: Mapping[str, Array]) -> Sweep:
    """Read a sweep from its JSON; raise a `CodecError` for any other text."""
    try:
        sweep = decode(json.loads(text), arrays)
    except CodecError:
        raise
    except Exception as error:  # a forged text may fail in any way, and is one error
        raise CodecError(f"it is not the text of a sweep: {error}") from error
    if not isinstance(sweep, Sweep):
        raise CodecError(f"it is the text of a {type(sweep).__name__}")
    return sweep


def content_hash(part: Any) -> str:
    """SHA-256 of a part of a sweep, the same for a whole number and its float."""
    return hashlib.sha256(json.dumps(_floated(encode(part, {}))).encode()).hexdigest()


def _floated(data: Any) -> Any:
    """Plain data whose whole numbers are floats, as far as those have all digits."""
    if isinstance(data, dict):
        return {name: _floated(value) for name, value in data.items()}
    if isinstance(data, list):
        return [_floated(value) for value in data]
    is_whole = isinstance(data, int) and not isinstance(data, bool)
    return float(data) if is_whole and float(data) == data else data


def differences(stored: Any, wanted: Any, path: str) -> Iterator[str]:
    """Say in which fields two parts of sweeps differ."""
    yield from _unlike(encode(stored, {}), encode(wanted, {}), path)


def _unlike(stored: Any, wanted: Any, path: str) -> Iterator[str]:
    """Say in which entries plain data differ; of two classes, that they do."""
    both = [data for data in (stored, wanted) if isinstance(data, dict)]
    if len(both) == 2 and both[0].get("type") == both[1].get("type"):
        for name in {**stored, **wanted}:
            yield from _unlike(stored.get(name), wanted.get(name), f"{path}.{name}")
    elif (old := _by_name(stored)) is not None and (new := _by_name(wanted)) is not None:
        if [*old] == [*new]:
            yield from _unlike(old, new, path)
        else:
            yield f"{path}: {', '.join(old)} in the store, {', '.join(new)} in the scene"
    elif stored != wanted:
        yield f"{path}: {_short(stored)} in the store, {_short(wanted)} in the scene"


def _by_name(data: Any) -> dict[str, Any] | None:
    """Inputs by their paths, or parameters by their names; None for other data."""
    if not isinstance(data, list):
        return None
    pairs: list[Any] = [(x.get("path"), x) if isinstance(x, dict) else x for x in data]
    is_pair = (isinstance(x, tuple | list) and len(x) == 2 and type(x[0]) is str for x in pairs)
    return dict(pairs) if all(is_pair) else None


def _short(value: Any) -> str:
    if isinstance(value, dict) and "type" in value:
        return str(value["name"]) if value["type"] == Law.__name__ else f"a {value['type']}"
    return shortened(repr(value))
