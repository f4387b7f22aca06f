"""Identity of a store and its points: description of the scene, differences, checksums."""

from __future__ import annotations

import hashlib
import json
import math
import struct
import zlib
from collections.abc import Iterator, Mapping
from dataclasses import dataclass, fields, is_dataclass
from typing import Any, Self

import numpy as np

from pipeline.sweep.model import Point, Sweep
from pipeline.sweep.own_laws import own_laws
from pipeline.sweep.variants import Variant
from tribo import Scene


def describe(sweep: Sweep, name: Variant | None = None) -> dict[str, Any]:
    """Describe what decides a scene's numbers, as plain data in SI, arrays as their digest.

    Of a table of variants it is the scene with one combination of the dimensions that are not
    drawn, the first if none is named. What drawn rows change field by field is left out, and the
    rule by which they were drawn is part of it.
    """
    table = sweep.variants
    scene = sweep.variant(next(iter(table.given)) if name is None else name).scene
    laws = own_laws(scene)
    parts = {
        entry.name: laws.get(entry.name) or _plain(getattr(scene, entry.name))
        for entry in fields(Scene)
    }
    for part, *inner in (path.split(".") for path in table.drawn_fields):
        parts[part] = parts[part] | {inner[0]: None}
    if table.draw:
        parts["samples"] = table.draw.design.as_dict()
    return parts


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


@dataclass(frozen=True, slots=True)
class Simulated:
    """Hash of what was simulated at each point of a store.

    Attributes
    ----------
    hashes : mapping of tuple to str
        SHA-256 of the scene by the values of the entries that have several, in order.
    entries : tuple of str
        Their names.
    """

    hashes: Mapping[tuple[Any, ...], str]
    entries: tuple[str, ...] = ()

    @classmethod
    def of(cls, attributes: Mapping[str, Any]) -> Self:
        """Hashes by the attributes of a store."""
        scene = attributes["scene"]
        entries = attributes.get("scenes", [{"values": [], "scene": {}}])
        hashes = {tuple(one["values"]): scene_hash(scene | one["scene"]) for one in entries}
        return cls(hashes, tuple(attributes.get("over", ())))

    def at(self, point: Point) -> str:
        """Hash of what is simulated at a point."""
        labels = dict(point.variant)
        return self.hashes[tuple(labels[name] for name in self.entries)]


def checksum(simulated: str, point: Point, data: Mapping[str, Any]) -> np.uint64:
    """Hash of what was simulated, of the place of a point, and of what is stored of its stations.

    Of each variable it takes the CRC, of a field that of its chunk as it is encoded: nothing else
    writes that, and whoever compares need not decode it.
    """
    digest = hashlib.blake2b(simulated.encode(), digest_size=8)
    digest.update(struct.pack("<dd", point.load, point.velocity) + repr(point.variant).encode())
    for name in sorted(data):
        digest.update(name.encode())
        content = data[name]
        if not isinstance(content, bytes):
            content = np.ascontiguousarray(content).data
        digest.update(struct.pack("<L", zlib.crc32(content)))
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
