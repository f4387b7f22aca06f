"""Digests that tell points of different scenes apart."""

from __future__ import annotations

import functools
from dataclasses import fields

from pipeline.sweep.digest import digest
from pipeline.sweep.model import Sweep
from pipeline.sweep.variants import Variant

_NAMED = ("name", "scene")


def scene_ids(sweep: Sweep) -> list[int]:
    """Scene id of each variant: an int32 hash of everything that affects simulation and verdict."""
    table, ids = sweep.variants, list[int]()
    of_part = functools.lru_cache(None, typed=True)(digest)  # rows share large surfaces

    @functools.cache
    def of_scene(name: Variant) -> str:
        case = sweep.case(name)
        parts = [of_part(getattr(case.scene, one.name)) for one in fields(case.scene)]
        rest = [getattr(case, one.name) for one in fields(case) if one.name not in _NAMED]
        return digest((*parts, rest, sweep.tests, sweep.inputs))

    for name in table.names:
        ids.append(int.from_bytes(bytes.fromhex(of_scene(name)[:8]), signed=True))
    return ids
