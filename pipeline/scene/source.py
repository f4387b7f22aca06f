"""Entries that a sweep was read from: it is read from them again when an entry changes."""

from __future__ import annotations

import functools
from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from typing import Any

from pipeline.scene.cases_of_tests import TestReader, with_changes
from pipeline.scene.doubts import doubts_of_all
from pipeline.scene.faults import Faults
from pipeline.scene.parts import Parts
from pipeline.scene.reading import SceneReader
from pipeline.sweep.measurement import Case
from pipeline.sweep.model import Sweep
from pipeline.sweep.remarks import FromLibrary, Remark
from pipeline.sweep.stations import Stations
from pipeline.sweep.tables import Entries, replace_values
from pipeline.sweep.variants import SEED, Variants
from tribo import InputError, SelfAffineRoughness


@dataclass(frozen=True)
class Source:
    """Entries of a scene as written, in tables, and the reader that makes objects of them."""

    written: Entries
    reader: SceneReader

    def read_again(self, sweep: Sweep, written: Entries, variants: Variants) -> Sweep:
        """`sweep`, read again from entries `written`, with a table of `variants`."""
        made = read_sweep(
            sweep.name,
            replace(self, written=written),
            variants,
            notes=sweep.notes,
            sources=sweep.sources,
            stations=sweep.stations,
        )
        return made.judge(sweep.judged)

    @cached_property
    def parts(self) -> Parts:
        """Objects of the scene itself, with the tables that they were made from."""
        return self.reader.read(self.written)

    def doubts(self, sweep: Sweep) -> tuple[Remark, ...]:
        """Doubts about a sweep of this source; those of a store were found when it was made."""
        if self.reader.is_stored:
            return tuple(note for note in sweep.notes if note.grade == "warning")
        return doubts_of_all(sweep)


def read_sweep(
    name: str,
    source: Source,
    variants: Variants,
    notes: Sequence[Remark] = (),
    sources: tuple[FromLibrary, ...] = (),
    stations: Stations | None = None,
    faults: Faults | None = None,
) -> Sweep:
    """Read the scene of a `source` and the cases of `variants`; `InputError` for a fault.

    Faults of tests are added to `faults`, if it is given, and their tests left out.
    """
    parts, found = source.parts, Faults() if faults is None else faults
    declared, base = parts.declared, parts.case
    entries = source.reader.complete(source.written, parts)
    test_reader = TestReader(source.reader, source.written, entries, parts)
    tests = test_reader.tests(base, found)
    if faults is None and found:
        raise InputError(f"{found[0].key}: {found[0].problem}")
    return Sweep(
        name=name,
        title=declared.title or name,
        caveat=declared.caveat,
        base=base,
        cases=_cases(source, variants),
        variants=variants,
        loads=declared.sweep.loads,
        velocities=declared.sweep.velocities,
        fields=declared.sweep.fields,
        steps=declared.sweep.steps,
        tests=tests,
        notes=notes,
        sources=sources,
        stations=stations,
        entries=entries if found else with_changes(entries, tests),
        source=source,
    )


def _cases(source: Source, variants: Variants) -> tuple[Case, ...]:
    """A case for each row; rows that differ in the seed of a random surface are read once."""
    read = functools.cache(
        lambda key: source.reader.read(replace_values(source.written, rows[key]))
    )
    rows, cases = dict[str, dict[str, Any]](), list[Case]()
    for name in variants.names:
        values = dict(variants.values(name)) if name else {}
        others = {path: value for path, value in values.items() if path != SEED}
        for one in (others, values):
            rows[repr(one)] = one
        case = replace(read(repr(others)).case, name=name)
        rough = case.scene.roughness
        if SEED in values and isinstance(rough, SelfAffineRoughness):
            rough = replace(rough, seed=values[SEED])
            case = replace(case, scene=replace(case.scene, roughness=rough))
        elif SEED in values:
            case = replace(read(repr(values)).case, name=name)
        cases.append(case)
    return tuple(cases)
