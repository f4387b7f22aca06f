"""Tests of a trace, as lines of a scene file, once a person has said what happened."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from itertools import pairwise
from typing import Any

import numpy as np

from pipeline.laboratory.staged import run_by_stages
from pipeline.laboratory.trace import COMMANDS, Level, LoadStage, Trace
from pipeline.quantities import UNITS, display
from pipeline.scene.document import as_toml
from pipeline.scene.names import UNITS as SI_UNITS
from tribo import InputError

_LEAST_ROWS = 3  # rows before the scuff, at least, from which friction is taken
_OPEN = "..."  # begins a value that the user has to fill in


def toml_of(trace: Trace, missing: Mapping[str, str], scuffed_at: float | None) -> Iterator[str]:
    """Yield a trace's tests as lines for a scene file, with comments at missing values.

    The trace stayed mild if `scuffed_at` [s] is None. `missing` has the reasons by the name of the
    value.
    """
    for test in _tests(trace, scuffed_at):
        yield "[[tested]]"
        for name, value in test.items():
            why = missing.get(name, f'in no column; give --given "{name}={value}"')
            more = f"  # {why}" if str(value).startswith(_OPEN) else ""
            yield f"{name} = {as_toml(value)}{more}"


def _tests(trace: Trace, scuffed_at: float | None) -> list[dict[str, Any]]:
    """Tests of a run that stayed mild, or scuffed at a time [s], as tables of a scene file."""
    stages, at = trace.stages, None
    if scuffed_at is not None:
        if scuffed_at > trace.time[-1]:
            end = f"{trace.time[-1]:.4g} s"
            raise InputError(f"--scuffed-at is {scuffed_at:g} s, and the record ends at {end}")
        stages = stages[: trace.stage_at(scuffed_at) + 1]
        at = int(np.searchsorted(trace.time, scuffed_at))
    outcomes = ["mild"] * len(stages)
    outcomes[-1] = "mild" if at is None else "severe"
    places = [_place(trace, stage, None) for stage in stages]
    places[-1] = _place(trace, stages[-1], at)
    rows = [stage.rows for stage in stages]
    if at is not None:
        rows[-1] = _before_scuff(trace, stages, at)
    if len(stages) == 1:
        return [places[0] | _conditions(trace, rows[0]) | {"outcome": outcomes[0]}]
    if varied := _varied(trace, stages):
        (other,) = {*COMMANDS} - {varied}
        held = [
            (place[varied], f"{trace.duration_of(stage):.4g} s")
            for place, stage in zip(places, stages, strict=True)
        ]
        run = run_by_stages(held, at is not None)
        return [run | {other: places[-1][other]} | _conditions(trace, rows[-1])]
    return [
        place | _conditions(trace, own) | {"outcome": outcome, "run": 1}
        for place, own, outcome in zip(places, rows, outcomes, strict=True)
    ]


def _varied(trace: Trace, stages: list[LoadStage]) -> str | None:
    """Name of the only command that changes from stage to stage, if it rises with each."""
    changed = []
    for name in COMMANDS:
        levels = [getattr(stage, name) for stage in stages]
        if any(isinstance(level, tuple) for level in levels):
            return None
        if levels[0] is not None and max(levels) - min(levels) > 0.03 * max(levels):
            changed.append((name, levels))
    if len(changed) != 1:
        return None
    name, levels = changed[0]
    texts = [_text(name, level) for level in levels]
    rises = all(a < b for a, b in pairwise(levels))
    return name if rises and len({*texts}) == len(texts) else None


def _before_scuff(trace: Trace, stages: list[LoadStage], at: int) -> slice:
    """Rows of the last stage before the scuff at row `at`, or else of the stage before it."""
    rows = stages[-1].rows
    # Friction may have risen earlier than the person says.
    rises = [one.row for one in trace.rises[:1] if rows.start <= one.row <= at]
    stop = min([*rises, at, rows.stop])
    if stop >= rows.start + _LEAST_ROWS:
        return slice(rows.start, stop)
    return stages[-2].rows if stages[1:] else slice(rows.start, rows.start + _LEAST_ROWS)


def _conditions(trace: Trace, rows: slice) -> dict[str, Any]:
    """Entries of a test, by name: median friction in some rows, and median bulk temperature."""
    values: dict[str, Any] = {"friction": float(f"{np.median(trace.friction[rows]):.3g}")}
    if (warm := trace.temperature_of(rows)) is not None:
        values["bulk_temperature"] = display(warm, "°C", 4).replace("°", "deg")
    return values


def _place(trace: Trace, stage: LoadStage, at: int | None) -> dict[str, str]:
    """Load and velocity of a test as text, "... N" if not recorded; on a ramp at row `at`."""
    place = dict[str, str]()
    for name in COMMANDS:
        level: Level = getattr(stage, name)
        if isinstance(level, tuple):
            row = None if at is None else min(max(at, stage.rows.start), stage.rows.stop - 1)
            level = max(level) if row is None else float(trace.commands[name].values[row])
        place[name] = f"{_OPEN} {SI_UNITS[name]}" if level is None else _text(name, level)
    return place


def _text(name: str, value: float) -> str:
    return f"{value:.4g} {UNITS[name]}"
