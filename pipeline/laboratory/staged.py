"""Runs of a log whose rows are stages of one specimen, as tables of a scene."""

from __future__ import annotations

import re
from collections.abc import Mapping, Sequence
from itertools import pairwise
from typing import Any

from pipeline.laboratory.logs import Log
from pipeline.scene.format_of_tests import Test

_STAGE = re.compile(r"\b(load |last)?(stages?|stufen?|steps?)\b", re.IGNORECASE)
_NEEDED = ("run", "hold", "load", "velocity")
_OF_STAGE = ("load", "velocity", "hold", "outcome", "number")  # entries that each stage has
_SAME = 1e-6  # relative difference of equal loads or velocities


def staged_runs(log: Log) -> list[dict[str, Any]]:
    """Runs of a log by their stages; empty if it has no columns of run, stage and hold.

    It is also empty unless the load alone, or the velocity alone, rises in each run, and wear was
    severe in the last stage at most.
    """
    heads = enumerate(log.sheet.headings)
    stage = next((k for k, head in heads if _STAGE.search(head.text)), None)
    if log.row_class is not Test or stage is None or not log.tests:
        return []
    runs = dict[str, list[int]]()
    for place, row in enumerate(log.in_si):
        if any(row.get(name) is None for name in _NEEDED):
            return []
        runs.setdefault(str(row["run"]), []).append(place)
    pairs = (([log.in_si[k] for k in run], [log.tests[k] for k in run]) for run in runs.values())
    found = [_run(*pair) for pair in pairs]
    if not all(found):
        return []
    if stage not in log.sheet.places.values():
        log.sheet.places["stage"] = stage
    return found


def _run(in_si: Sequence[Mapping[str, Any]], tests: Sequence[Mapping[str, Any]]) -> dict[str, Any]:
    """One run by its stages, from its rows in SI and as written; empty if they are none."""
    varied = [
        name
        for name in ("load", "velocity")
        if any(abs(a[name] - b[name]) > _SAME * abs(a[name]) for a, b in pairwise(in_si))
    ]
    outcomes = [row["outcome"] for row in in_si]
    if len(varied) > 1 or "severe" in outcomes[:-1]:
        return {}
    name = next(iter(varied), "load")  # a run of one stage
    if not all(a[name] < b[name] for a, b in pairwise(in_si)):
        return {}
    (other,) = {"load", "velocity"} - {name}
    run = run_by_stages([(row[name], row["hold"]) for row in tests], outcomes[-1] == "severe")
    last = {key: value for key, value in tests[-1].items() if key not in _OF_STAGE}
    return run | {other: tests[-1][other]} | last


def run_by_stages(held: Sequence[tuple[Any, Any]], is_severe: bool) -> dict[str, Any]:
    """Entries of a run by its stages, each a level and its hold; the last may be severe."""
    levels = [level for level, _ in held]
    mild = {"mild_up_to": levels[-2]} if is_severe and levels[1:] else {}
    ends = mild | {"severe_at": levels[-1]} if is_severe else {"mild_up_to": levels[-1]}
    return {"stages": [*map(list, held)]} | ends
