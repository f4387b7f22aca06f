"""Samples, as the rest of the package uses them: fixing inputs, and describing them."""

from __future__ import annotations

import json
import math
from collections.abc import Mapping
from typing import Any

import numpy as np
from scipy.special import ndtr

from pipeline.quantities import ALIKE, snap
from pipeline.scene.units import in_si
from pipeline.sweep.shown import Line
from pipeline.sweep.variants import Sampling
from pipeline.uncertain.samples import REACH, Draw
from tribo import InputError


def read_rule(draw: Any) -> Sampling:
    """Return how samples were drawn, as a `Sampling`, from `draw`, the plain data of a `Draw`.

    A `Sampling` has the paths of the unknown inputs, and plain data. Its field `rows` is all that
    samples depend on, without correlations of inputs: sweeps with equal `rows` have the same
    samples. Its field `answers` has the unknown and the fixed inputs, on which answers depend, too.
    Units of the scene file are left out, since they are only for display.
    """
    plain = json.loads(json.dumps(draw), object_hook=_drop_unit)
    unknown, fixed, design = (plain[key] for key in ("unknown", "fixed", "design"))
    inputs = [{**one, "correlated": None} for one in design["inputs"]]
    paths, movable = (one["path"] for one in unknown), Draw.of(draw).open_inputs
    rows = design | {"inputs": inputs}
    return Sampling(tuple(paths), tuple(movable), (unknown, fixed), rows, design["per_contact"])


def _drop_unit(table: dict[str, Any]) -> dict[str, Any]:
    return {key: one for key, one in table.items() if key != "written"}


def fixed_at(draw: Any, values: Mapping[str, Any]) -> dict[str, Any]:
    """Copy the plain data of a `Draw`, with inputs fixed at `values` [SI], by path."""
    return Draw.of(draw).fixed_at(values).as_dict()


def drawn_value(draw: Any, path: str, value: float | str) -> float:
    """Convert a value of the unknown input at `path` to SI.

    `value` is text with a unit, or a number in SI; `draw` is the plain data of a `Draw`. Raises an
    `InputError` if the value is outside the samples.
    """
    unknown = Draw.of(draw).open_inputs[path]
    number = in_si(unknown.path, value, f"1 {unknown.shown}".rstrip())
    if unknown.kind == "list":
        nearest = min(unknown.parameters, key=lambda one: abs(one - number))
        if math.isclose(nearest, number, rel_tol=ALIKE):
            return nearest
        allowed = f"one of {', '.join(map(unknown.text, unknown.parameters))}"
    else:
        low, high = unknown.quantile(ndtr(np.array([-REACH, REACH]))).tolist()
        if unknown.kind == "uniform":
            low, high = unknown.parameters
        if low <= (number := snap(number, low, high)) <= high:
            return number
        allowed = f"one from {unknown.text(low, 4)} to {unknown.text(high, 4)}"
    raise InputError(
        f"{unknown.path} is {unknown.text(number)}, outside the samples; give {allowed}, or run "
        f"the scene with --set {unknown.path}=… into another store"
    )


def describe_samples(data: Any, count: int) -> list[Line]:
    """List rows (label, text) on each unknown or fixed input, and on the `count` samples.

    `data` is the plain data of a `Draw`, the rule that generates the samples.
    """
    draw = Draw.of(data)
    design = draw.design
    simulated = {one.path for one in design.inputs}
    rows = [
        ("unknown", f"{one}{'; acts afterwards' * (one.path not in simulated)}")
        for one in draw.unknown
    ]
    rows += [("fixed", str(one)) for one in draw.fixed]
    low, high = design.velocities
    more = "would share their contacts" if count == design.sufficient else "can be added"
    share = f"{design.per_contact} share each contact; " if design.per_contact > 1 else ""
    sequence = f"scrambled Sobol' of seed {design.seed}, {low:g} to {high:g} m/s"
    rows.append(("samples", f"{count}, {sequence}; {share}more {more}"))
    return rows
