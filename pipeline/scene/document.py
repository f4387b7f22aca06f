"""TOML documents: a scene file, the scene that it extends, and entries that override both.

Tables are merged key by key, lists and values replaced; ``without`` leaves entries out. A slip of
TOML is explained by the line that has it.
"""

from __future__ import annotations

import itertools
import json
import re
import tomllib
from collections.abc import Callable, Mapping
from functools import reduce
from pathlib import Path
from typing import Any, NamedTuple

from pipeline.paths import read_file, reason_of
from pipeline.scene.declare import table_of
from pipeline.scene.faults import Fault, Faults, SceneFileError, did_you_mean, quoted
from pipeline.scene.format import SceneFile
from pipeline.scene.shipped import name_of, scene_path, shipped_scenes
from pipeline.sweep.limits import MOST_BYTES_OF_TEXT
from pipeline.sweep.model import Sweep
from pipeline.sweep.tables import entry_at, flat, replace_value, replace_values

Extend = Callable[[Sweep], Sweep]
"""Function that adds to a sweep the variants that its scene names."""
_KEYS = table_of(SceneFile).keys
_REPLACED = {"count": "step", "step": "count"}
"""Keys of a range that replace each other in a scene that extends another."""
_LEVELS = 10  # depth of tables in tables, more than the format has
_BARE_KEY = re.compile("[A-Za-z0-9_-]+")


class FileEntries(NamedTuple):
    """A file and its entries, as TOML reads them."""

    file: Path
    entries: dict[str, Any]


class Document(NamedTuple):
    """Entries of a scene in layers; earlier layers override later ones.

    A layer is a scene file, a file that it extends, or a set of overrides or defaults.
    """

    layers: tuple[FileEntries, ...]

    @property
    def file(self) -> Path:
        """The scene file itself."""
        return self.layers[0].file

    def entries(self) -> dict[str, Any]:
        """Entries of all layers, merged; earlier layers override later ones."""
        return reduce(_merged, (layer.entries for layer in reversed(self.layers)))

    def defaulted(self, entries: Mapping[str, Any]) -> Document:
        """A new document with default values, `entries` by path, which all layers override."""
        return Document((*self.layers, FileEntries(self.file, replace_values({}, entries))))

    def replaced(self, path: str, value: Any) -> Document:
        """A new document in which each layer that has the entry at `path` has `value` there.

        If `value` is None, the entry is removed from these layers. A layer is a scene file, a file
        that it extends, or a set of overrides or defaults.
        """
        return Document(
            tuple(
                layer
                if entry_at(layer.entries, path) is None
                else FileEntries(layer.file, replace_value(layer.entries, path, value))
                for layer in self.layers
            )
        )

    def file_of(self, key: str) -> Path:
        """The file that sets the entry at a key path, or else sets the table around the entry."""
        parts = re.sub(r"\[\d+\]", "", key).split(".")
        paths = [*itertools.accumulate(parts, "{}.{}".format)]
        held = [sum(entry_at(one.entries, p) is not None for p in paths) for one in self.layers]
        return self.layers[held.index(max(held))].file

    def line(self, fault: Fault) -> str:
        """Write a fault on one line, with its file unless it is the scene file itself."""
        file = fault.file or self.file_of(fault.key)
        is_inherited = not fault.file and file != self.file
        hint = f'; or leave it out here: without = ["{fault.key}"]' if is_inherited else ""
        place = "" if file == self.file else f" (in {name_of(file)})"
        return f"{fault.key}{place}: {fault.problem}{hint}"


def read_document(path: Path, faults: Faults, above: tuple[Path, ...] = ()) -> Document:
    """Read a scene file and the files that it extends.

    If the file sets ``fidelity.preset``, the other files' ``[fidelity]`` is left out. `above` are
    the files that extend the file at `path`. Wrong paths in ``without`` are added to `faults`.
    `SceneFileError` is raised if a file cannot be read.
    """
    table = _toml(path)
    extends, without = table.pop("extends", None), table.pop("without", None)
    document = Document((FileEntries(path, table),))
    if extends is None:
        if without is not None:
            faults.append(Fault("without", "there is nothing to leave out; give extends too", path))
        return document
    name = _KEYS["extends"].kind.read(extends, "extends", wrong := Faults())
    if wrong:
        raise SceneFileError(path, [document.line(wrong[0])])
    other, chain = scene_path(name, path.parent), (*above, path)
    if any(other.resolve() == file.resolve() for file in chain):
        circle = " extends ".join(name_of(file) for file in (*chain, other))
        raise SceneFileError(
            path, [f"extends: {quoted(name)} closes a circle: {circle}; break it at one of them"]
        )
    try:
        base = read_document(other, faults, chain)
    except SceneFileError as error:
        raise SceneFileError(path, [f"extends: {error}"]) from error
    base = _leave_out(base, without, path, faults)
    if entry_at(table, "fidelity.preset") is not None:
        base = base.replaced("fidelity", None)
    return Document((*document.layers, *base.layers))


def override_entries(document: Document, overrides: Mapping[str, Any], faults: Faults) -> Document:
    """Return a document with entries set to `overrides`, values by key path such as "pin.radius".

    Entries that `overrides` lists under ``without`` are removed first, and with a new
    ``fidelity.preset`` the whole table ``[fidelity]``.
    """
    overrides = dict(overrides)
    without = overrides.pop("without", None)
    listed = [without] if isinstance(without, str) else without
    document = _leave_out(document, listed, document.file, faults)
    if "fidelity.preset" in overrides:
        document = document.replaced("fidelity", None)
    top = dict[str, Any]()
    for key, value in overrides.items():
        top = _merged(top, replace_value({}, key, value))
    return Document((FileEntries(document.file, top), *document.layers))


def without_empty_tables(document: Document, faults: Faults) -> Document:
    """The document without empty tables over entries of lower layers; each is a fault."""
    layers = list[FileEntries]()
    for number, layer in enumerate(document.layers, 1):
        entries = layer.entries
        for path in [path for path, value in flat(entries) if value == {}]:
            if any(entry_at(lower.entries, path) for lower in document.layers[number:]):
                problem = "an empty table changes nothing; give its entries, or leave it out"
                faults.append(Fault(path, problem, layer.file))
                entries = replace_value(entries, path, None)
        layers.append(FileEntries(layer.file, entries))
    return Document(tuple(layers))


def _leave_out(document: Document, value: Any, file: Path, faults: Faults) -> Document:
    """The document without the entries listed in `value`, the list ``without`` of `file`."""
    wrong, entries = Faults(), document.entries()
    keys = [] if value is None else _KEYS["without"].kind.read(value, "without", wrong) or []
    for index, key in enumerate(keys):
        if entry_at(entries, key) is None:
            hint = did_you_mean(key, [*entries, *(path for path, _ in flat(entries))])
            problem = f"is not an entry of {name_of(document.file)}{hint}; give one that it has"
            wrong.refuse(f"without[{index}]", f"{quoted(key)} {problem}")
        document = document.replaced(key, None)
    faults += [fault._replace(file=file) for fault in wrong]
    return document


def _merged(lower: dict[str, Any], upper: dict[str, Any], levels: int = _LEVELS) -> dict[str, Any]:
    """Merge tables key by key, `levels` deep; values of `upper` replace values of `lower`."""
    replaced = {_REPLACED.get(key) for key in upper}
    merged = {key: value for key, value in lower.items() if key not in replaced}
    for key, value in upper.items():
        both = levels and isinstance(value, dict) and isinstance(lower.get(key), dict)
        merged[key] = _merged(lower[key], value, levels - 1) if both else value
    return merged


def as_toml(value: Any) -> str:
    """Write a value as TOML."""
    match value:
        case dict():
            keys = (key if _BARE_KEY.fullmatch(key) else as_toml(key) for key in value)
            items = map(" = ".join, zip(keys, map(as_toml, value.values()), strict=True))
            return f"{{ {', '.join(items)} }}"
        case list():
            return f"[{', '.join(map(as_toml, value))}]"
        case float():
            return short if float(short := f"{value:g}") == value else repr(value)
    return json.dumps(value, ensure_ascii=False, default=str)


def _toml(path: Path) -> dict[str, Any]:
    """Read one TOML file; raise `SceneFileError` if that fails."""
    try:
        if path.exists() and not path.is_file():
            what = "a store" if (path / "zarr.json").exists() else "not a file"
            raise SceneFileError(path, [f"cannot be read: {what}; give a scene file (TOML)"])
        content = read_file(path, MOST_BYTES_OF_TEXT)
    except (OSError, ValueError) as error:
        reason = reason_of(error, path) if isinstance(error, OSError) else str(error)
        if isinstance(error, FileNotFoundError) and not reason.endswith(")"):
            near = did_you_mean(path.stem, shipped_scenes())
            reason += near or "; give a scene file, or a shipped scene that irg new --list names"
        raise SceneFileError(path, [f"cannot be read: {reason}"]) from error
    try:
        return tomllib.loads(content.decode("utf-8-sig"))
    except UnicodeDecodeError as error:
        line = content.count(b"\n", 0, error.start) + 1
        fault = f"line {line} is not UTF-8; save the file in that encoding"
        raise SceneFileError(path, [fault]) from error
    except (ValueError, RecursionError) as error:
        raise SceneFileError(path, [f"is not valid TOML: {error}"]) from error
