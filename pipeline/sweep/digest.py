"""Digests of parts of a sweep, by the values of their fields."""

from __future__ import annotations

import hashlib
import json
from collections.abc import Mapping
from dataclasses import fields, is_dataclass
from typing import Any

import numpy as np

from pipeline.sweep.laws import MissingSurface, is_user_law, law_record
from tribo import MeasuredRoughness
from tribo.surface import array_digest


def digest(part: Any) -> str:
    """SHA-256 of a value, or of an object's fields; the numbers 2 and 2.0 are the same."""
    return hashlib.sha256(json.dumps(_plain(part)).encode()).hexdigest()


def _plain(value: Any) -> Any:
    if isinstance(value, bool | str) or value is None:
        return value
    if isinstance(value, int | float | np.number):
        number = float(value)
        return number if number == value or number != number else str(value)
    if isinstance(value, np.ndarray):
        return array_digest(value)
    if isinstance(value, MeasuredRoughness | MissingSurface):
        return value.digest
    if is_user_law(value):
        value = law_record(value)
    if is_dataclass(value):
        counted = [one.name for one in fields(value) if one.init and one.compare]
        values = [_plain(getattr(value, name)) for name in counted]
        return [type(value).__name__, *values]
    if isinstance(value, Mapping):
        return [[_plain(key), _plain(one)] for key, one in value.items()]
    return [_plain(one) for one in value]
