"""Scene files as text: TOML with the scene that it extends, and entries that override both.

Tables are merged key by key, lists and values replaced; ``without`` leaves entries out.
"""

from __future__ import annotations

import itertools
import json
import re
import tomllib
from collections.abc import Iterator, Mapping
from functools import reduce
from pathlib import Path
from typing import Any, NamedTuple

from pipeline.limits import MOST_BYTES_OF_TEXT
from pipeline.paths import read_file, reason_of
from pipeline.scene.entries import Entries, entry_at, flat, merged, replace_value
from pipeline.scene.faults import Fault, Faults, SceneFileError
from pipeline.scene.format import SceneFile
from pipeline.scene.tables import table_of
from pipeline.shipped import name_of, scene_path, shipped_scenes
from pipeline.words import did_you_mean, key_path, quoted

_KEYS = table_of(SceneFile).keys


class Layer(NamedTuple):
    """A file and its entries, as TOML reads them."""

    file: Path
    entries: dict[str, Any]


class Document(NamedTuple):
    """Entries of a scene in layers: overrides, the scene file, the files that it extends."""

    layers: tuple[Layer, ...]  # earlier ones override later ones

    @property
    def file(self) -> Path:
        """The scene file itself."""
        return self.layers[0].file

    def entries(self) -> dict[str, Any]:
        """Entries of all layers, merged."""
        return reduce(merged, (layer.entries for layer in reversed(self.layers)))

    def without(self, path: str) -> Document:
        """A new document without the entry at `path`."""
        return Document(
            tuple(
                Layer(one.file, replace_value(one.entries, path, None))
                if entry_at(one.entries, path) is not None
                else one
                for one in self.layers
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
        held = [entry_at(one.entries, fault.key) for one in self.layers]
        is_inherited = not fault.file and file != self.file and any(one is not None for one in held)
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
    document = Document((Layer(path, table),))
    if extends is None:
        if without is not None:
            faults.append(Fault("without", 'nothing to remove: "without" needs "extends"', path))
        return document
    name = _KEYS["extends"].kind.read(extends, "extends", wrong := Faults())
    if wrong:
        raise SceneFileError(path, [document.line(wrong[0])])
    other, chain = scene_path(name, path.parent), (*above, path)
    if any(other.resolve() == file.resolve() for file in chain):
        circle = " extends ".join(name_of(file) for file in (*chain, other))
        raise SceneFileError(
            path,
            [f"extends: {quoted(name)} refers back to itself: {circle}; remove one of these"],
        )
    try:
        base = read_document(other, faults, chain)
    except SceneFileError as error:
        raise SceneFileError(path, [f"extends: {error}"]) from error
    base = _leave_out(base, without, path, faults)
    if entry_at(table, "fidelity.preset") is not None:
        base = base.without("fidelity")
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
        document = document.without("fidelity")
    top = dict[str, Any]()
    for key, value in overrides.items():
        top = merged(top, replace_value({}, key, value))
    return _without_empty_tables(Document((Layer(document.file, top), *document.layers)), faults)


def _without_empty_tables(document: Document, faults: Faults) -> Document:
    """The document without empty tables over entries of lower layers; each is a fault."""
    layers = list[Layer]()
    for number, layer in enumerate(document.layers, 1):
        entries = layer.entries
        for path in [path for path, value in flat(entries) if value == {}]:
            if any(entry_at(lower.entries, path) for lower in document.layers[number:]):
                problem = "the table is empty; fill it or remove it"
                faults.append(Fault(path, problem, layer.file))
                entries = replace_value(entries, path, None)
        layers.append(Layer(layer.file, entries))
    return Document(tuple(layers))


def _leave_out(document: Document, value: Any, file: Path, faults: Faults) -> Document:
    """The document without the entries listed in `value`, the list ``without`` of `file`."""
    wrong, entries = Faults(), document.entries()
    keys = [] if value is None else _KEYS["without"].kind.read(value, "without", wrong) or []
    for index, key in enumerate(keys):
        if entry_at(entries, key) is None:
            hint = did_you_mean(key, [*entries, *(path for path, _ in flat(entries))])
            problem = (
                f"is not an entry of {name_of(document.file)}{hint}; name one that exists there"
            )
            wrong.refuse(f"without[{index}]", f"{quoted(key)} {problem}")
        document = document.without(key)
    faults += [fault._replace(file=file) for fault in wrong]
    return document


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
            reason += near or "; give a scene file, or a shipped scene (irg new --list)"
        raise SceneFileError(path, [f"cannot be read: {reason}"]) from error
    try:
        return tomllib.loads(content.decode("utf-8-sig"))
    except UnicodeDecodeError as error:
        line = content.count(b"\n", 0, error.start) + 1
        fault = f"line {line} is not UTF-8; save the file in that encoding"
        raise SceneFileError(path, [fault]) from error
    except (ValueError, RecursionError) as error:
        raise SceneFileError(path, [f"is not valid TOML: {error}"]) from error


def text_of(tables: Entries) -> str:
    """Write merged tables as a scene file for people."""
    return "\n".join(_lines(tables, "")).strip() + "\n"


def _lines(tables: Entries, above: str) -> Iterator[str]:
    inner = {key: one for key, one in tables.items() if isinstance(one, dict) and one}
    yield from (f"{key_path('', k)} = {_value(v)}" for k, v in tables.items() if k not in inner)
    for key, table in inner.items():
        place = key_path(above, key)
        head = [] if all(isinstance(one, dict) for one in table.values()) else ["", f"[{place}]"]
        yield from (*head, *_lines(table, place))


def _value(value: Any) -> str:
    match value:
        case dict():
            items = (f"{key_path('', key)} = {_value(one)}" for key, one in value.items())
            return f"{{ {', '.join(items)} }}"
        case list() if value and isinstance(value[0], dict):  # a test or a row in each line
            return "\n".join(["[", *(f"  {_value(one)}," for one in value), "]"])
        case list():
            return f"[{', '.join(map(_value, value))}]"
        case float():
            return short if float(short := f"{value:g}") == value else repr(value)
    return json.dumps(value, ensure_ascii=False, default=str)
