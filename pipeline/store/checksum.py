"""Checksums of points, and records as they are sent and written."""

from __future__ import annotations

import functools
import hashlib
import struct
import zlib
from collections.abc import Mapping
from dataclasses import replace
from typing import Any

import numpy as np

from pipeline.store.schema import DATA, VARIABLES
from pipeline.sweep.model import Point
from pipeline.sweep.plan import PointRecord

_LONGEST = 2000  # characters of a message, so that somebody can read it
_COVERED = {*DATA, "message", "warning_flags"}


def checksum(scene_hash: str, point: Point, entries: Mapping[str, Any]) -> str:
    """Checksum of a point's scene, load, velocity, variant and stored values: 16 hex digits.

    `scene_hash` is the hash of the scene that is simulated at the point (`Sweep.scene_hash`), and
    `entries` are the point's values by variable. Variables that are no results, such as the
    duration of the computation, are ignored.
    """
    place = struct.pack("<dd", point.load, point.velocity) + repr(point.variant).encode()
    parts = [scene_hash.encode(), place]
    for name, word in _covered(tuple(entries)):
        content = entries[name]
        if isinstance(content, str):
            content = content.encode()
        elif isinstance(content, np.ndarray) and not content.flags.c_contiguous:
            content = np.ascontiguousarray(content)
        parts += word, zlib.crc32(content).to_bytes(4, "little")
    return hashlib.blake2b(b"".join(parts), digest_size=8).hexdigest()


@functools.lru_cache(maxsize=16)  # points of a store have the same variables
def _covered(names: tuple[str, ...]) -> list[tuple[str, bytes]]:
    """Names of the variables that a checksum covers, sorted, as text and as bytes."""
    return [(name, name.encode()) for name in sorted({*names} & _COVERED)]


def packed(record: PointRecord, scene_hash: str) -> PointRecord:
    """Copy of a record with values of the types that are stored, and with its checksum.

    `scene_hash` is that of the scene. A message is cut to 2000 characters. A record that has a
    checksum is returned unchanged.
    """
    if record.checksum is not None:
        return record
    data = {
        name: np.asarray(values, VARIABLES[name].dtype, order="C")
        for name, values in (record.data or {}).items()
    }
    # Names of files in a message may not be valid UTF-8.
    message = record.message[:_LONGEST].encode(errors="backslashreplace").decode()
    about = {"message": message, "warning_flags": np.int32(record.warning_flags)}
    return replace(
        record,
        data=None if record.data is None else data,
        message=message,
        checksum=checksum(scene_hash, record.point, data | about),
    )
