"""The commands ``irg status`` and ``irg verify``."""

from __future__ import annotations

import argparse
from collections.abc import Iterator
from contextlib import suppress
from pathlib import Path

import pipeline
from pipeline.answers.discretization_error import error_in_words
from pipeline.cli.output import DONE, SOME_FAILED, Result, working
from pipeline.frames import frame_of, records, without_columns
from pipeline.store.place import REMEDY, ROOT, StoreError
from pipeline.store.status import Summary, states

_HEADS = "name", "state", "points", "done", "failed", "pending", "preset", "title"


def status(options: argparse.Namespace) -> Result:
    """Answer ``irg status``: count the points of a store, or list the stores in a folder."""
    path = options.store
    if isinstance(path, Path) and path.is_dir() and not _is_store(path) and path.suffix != ".zarr":
        rows = [_listed(below, str(below.relative_to(path))) for below in _stores_below(path)]
        frame = frame_of(_HEADS, rows)
        brief = without_columns(frame, ("points", "done", "failed", "pending"))
        return Result(text=[brief if rows else f"{path} has no results store"], frames=[frame])
    state, sweep = states(path)
    tests = [state.tests] if state.tests else []
    failed = [point for one in (state, *tests) for point in one.failed]
    text = [
        state.title,
        f"{state.total} points: {_counts(state)}",
        *(f"tests: {one.done} of {one.total} points done" for one in tests),
        *[f"running: {state.running}"] * bool(state.running),
        error_in_words(sweep),
        *(f"failed: {point}" for point in failed),
    ]
    warned = None
    try:
        warned = pipeline.points_with_warnings(path)
    except StoreError as error:  # points are counted nevertheless
        text.append(f"points with warnings could not be counted: {error}")
    frame = frame_of(_HEADS, [_row(state.name, state, sweep.preset)])
    return Result(text=text, warned=warned, frames=[frame], code=SOME_FAILED if failed else DONE)


def _counts(state: Summary) -> str:
    return f"{state.done} done, {len(state.failed)} failed, {state.pending} pending"


def _is_store(path: Path) -> bool:
    return (path / ROOT).exists()


def _stores_below(folder: Path) -> Iterator[Path]:
    """Paths of the stores in a folder and its subfolders, but not behind links or hidden names."""
    for path in sorted(folder.iterdir()):
        with suppress(OSError):
            if _is_store(path):
                yield path
            elif path.is_dir() and not (path.is_symlink() or path.name.startswith(".")):
                yield from _stores_below(path)


def _listed(path: Path, name: str) -> list[object]:
    """Row of the table of stores for the store at `path`, or why it cannot be read."""
    try:
        state, sweep = states(path)
        return _row(name, state, sweep.preset)
    except StoreError as error:
        reason = str(error).split(";")[0].replace(str(path.absolute()), "").strip(": ")
        return [name, f"unreadable: {reason}", *[None] * (len(_HEADS) - 2)]


def _row(name: str, state: Summary, preset: str | None) -> list[object]:
    """Row of the table of stores: name, state, numbers of points, preset, title of one store."""
    words = "running now, " * bool(state.running)
    words += "done" if state.done == state.total else _counts(state)
    counts = state.total, state.done, len(state.failed), state.pending
    return [name, words, *counts, preset, state.title]


def verify(options: argparse.Namespace) -> Result:
    """Answer ``irg verify``: read all data of a store, and list damaged points."""
    with working("reading points") as progress:
        check = pipeline.verify_store(options.store, progress)
    text, rows, document = list[str](), list[tuple[object, ...]](), dict[str, object]()
    for kind, one in {"points": check, "tests": check.tests}.items():
        if one:
            document[kind] = {"done": one.done, "damaged": len(one.damaged)}
            text.append(f"{kind}: {one.done} done and undamaged, {len(one.damaged)} damaged")
            text += [f"damaged: {damage}" for damage in (*one.damaged, *one.shared)]
            rows += [(p.load, p.velocity, p.place, p.message) for p in one.damaged]
    frame = frame_of(("load [N]", "velocity [m/s]", "place", "message"), rows)
    document |= {"damaged": records([frame]), "shared": [*map(str, check.shared)]}
    if check.is_clean:
        return Result(document, text, pipeline.points_with_warnings(options.store), [frame])
    return Result(document, [*text, REMEDY], frames=[frame], code=SOME_FAILED)
