"""Attributes of a store: its scene, and what computed it; and checksums of points."""

from __future__ import annotations

import functools
import hashlib
import json
import math
import struct
import zlib
from collections.abc import Iterator, Mapping
from dataclasses import dataclass, fields, is_dataclass, replace
from datetime import UTC, datetime
from importlib import metadata
from typing import Any, Self

import numpy as np
from numcodecs.zstd import Zstd

from pipeline.store.schema import AT_END, COMPRESSION, FORMAT, VARIABLES
from pipeline.sweep.conditions import corrections_by_row
from pipeline.sweep.model import Point, Sweep
from pipeline.sweep.own_laws import own_laws
from pipeline.sweep.plan import PointRecord
from pipeline.sweep.stations import Stations
from pipeline.sweep.surface import Lubrication, surface_facts
from pipeline.sweep.variants import Variant, written_of
from tribo import Scene
from tribo.errors import shortened

_OPTIONAL = (
    "coordinates", "fixed", "lubrication", "sample_corrections", "samples", "sample_seed",
    "unknown",
)  # fmt: skip
"""Attributes of a scene that a store has only where there are samples or an oil."""
_LONGEST = 2000  # characters of a message, which somebody is to read
_ENCODER = Zstd(**COMPRESSION)  # as Zarr's codec of this name uses it


def describe(sweep: Sweep, name: Variant | None = None) -> dict[str, Any]:
    """Describe what decides a scene's numbers, as plain data in SI, arrays as their digest.

    Of a table it is one combination of the dimensions that are not drawn, by default the first,
    with the rule of drawing in place of what drawn rows change.
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
    """Say in which entries two descriptions differ."""
    if isinstance(stored, Mapping) and isinstance(wanted, Mapping):
        for name in {**stored, **wanted}:
            yield from differences(stored.get(name), wanted.get(name), f"{key}.{name}")
    elif stored != wanted:
        yield f"{key}: {_short(stored)} in the store, {_short(wanted)} in the scene"


def scenes_of(attributes: Mapping[str, Any]) -> dict[tuple[Any, ...], dict[str, Any]]:
    """What a store says of the scene at each combination of the values of entries; one of none."""
    only: dict[str, Any] = {"values": [], "written": [], "scene": {}}
    return {tuple(one["values"]): one for one in attributes.get("scenes", [only])}


@dataclass(frozen=True, slots=True)
class Simulated:
    """Hash of what was simulated at each point of a store."""

    hashes: Mapping[tuple[Any, ...], str]  # by the values of the entries that have several
    entries: tuple[str, ...]  # their names

    @classmethod
    def of(cls, attributes: Mapping[str, Any]) -> Self:
        """Hashes by the attributes of a store."""
        scene = attributes["scene"]
        hashes = {k: scene_hash(scene | one["scene"]) for k, one in scenes_of(attributes).items()}
        return cls(hashes, tuple(attributes.get("over", ())))

    def at(self, point: Point) -> str:
        """Hash of what is simulated at a point."""
        return self.hashes[self.entries_at(point)]

    def entries_at(self, point: Point) -> tuple[Any, ...]:
        """Values at a point of the entries that have several."""
        labels = dict(point.variant)
        return tuple(labels[name] for name in self.entries)


def checksum(simulated: str, point: Point, data: Mapping[str, Any]) -> np.uint64:
    """Hash of what was simulated, of a point's place, and of the CRC of each variable there."""
    digest = hashlib.blake2b(simulated.encode(), digest_size=8)
    digest.update(struct.pack("<dd", point.load, point.velocity) + repr(point.variant).encode())
    for name in sorted(data):
        digest.update(name.encode())
        content = data[name]
        if not isinstance(content, bytes):
            content = np.ascontiguousarray(content).data
        digest.update(struct.pack("<L", zlib.crc32(content)))
    return np.uint64(int.from_bytes(digest.digest(), "little"))


def packed(record: PointRecord, simulated: Simulated) -> PointRecord:
    """A record with its checksum, and with fields encoded, which are a third as large to send."""
    if record.checksum is not None:
        return record
    data = {
        name: np.ascontiguousarray(values, VARIABLES[name].dtype)
        for name, values in (record.data or {}).items()
    }
    data |= {name: _ENCODER.encode(data[name]) for name in data.keys() & AT_END.keys()}
    # Names of files in a message may be no text.
    message = record.message[:_LONGEST].encode(errors="backslashreplace").decode()
    about = {"warning_flags": np.int32(record.warning_flags)}
    return replace(
        record,
        data=None if record.data is None else data,
        message=message,
        checksum=checksum(simulated.at(record.point), record.point, data | about),
    )


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
    if isinstance(value, Mapping) and "type" in value:
        return f"a {value['type']}"
    return shortened(repr(value))


def root_attributes(sweep: Sweep, before: Mapping[str, Any] | None) -> dict[str, Any]:
    """Attributes of the store of a sweep, which had others before if it is not new.

    The scene and what computed it stay; what does not decide the numbers follows the scene file.
    """
    kept = {name: value for name, value in (before or {}).items() if name not in _OPTIONAL}
    kept = kept or _lasting(sweep)
    attributes = _with_present_versions(kept) | _present(sweep) | _of_samples(sweep)
    attributes |= {"boundary_only": sweep.plane.chosen is not None, **sweep.variants.as_entries()}
    attributes |= _entries(sweep, kept)
    # As the root gives them back: JSON knows no tuples.
    plain: dict[str, Any] = json.loads(json.dumps(attributes))
    return plain


def _lasting(sweep: Sweep) -> dict[str, Any]:
    description = describe(sweep)
    return {
        "Conventions": "CF-1.11",
        "format": FORMAT,
        "scene": description,
        "scene_hash": scene_hash(description),
        "stations": Stations.of(sweep).as_dict(),
        "versions": package_versions(),
    }


@functools.cache
def package_versions() -> dict[str, str]:
    """Versions of the packages that compute and store."""
    try:
        tribo = metadata.version("irg-transition")
    except metadata.PackageNotFoundError:  # run from its source
        tribo = "unknown"
    return {"tribo": tribo} | {name: metadata.version(name) for name in ("numpy", "scipy", "zarr")}


def _with_present_versions(attributes: Mapping[str, Any]) -> dict[str, Any]:
    later = attributes.get("later_versions", [])
    last = later[-1]["versions"] if later else attributes["versions"]
    if last == package_versions():
        return dict(attributes)
    since = datetime.now(UTC).isoformat(timespec="seconds")
    entry = {"since": since, "versions": package_versions()}
    return {**attributes, "later_versions": [*later, entry]}


def _present(sweep: Sweep) -> dict[str, Any]:
    """Attributes that follow the scene file; an earlier run's reasons for the fidelity are kept."""
    picked = {"selection": sweep.about.selection.as_dict()} if sweep.about.selection else {}
    lubrication = Lubrication.of(sweep)
    oiled = {"lubrication": lubrication.as_dict()} if lubrication else {}
    of_scene = {
        "name": sweep.about.name,
        "title": sweep.about.title,
        "arguments": list(sweep.about.arguments),
        "preset": sweep.about.preset,
        "conditions": sweep.conditions.as_dict(),
        "friction_band": list(sweep.about.friction_band) if sweep.about.friction_band else None,
        "surface": _surface(sweep),
        "same_rig": sweep.about.same_rig,
        "measured": [measurement.as_dict() for measurement in sweep.about.measured],
        "tested": [measurement.as_dict() for measurement in sweep.about.tested],
        "library": [entry._asdict() for entry in sweep.about.sources],
        "loads": list(sweep.plane.loads),
        "velocities": list(sweep.plane.velocities),
    }
    return picked | oiled | of_scene


def _surface(sweep: Sweep) -> str | None:
    """The disk's surface in words, with what was done to a scan; None if it is smooth."""
    facts = surface_facts(sweep)
    done = [note for note in sweep.about.notes if note.startswith("disk.roughness")]
    return None if facts is None else "; ".join([facts.words, *done])


def _of_samples(sweep: Sweep, name: Variant = ()) -> dict[str, Any]:
    """Corrections of each sample of a combination of entries, where its inputs change them."""
    table, own = sweep.variants, sweep.variant(name).conditions
    if not table.draw or (table.chosen and not name):
        return {}
    parts = (dict(table.part(row)) for row in table.names if row[: len(name)] == name)
    rows = [part.get("conditions", own).corrections for part in parts]
    columns = corrections_by_row(own.corrections, rows)
    return {"sample_corrections": columns} if columns else {}


def _entries(sweep: Sweep, stored: Mapping[str, Any]) -> dict[str, Any]:
    """For each combination of labels that are not drawn, if several: what differs from the rest."""
    table = sweep.variants
    if not table.chosen:
        return {}
    present = _present(sweep)
    combinations = {tuple(entry["values"]): entry for entry in stored.get("scenes", [])}
    for name in table.given:
        values = tuple(value for _, value in name)
        combinations[values] = {
            "values": list(values),
            "written": list(written_of(table, name).values()),
            "scene": _differing(describe(sweep, name), stored["scene"]),
            "attributes": _differing(
                _present(sweep.variant(name)) | _of_samples(sweep, name), present
            ),
        }
    return {"over": [column.name for column in table.chosen], "scenes": [*combinations.values()]}


def _differing(values: Mapping[str, Any], usual: Mapping[str, Any]) -> dict[str, Any]:
    """Values that differ from the usual ones; None for what is missing."""
    return {
        name: values.get(name)
        for name in {**usual, **values}
        if values.get(name) != usual.get(name)
    }
