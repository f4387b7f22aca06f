"""Stores and scenes of a folder, as a table."""

from __future__ import annotations

import tomllib
from collections.abc import Iterator
from contextlib import suppress
from datetime import datetime
from pathlib import Path
from typing import Any

import pandas as pd

from pipeline.analysis.tables import frame_of
from pipeline.store.place import ROOT, StoreError
from pipeline.store.progress import summary
from pipeline.store.root import read_attributes

_HEADS = "name", "kind", "state", "preset", "changed", "size [MB]", "title"


def listing(folder: Path) -> pd.DataFrame:
    """Stores and scenes below a folder, a row each; no code that they name is run."""
    rows = [row for entry in _stores_and_scenes(folder) if (row := _row(entry, folder))]
    return frame_of(_HEADS, ([row.get(head) for head in _HEADS] for row in rows))


def _stores_and_scenes(folder: Path) -> Iterator[Path]:
    """Stores below a folder, without a look into them, and files that may be scenes."""
    for path in sorted(folder.iterdir()):
        if path.name.startswith("."):
            continue
        if (path / ROOT).exists() or (path.is_file() and path.suffix == ".toml"):
            yield path
        elif path.is_dir() and not path.is_symlink():
            yield from _stores_and_scenes(path)


def _row(path: Path, folder: Path) -> dict[str, Any] | None:
    """Values of a store or scene by column; None for a file that is no scene."""
    row = _of_store(path) if path.is_dir() else _of_scene(path)
    if row is None:
        return None
    stats = []
    for file in [path] if path.is_file() else path.rglob("*"):
        with suppress(FileNotFoundError):  # of a store that is being written
            if not file.is_dir():
                stats.append(file.stat())
    changed = datetime.fromtimestamp(max((stat.st_mtime for stat in stats), default=0.0))
    about = {"name": str(path.relative_to(folder)), "changed": f"{changed:%Y-%m-%d %H:%M}"}
    return row | about | {"size [MB]": sum(stat.st_size for stat in stats)}


def _of_store(path: Path) -> dict[str, Any]:
    """State of a store."""
    try:
        state, preset = summary(path), (read_attributes(path) or {}).get("preset")
    except StoreError as error:
        reason = str(error).split(";")[0].replace(str(path.absolute()), "").strip(": ")
        return {"kind": "store", "state": f"unreadable: {reason}"}
    words = "done" if not state.pending else f"{state.done} of {state.total} done"
    if state.failed:
        words += f", {len(state.failed)} failed"
    if state.running:
        words += ", running now"
    return {"kind": "store", "state": words, "preset": preset, "title": state.title}


def _of_scene(path: Path) -> dict[str, Any] | None:
    """What a scene says of itself; None if the file is none."""
    try:
        tables = tomllib.loads(path.read_text(encoding="utf-8"))
    except (OSError, ValueError, RecursionError):
        return {"kind": "scene", "state": "unreadable"}
    if not {"extends", "sweep"} & tables.keys():
        return None
    base = tables.get("extends")
    title = tables.get("title", f"extends {base}" if base else None)
    return {"kind": "scene", "title": title}
