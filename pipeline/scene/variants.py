"""Variants of a scene, each with one input changed, from whose rises sensitivities follow."""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from dataclasses import replace
from typing import NamedTuple

import numpy as np

from pipeline.faults import Faults
from pipeline.scene.build import build, build_case
from pipeline.scene.cases import listed_cases, with_first_case
from pipeline.scene.entries import Entries, merged, replace_values
from pipeline.scene.input_values import Input, inputs_of
from pipeline.scene.library import resolve_library
from pipeline.sweep.case import CLOSED_FORM, INPUT_STEP, VELOCITY_INPUT, Case, Variant
from pipeline.sweep.case_table import AREAS_ENTRY, SEED_ENTRY, CaseName
from pipeline.sweep.sweep import TABLE_OF_PART, Point, Sweep
from tribo import InputError
from tribo.types import Array

_FACTORS = INPUT_STEP, 1 / INPUT_STEP


class _ChangedInput(NamedTuple):
    """An input of a scene, and the cases in which it is multiplied by factors."""

    path: str
    entry: Input
    cases: dict[float, Case]


def variants_of(
    sweep: Sweep, points: Iterable[Point], paths: Iterable[str] | None = None
) -> tuple[Variant, ...]:
    """Variants of a scene in the inputs at `paths`, by default all, and in velocity, at points.

    Cases of the points are named without surfaces. All variants are on the first surface, with the
    numerical choices of the sweep. Parts that `Sweep.with_scene` replaced stay, and have no inputs.
    An input that the scene refuses on one side is changed on the other; one that it refuses on both
    sides is left out, or refused if it is among `paths`.
    """
    if sweep.source is None:
        raise InputError("sensitivities need the scene file; use it in place of its store")
    cases = dict(zip(sweep.case_table.without_surfaces.names, sweep.on_first_surface, strict=True))
    entries_by_case, changed_inputs = _entries_by_case(sweep), dict[CaseName, list[_ChangedInput]]()
    variants, requested = list[Variant](), None if paths is None else {*paths}
    for load, velocity, name in points:
        case = replace(cases.get(name, sweep.base), name=())
        if name not in changed_inputs:
            entries = entries_by_case[name]
            changed_inputs[name] = [*_changed_inputs(sweep, entries, case, requested)]
        variants += [
            Variant(path, entry.first, entry.unit, factor, load, velocity, changed, name)
            for path, entry, changed_cases in changed_inputs[name]
            for factor, changed in changed_cases.items()
        ]
        variants += [
            Variant(VELOCITY_INPUT, velocity, "m/s", factor, load, velocity, case, name)
            for factor in (1.0, *_FACTORS)
        ]
    return tuple(variants)


def uncertain_inputs(sweep: Sweep) -> set[str]:
    """Paths of the uncertain inputs of a scene that act by simulations; none without verdicts."""
    if not (sweep.base.is_judged and sweep.conditions.friction):
        return set()
    return {path for each in sweep.base.uncertainty for path in each.entries} - {*CLOSED_FORM}


def expected_variants(sweep: Sweep) -> tuple[Variant, ...]:
    """Variants that a run of a sweep adds for its uncertain inputs, at other velocities.

    They are at three loads of each case, in a sweep of rows at one row.
    """
    if not (paths := uncertain_inputs(sweep)):
        return ()
    names, loads = sweep.case_table.without_surfaces.names, spread(np.array(sweep.loads))
    if sweep.case_table.column("load") is not None:
        names, loads = names[:1], loads[:1]
    points = (Point(load, sweep.velocities[-1], name) for name in names for load in loads.tolist())
    return variants_of(sweep, points, paths)


def spread(values: Array) -> Array:
    """The first, middle and last of ascending values, each once."""
    return np.unique(values[[0, len(values) // 2, -1]])


def _entries_by_case(sweep: Sweep) -> dict[CaseName, Entries]:
    """Entries of each case of a scene, with values of the library, but neither tests nor seeds."""
    assert sweep.source
    faults, files = Faults(), sweep.source.files
    entries, rows = with_first_case(sweep.source.entries, files, faults)
    entries = {key: entry for key, entry in entries.items() if key not in ("tests", "uncertainty")}
    base = build(entries, files, faults)
    faults.raise_first()
    assert base
    entries_by_case: dict[CaseName, Entries] = {(): resolve_library(entries, faults)[0]}
    cases = listed_cases(base, rows or [])
    chosen = {column.name for column in cases.table.chosen_columns}
    for labels, changes in zip(cases.table.names, cases.changes, strict=True):
        name = tuple((dim, label) for dim, label in labels if dim in chosen)
        if name not in entries_by_case:
            values = {k: v for k, v in changes.items() if k not in (SEED_ENTRY, AREAS_ENTRY)}
            changed = replace_values(entries, values)
            entries_by_case[name] = resolve_library(changed, faults)[0]
    return entries_by_case


def _changed_inputs(
    sweep: Sweep, entries: Entries, case: Case, requested: set[str] | None
) -> Iterator[_ChangedInput]:
    """Yield the inputs of one case, each with the cases in which it is changed."""
    base = build(entries, sweep.source.files, Faults())
    assert base
    replaced_tables = [f"{TABLE_OF_PART[name]}." for name in sweep.source.user_parts]
    parts = {name: getattr(case.scene, name) for name in sweep.source.user_parts}
    for path, entry in inputs_of(base.tables).items():
        if path.startswith((*replaced_tables,)):
            if requested and path in requested:
                table = path.rpartition(".")[0]
                raise InputError(
                    f"uncertainty.{path} has no effect, since with_scene has replaced {table}; "
                    "leave it out"
                )
            continue
        if requested is not None and path not in requested:
            continue
        changed_cases, problem = dict[float, Case](), ""
        for factor in _FACTORS:
            faults, changed = Faults(), merged(entries, entry.times(factor))
            try:
                built = build_case(base, changed, {}, sweep.source.files, faults)
                faults.raise_first()
                assert built
            except InputError as error:  # such as a length that another entry limits
                problem = str(error)
                continue
            scene = replace(built.case.scene, fidelity=case.scene.fidelity, **parts)
            varied = replace(built.case, scene=scene, preset=case.preset, uncertainty=())
            changed_cases[factor] = varied.on_surface(getattr(case.scene.roughness, "seed", 0))
        if changed_cases:
            yield _ChangedInput(path, entry, changed_cases)
        elif requested is not None:
            raise InputError(f"uncertainty.{path}: ± 10 % of the input are refused: {problem}")
