"""A sweep judged by other conditions, or with unknown inputs at one value: no new simulation."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace
from typing import Any

from pipeline.sweep.conditions import PATHS
from pipeline.sweep.model import Sweep
from pipeline.sweep.unknown import Fixed, Unknown, without
from pipeline.sweep.variants import Part


def replace_conditions(sweep: Sweep, changes: Mapping[str, Any]) -> Sweep:
    """The sweep with other fields of its `Conditions`, those of its rows among them."""

    def changed(part: Part) -> Part:
        return tuple((k, replace(v, **changes) if k == "conditions" else v) for k, v in part)

    table = sweep.variants
    table = replace(
        table,
        parts=tuple(map(changed, table.parts)),
        given={name: changed(part) for name, part in table.given.items()},
    )
    return sweep.changed(conditions=replace(sweep.conditions, **changes), variants=table)


def open_inputs(sweep: Sweep) -> dict[str, Unknown]:
    """Unknown inputs of samples by their paths, and those with one value that may have another."""
    draw = sweep.variants.draw
    if draw is None:
        return {}
    movable = {*PATHS.values(), *(one.path for one in draw.design.inputs)}
    stored = (one.unknown for one in draw.fixed if one.unknown.path in movable)
    return {one.path: one for one in (*stored, *draw.unknown)}


def fix_inputs(sweep: Sweep, values: Mapping[str, float]) -> Sweep:
    """The sweep with those of its unknown inputs at one value [SI] that are among some values."""
    draw, inputs = sweep.variants.draw, open_inputs(sweep)
    new = {path: Fixed(inputs[path], value) for path, value in values.items() if path in inputs}
    if draw is None or not new:
        return sweep
    stored = {one.unknown.path: one for one in draw.fixed}
    rest = without(draw.unknown, new.keys())
    draw = replace(draw, unknown=rest, fixed=(*(stored | new).values(),))
    return sweep.changed(variants=replace(sweep.variants, draw=draw))
