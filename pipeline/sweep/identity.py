"""Digests that tell points of different scenes apart."""

from __future__ import annotations

import functools
from dataclasses import fields

from pipeline.sweep.digest import digest
from pipeline.sweep.model import Sweep
from pipeline.sweep.variants import Variant


def scene_ids(sweep: Sweep) -> list[int]:
    """Scene id of each variant: an int32 hash of everything that affects simulation and verdict."""
    table, ids = sweep.variants, list[int]()
    of_part = functools.lru_cache(None, typed=True)(digest)  # rows share large surfaces

    @functools.cache
    def of_scene(name: Variant) -> str:
        row = sweep.variant(name)
        parts = [of_part(getattr(row.scene, one.name)) for one in fields(row.scene)]
        return digest((*parts, row.conditions, row.verdict_inputs))

    for name in table.names:
        ids.append(int.from_bytes(bytes.fromhex(of_scene(name)[:8]), signed=True))
    return ids
