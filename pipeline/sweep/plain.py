"""Objects of the kinds that type hints name, made from plain data of JSON."""

from __future__ import annotations

import sys
from collections.abc import Mapping
from contextlib import suppress
from dataclasses import MISSING, fields, is_dataclass
from types import UnionType
from typing import Any, Literal, Union, get_args, get_origin, get_type_hints

from tribo import TriboError

_GREATEST = {float: sys.float_info.max, int: 2**63 - 1}


def made(kind: Any, value: Any) -> Any:
    """An object of a kind from plain data; `ValueError` if they are not of it, or not finite.

    A kind is a type or a dataclass, a tuple of kinds that a value may have, a list of the kind of
    its entries, or a record of kinds by name: a name that ends in "?" may be missing, and with an
    ellipsis there may be others.
    """
    origin, inner = get_origin(kind), get_args(kind)
    if isinstance(kind, tuple) or origin in (Union, UnionType):
        for one in inner or kind:
            with suppress(ValueError):
                return made(one, value)
    elif (isinstance(kind, list) or origin in (list, tuple)) and isinstance(value, list | tuple):
        is_long = origin is not tuple or ... in inner
        kinds = list(inner or kind)[: 1 if is_long else None] * (len(value) if is_long else 1)
        if len(value) == len(kinds):
            return (origin or list)(map(made, kinds, value))
    elif origin is dict and isinstance(value, dict):
        return {name: made(inner[1], one) for name, one in value.items()}
    elif isinstance(kind, dict) and isinstance(value, dict):
        return _parts(kind, value)
    elif isinstance(kind, type) and is_dataclass(kind) and isinstance(value, dict):
        return kind(**_parts(record_of(kind), value))
    elif kind in (int, float):
        if type(value) in (int, kind) and abs(value) <= _GREATEST[kind]:
            return value
    elif kind is Any or type(value) is kind or (origin is Literal and value in inner):
        return value
    raise ValueError(f"{value!r} is not of the kind {kind}")


def _parts(record: Mapping[Any, Any], value: Mapping[str, Any]) -> dict[str, Any]:
    """Values of a record by name; a `ValueError` names the first that is not of its kind."""
    names = {name.removesuffix("?"): name for name in record if name is not ...}
    needed = {name for name in names if names[name] == name}
    unknown = set() if ... in record else value.keys() - names.keys()
    if wrong := (needed - value.keys()) | unknown:
        raise ValueError(min(wrong))
    parts = dict(value)
    for name in names.keys() & value.keys():
        try:
            parts[name] = made(record[names[name]], value[name])
        except (ValueError, TypeError, TriboError) as error:
            raise ValueError(name) from error
    return parts


def record_of(kind: Any) -> dict[Any, Any]:
    """What a dataclass is made from, as a record."""
    hints = get_type_hints(kind)
    return {
        field.name + "?" * (field.default is not MISSING): hints[field.name]
        for field in fields(kind)
        if field.init
    }
