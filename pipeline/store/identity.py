"""What a store is of: the description of its scene, how two differ, and checksums of points."""

from __future__ import annotations

import hashlib
import json
import math
import struct
from collections.abc import Iterator, Mapping
from dataclasses import fields, is_dataclass
from typing import Any

import numpy as np

from pipeline.sweep.model import Point, Sweep
from tribo import Scene
from tribo.types import Array

__all__ = ["checksum", "describe", "differences", "scene_hash", "stored_scene"]


def describe(sweep: Sweep) -> dict[str, Any]:
    """What decides a scene's numbers, as plain data in SI: its parts, arrays as their digest.

    A seed is none of it where there are realizations, each with its own.
    """
    parts = {entry.name: _plain(getattr(sweep, entry.name)) for entry in fields(Scene)}
    if sweep.realizations:
        parts["roughness"]["seed"] = None
    return parts


def stored_scene(attributes: Mapping[str, Any]) -> dict[str, Any]:
    """The description of a scene in a store, with what stores did not always say.

    Examples
    --------
    >>> stored_scene({"scene": {"wear": None}})
    {'friction_heat': True, 'wear': None}
    """
    scene: dict[str, Any] = attributes["scene"]
    return {"friction_heat": True} | scene


def scene_hash(description: Mapping[str, Any]) -> str:
    """SHA-256 of what `describe` gives."""
    return hashlib.sha256(json.dumps(description, sort_keys=True).encode()).hexdigest()


def differences(stored: Any, wanted: Any, key: str = "scene") -> Iterator[str]:
    """Say in which entries two descriptions differ.

    Examples
    --------
    >>> stored, wanted = {"pin": {"radius": 0.004}}, {"pin": {"radius": 0.005}, "wear": None}
    >>> list(differences(stored, wanted))
    ['scene.pin.radius: 0.004 in the store, 0.005 in the scene']
    """
    if isinstance(stored, Mapping) and isinstance(wanted, Mapping):
        for name in {**stored, **wanted}:
            yield from differences(stored.get(name), wanted.get(name), f"{key}.{name}")
    elif stored != wanted:
        yield f"{key}: {_short(stored)} in the store, {_short(wanted)} in the scene"


def checksum(data: Mapping[str, Array], point: Point | None = None) -> np.uint64:
    """Hash of what is stored of a point: the rows of its own steps, its fields, and its place.

    Stores of format 1 leave the place out.
    """
    digest = hashlib.blake2b(digest_size=8)
    if point is not None:
        digest.update(struct.pack("<dd", point.load, point.velocity))
        digest.update(f"{point.realization}".encode())
    for name in sorted(data):
        digest.update(name.encode())
        digest.update(np.ascontiguousarray(data[name], dtype="<f8").tobytes())
    return np.uint64(int.from_bytes(digest.digest(), "little"))


def _plain(value: Any) -> Any:
    if isinstance(value, np.ndarray):
        content = repr(value.shape).encode() + np.ascontiguousarray(value).tobytes()
        return f"sha256:{hashlib.sha256(content).hexdigest()}"
    if is_dataclass(value):
        parts = {part.name: getattr(value, part.name) for part in fields(value) if part.init}
        return {"type": type(value).__name__} | {name: _plain(part) for name, part in parts.items()}
    if isinstance(value, tuple):
        return [_plain(part) for part in value]
    if isinstance(value, float) and not math.isfinite(value):
        return str(value)  # JSON has no infinity
    return value.item() if isinstance(value, np.generic) else value


def _short(value: Any) -> str:
    return "a " + value["type"] if isinstance(value, Mapping) and "type" in value else repr(value)
