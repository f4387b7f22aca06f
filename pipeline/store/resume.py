"""Continue the store of another run with a sweep, or say why it cannot be continued."""

from __future__ import annotations

import itertools
import math
from collections.abc import Iterator, Sequence
from dataclasses import replace
from typing import Any

from pipeline.condition_kinds import CONDITIONS
from pipeline.messages import quoted
from pipeline.sweep.case import Variant
from pipeline.sweep.case_table import in_order
from pipeline.sweep.codec import differences, encode
from pipeline.sweep.plan import choose_stored_steps
from pipeline.sweep.sweep import Sweep, case_words
from pipeline.sweep.user_laws import UserObject
from tribo import InputError

_ENTRIES = {
    "pixels.shape": "window.pixels", "pixels.spacing": "window.pixel_size",
    "roughness": "disk.roughness", "pin.material": "material of the pin",
    "disk": "material of the disk",
    **{name: condition.entry for name, condition in CONDITIONS.items()},
}  # fmt: skip
"""Entries of the scene file by the beginning of an object's path, if they differ."""

_FIELDS_ASCENDING: tuple[Any, ...] = False, True, "steps"
"""Values of ``sweep.fields``, from no fields to those of all steps."""


def join(before: Sweep | None, sweep: Sweep) -> Sweep:
    """Sweep of a store that is continued: plane and cases of both, other data from `sweep`.

    Which steps and fields are stored stays as in the sweep `before`.
    """
    if before is None:
        return replace(sweep, stored_steps=choose_stored_steps(sweep))
    joined = replace(
        sweep,
        stored_steps=before.stored_steps,
        fields=before.fields,
        loads=_union("sweep.loads", before.loads, sweep.loads),
        velocities=_union("sweep.velocities", before.velocities, sweep.velocities),
        variants=_joined_variants(before, sweep),
    )
    old, new = before.case_table, sweep.case_table
    factors = _union("sweep.load_factors", old.load_factors, new.load_factors)
    if [*old.axes] != [*new.axes]:  # the scene has all cases of the store
        return replace(joined, case_table=replace(new, load_factors=factors))
    union = replace(old.union(new), load_factors=factors)
    cases = tuple((sweep if name in new.by_name else before).case(name) for name in union.names)
    return replace(joined, case_table=union, cases=cases)


def _joined_variants(before: Sweep, sweep: Sweep) -> tuple[Variant, ...]:
    """Variants of both sweeps, in the order of the store; equal ones are those of `sweep`."""
    by_point = {
        (variant.entry, variant.factor, variant.load, variant.velocity, variant.of_case): variant
        for variant in (*before.variants, *sweep.variants)
    }
    return tuple(by_point.values())


def _union(name: str, old: Sequence[float], new: Sequence[float]) -> tuple[float, ...]:
    """Union in ascending order; `InputError` for two values that are equal within rounding."""
    values = in_order([*old, *new])
    for low, high in itertools.pairwise(values):
        if math.isclose(low, high, rel_tol=1e-9):
            in_store, in_scene = (low, high) if low in old else (high, low)
            raise InputError(
                f"{name}: {in_scene!r} in the scene equals {in_store!r} in the store within "
                f"rounding; give {in_store!r}"
            )
    return tuple(values)


def mismatches(stored: Sweep, sweep: Sweep) -> Iterator[str]:
    """Reasons why a sweep cannot continue a store of the sweep `stored`; empty if it can."""
    old, new = stored.case_table, sweep.case_table
    old_hashes, new_hashes = (compared.scene_hashes for compared in (stored, sweep))
    if [*old.axes] != [*new.axes] and not {*old_hashes.values()} <= {*new_hashes.values()}:
        have, gives = (", ".join(table.axes) or "none" for table in (old, new))
        yield f"axes: {have} in the store, {gives} in the scene, which lacks cases of the store"
        return
    for name in old_hashes.keys() & new_hashes.keys():
        before, after = old.by_name[name], new.by_name[name]
        different = [
            _difference_text(k, before[k], after[k]) for k in before if before[k] != after.get(k)
        ]
        if old_hashes[name] != new_hashes[name]:
            scenes = (compared.case(name).scene for compared in (stored, sweep))
            different += changes_in_words(*scenes)
        if different:
            row = f"scene with {', '.join(case_words(name))}: " if name else ""
            yield from (f"{row}{words}" for words in different)
            break  # one differing case is enough
    if (steps := sweep.steps) not in (None, choose_stored_steps(stored).steps):
        yield _difference_text("sweep.steps", choose_stored_steps(stored).steps, steps)
    if _FIELDS_ASCENDING.index(sweep.fields) > _FIELDS_ASCENDING.index(stored.fields):
        yield _difference_text("sweep.fields", quoted(stored.fields), quoted(sweep.fields))
    try:
        join(stored, sweep)
    except InputError as error:
        yield str(error)


def changes_in_words(old: Any, new: Any) -> Iterator[str]:
    """Yield differences between two scenes or conditions, in words, with numbers in SI."""
    plain = (encode(value, with_defaults=True) for value in (old, new))
    for path, before, after in differences(*plain):
        first = next(
            (entry for entry in _ENTRIES if path == entry or path.startswith(f"{entry}.")), ""
        )
        yield _difference_text(_ENTRIES.get(first, "") + path[len(first) :], before, after)


def _difference_text(path: str, old: Any, new: Any) -> str:
    return f"{path}: {_value_text(old)} in the store, {_value_text(new)} in the scene"


def _value_text(value: Any) -> str:
    match value:
        case None:
            return "none"
        case {"is": "UserLaw" | "UserSurface"}:
            names = "name", "values", "code", "text"
            return repr(UserObject(**{name: value[name] for name in names}))
        case {"is": "number", "text": text} | {"is": "array", "digest": text} | {"is": text}:
            return str(text)
        case float():
            return f"{value:g}"
    return str(value)
