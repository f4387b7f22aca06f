"""The commands that look after stores: their state, their damage and their differences."""

from __future__ import annotations

import argparse
from collections.abc import Iterator
from contextlib import suppress
from datetime import datetime
from pathlib import Path
from stat import S_ISDIR
from typing import Any

import pipeline
from pipeline.analysis.at import open_inputs
from pipeline.analysis.tables import as_dict, frame_of, short
from pipeline.analysis.warned_points import NO_WARNING
from pipeline.cli.given import dataset_in
from pipeline.cli.output import DONE, SOME_FAILED, Result, failed_points, working
from pipeline.store.place import ROOT, StoreError, place_of, remedy
from pipeline.store.progress import summary
from pipeline.store.root import read_sweep
from pipeline.sweep.accuracy import error_in_words, velocity_error
from pipeline.sweep.conditions import PATHS

_MOST_POINTS = 10  # that are printed; files have all


def status(options: argparse.Namespace) -> Result:
    """Count the points of a store, or list the stores below a folder."""
    if _is_folder_of_stores(options.store):
        folder = Path(options.store)
        rows = [_row(store, folder) for store in _stores_below(folder)]
        frame = frame_of(_HEADS, ([row.get(head) for head in _HEADS] for row in rows))
        held = short(frame) if len(frame) else f"{options.store} holds none"
        return Result(as_dict(frame), [held])
    state = pipeline.summary(options.store)
    sweep = read_sweep(options.store)
    document = {
        "title": state.title,
        "points": state.total,
        "done": state.done,
        "failed": failed_points(state.failed),
        "pending": state.pending,
        "done_earlier": state.earlier,
        "running": state.running is not None,
        "velocity_error": velocity_error(sweep),
        "selection": sweep.about.selection and sweep.about.selection.as_dict(),
    }
    text = [
        state.title,
        f"{state.total} points: {state.done} done, {len(state.failed)} failed, "
        f"{state.pending} pending",
    ]
    if state.earlier:
        text.append(f"{state.earlier} more are done from an earlier run, which asked for them")
    if state.running:
        text.append(f"running: {state.running}")
    text += [error_in_words(sweep), *(f"failed: {point}" for point in state.failed)]
    try:
        warned = pipeline.warned(options.store)
    except StoreError as error:  # the points are counted all the same
        warned = NO_WARNING
        text.append(f"warnings are not counted: {error}")
    return Result(document, text, warned, code=SOME_FAILED if state.failed else DONE)


def _is_folder_of_stores(path: Path | str) -> bool:
    """True for a folder that neither is a store nor is named like one."""
    return (
        isinstance(path, Path)
        and path.is_dir()
        and path.suffix != ".zarr"
        and not (path / ROOT).exists()
    )


def verify(options: argparse.Namespace) -> Result:
    """Read everything and name what is damaged."""
    with working("reading points") as progress:
        check = pipeline.verify_store(options.store, progress)
    document = {
        "done": check.done,
        "damaged": failed_points(check.damaged),
        "shared": check.shared,
    }
    text = [
        f"{check.done} points are done and intact, {len(check.damaged)} are damaged",
        *(f"damaged: {damage}" for damage in (*check.damaged, *check.shared)),
    ]
    if check.is_clean:
        return Result(document, text, pipeline.warned(options.store))
    text.append(remedy(place_of(options.store)))
    return Result(document, text, code=SOME_FAILED)


def diff(options: argparse.Namespace) -> Result:
    """Print the differences between two stores."""
    paths = options.store, options.other
    taken = [
        {*map(str, ds.dims), *open_inputs(ds), *PATHS.values()}
        for ds in map(pipeline.open_sweep, paths)
    ]
    stores = [  # an entry that one store alone has is of that one
        dataset_in(options, path, without=others - own)
        for path, own, others in zip(paths, taken, reversed(taken), strict=True)
    ]
    between = pipeline.diff(*stores)
    entries, crossings, points = between.entries, between.boundary, between.points
    changes = points["change [%]"].dropna().abs()
    unlike = f" (by up to {changes.max():.2g} % of the rise)" if len(changes) else ""
    text = [
        *(f"A {options.store}", f"B {options.other}", ""),
        entries if len(entries) else "their scenes are equal",
        "",
        short(crossings)
        if len(crossings)
        else "no boundaries to compare: no common load, or no critical temperature",
        "",
        f"points: {between.alike} alike, {len(changes)} unlike{unlike}, "
        f"{len(points) - len(changes)} done in one alone",
    ]
    if len(points):
        text.append(short(points.head(_MOST_POINTS)))
    if len(points) > _MOST_POINTS:
        text.append(f"and {len(points) - _MOST_POINTS} more, which -o TABLE.csv writes")
    if len(points):
        text.append("rise: the highest of the contact at the end of the point, at friction 1")
    warned = sum((pipeline.warned(ds) for ds in stores), NO_WARNING)
    return Result(between.as_dict(), text, warned, [entries, crossings, points])


_HEADS = "name", "state", "preset", "changed", "size [MB]", "title"


def _stores_below(folder: Path) -> Iterator[Path]:
    """Stores below a folder, unopened, as far as it can be read."""
    for path in sorted(folder.iterdir()):
        if path.name.startswith("."):
            continue
        with suppress(OSError):
            if (path / ROOT).exists():
                yield path
            elif path.is_dir() and not path.is_symlink():
                yield from _stores_below(path)


def _row(path: Path, folder: Path) -> dict[str, Any]:
    """Values of a store by column."""
    stats = []
    for file in path.rglob("*"):
        with suppress(FileNotFoundError):  # a store may be in the midst of being written
            if not S_ISDIR((stat := file.lstat()).st_mode):  # not what a link leads to
                stats.append(stat)
    changed = datetime.fromtimestamp(max((stat.st_mtime for stat in stats), default=0.0))
    about = {"name": str(path.relative_to(folder)), "changed": f"{changed:%Y-%m-%d %H:%M}"}
    return _store_status(path) | about | {"size [MB]": sum(stat.st_size for stat in stats)}


def _store_status(path: Path) -> dict[str, Any]:
    """State of a store."""
    try:
        state, preset = summary(path), read_sweep(path).about.preset
    except StoreError as error:
        reason = str(error).split(";")[0].replace(str(path.absolute()), "").strip(": ")
        return {"state": f"unreadable: {reason}"}
    words = "done" if not state.pending else f"{state.done} of {state.total} done"
    if state.failed:
        words += f", {len(state.failed)} failed"
    if state.running:
        words += ", running now"
    return {"state": words, "preset": preset, "title": state.title}
