"""The commands ``irg status`` and ``irg verify``."""

from __future__ import annotations

import argparse

import pipeline
from pipeline.answers.discretization_error import error_in_words
from pipeline.cli.output import DONE, SOME_FAILED, Result, working
from pipeline.frames import frame_of, records
from pipeline.store.place import REMEDY, StoreError
from pipeline.store.status import states

_HEADS = "name", "state", "points", "done", "failed", "pending", "preset", "title"


def status(options: argparse.Namespace) -> Result:
    """Answer ``irg status``: count the points of a store."""
    state, sweep = states(options.store)
    tests = [state.tests] if state.tests else []
    failed = [point for summary in (state, *tests) for point in summary.failed]
    counts = f"{state.done} done, {len(state.failed)} failed, {state.pending} pending"
    text = [
        state.title,
        f"{state.total} points: {counts}",
        *(f"tests: {summary.done} of {summary.total} points done" for summary in tests),
        *[f"running: {state.running}"] * bool(state.running),
        error_in_words(sweep),
        *(f"failed: {point}" for point in failed),
    ]
    warned = None
    try:
        warned = pipeline.points_with_warnings(options.store)
    except StoreError as error:  # points are counted nevertheless
        text.append(f"points with warnings could not be counted: {error}")
    words = "running now, " * bool(state.running)
    words += "done" if state.done == state.total else counts
    numbers = state.total, state.done, len(state.failed), state.pending
    frame = frame_of(_HEADS, [(state.name, words, *numbers, sweep.preset, state.title)])
    return Result(text=text, warned=warned, frames=[frame], code=SOME_FAILED if failed else DONE)


def verify(options: argparse.Namespace) -> Result:
    """Answer ``irg verify``: read all data of a store, and list damaged points."""
    with working("reading points") as progress:
        check = pipeline.verify_store(options.store, progress)
    text, rows, document = list[str](), list[tuple[object, ...]](), dict[str, object]()
    for kind, group in {"points": check, "tests": check.tests}.items():
        if group:
            document[kind] = {"done": group.done, "damaged": len(group.damaged)}
            text.append(f"{kind}: {group.done} done and undamaged, {len(group.damaged)} damaged")
            text += [f"damaged: {damage}" for damage in (*group.damaged, *group.shared)]
            rows += [(p.load, p.velocity, p.place, p.message) for p in group.damaged]
    frame = frame_of(("load [N]", "velocity [m/s]", "place", "message"), rows)
    document |= {"damaged": records([frame]), "shared": [*map(str, check.shared)]}
    if check.is_clean:
        return Result(document, text, pipeline.points_with_warnings(options.store), [frame])
    return Result(document, [*text, REMEDY], frames=[frame], code=SOME_FAILED)
