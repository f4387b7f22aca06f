"""Variants of a scene, each with one input changed, from whose rises sensitivities follow."""

from __future__ import annotations

import itertools
from collections.abc import Iterable, Mapping
from dataclasses import replace
from typing import Any

from pipeline.scene.build import build
from pipeline.scene.cases import with_first_case
from pipeline.scene.entries import Entries, replace_values
from pipeline.scene.faults import Faults
from pipeline.scene.input_values import inputs_of
from pipeline.scene.library import resolve_library
from pipeline.sweep.case import INPUT_STEP, VELOCITY_INPUT, Case, OperatingPoint, Variant
from pipeline.sweep.sweep import Sweep
from tribo import InputError


def variants_of(
    sweep: Sweep, points: Iterable[OperatingPoint], paths: Iterable[str] | None = None
) -> tuple[Variant, ...]:
    """Variants of a scene in the inputs at `paths`, by default all, and in velocity, at points.

    All are on the first surface of the scene, with the numerical choices of the sweep. An input
    that the scene refuses on one side is left out, or refused if it is among `paths`.
    """
    if sweep.source is None or sweep.user_parts:
        raise InputError("sensitivities need a scene file, without laws or surfaces of your own")
    faults = Faults()
    entries, _ = with_first_case(sweep.source.entries, sweep.source.files, faults)
    entries = {key: entry for key, entry in entries.items() if key not in ("tests", "uncertainty")}
    entries, _ = resolve_library(entries, faults)
    base = build(entries, sweep.source.files, faults)
    faults.raise_first()
    assert base
    inputs, cases = inputs_of(base.tables), dict[tuple[str, float], Case]()
    factors = INPUT_STEP, 1 / INPUT_STEP
    chosen = [path for path in inputs if paths is None or path in {*paths}]
    for path in [*chosen]:
        changes = {factor: {path: inputs[path].times(factor)} for factor in factors}
        try:
            cases |= {(path, x): _case_with(sweep, entries, changes[x]) for x in factors}
        except InputError:  # such as a length that another entry limits
            if paths is not None:
                raise
            chosen.remove(path)
    variants = list[Variant]()
    for load, velocity in points:
        for path, factor in itertools.product((*chosen, VELOCITY_INPUT), factors):
            value, unit = velocity, "m/s"
            if path in inputs:
                value, unit = inputs[path].first, inputs[path].unit
            case = cases.get((path, factor), replace(sweep.base, name=()))
            variants.append(Variant(path, value, unit, factor, load, velocity, case))
    return tuple(variants)


def _case_with(sweep: Sweep, entries: Entries, values: Mapping[str, Any]) -> Case:
    """The case of a scene with other values of some entries."""
    built = build(replace_values(entries, values), sweep.source.files, faults := Faults())
    faults.raise_first()
    assert built
    case = built.case.with_fidelity(sweep.scene.fidelity, sweep.preset)
    return case.on_surface(getattr(sweep.scene.roughness, "seed", 0))
