"""Scene files as text: TOML with the scene that it extends, and entries that override both.

Tables are merged key by key, lists and values replaced; ``without`` leaves entries out.
"""

from __future__ import annotations

import itertools
import json
import re
import tomllib
from collections.abc import Iterator, Mapping
from contextlib import suppress
from pathlib import Path
from typing import Any, NamedTuple

from pipeline.limits import MAX_HINTS
from pipeline.messages import did_you_mean, key_path, quoted
from pipeline.paths import read_file, reason_of
from pipeline.scene.declared_tables import table_of
from pipeline.scene.entries import (
    MAX_LEVELS,
    Entries,
    entry_at,
    flat,
    is_within,
    merged,
    replace_value,
    too_deep_key,
)
from pipeline.scene.faults import Fault, Faults, SceneFileError, TooManyFaultsError
from pipeline.scene.format import SceneFile
from pipeline.shipped import name_of, scene_path, shipped_scenes

_KEYS = table_of(SceneFile).keys
_STRING_OR_COMMENT = re.compile(
    r'''"""(?:\\.|[^"\\]|"(?!""))*+"{0,5}|"(?:\\.|[^"\\\n])*+"?'''
    r"""|'{3}.*?(?:'{3,5}|\Z)|'[^'\n]*+'?|\#[^\n]*+""",
    re.DOTALL,
)
"""A string, to its end or that of the line or file, or a comment."""
_LONG_KEY = re.compile(rf'(?<![\w-])(?:(?:[\w-]++|"")[ \t]*+\.[ \t]*+){{{2 * MAX_LEVELS}}}')
"""A dotted key of so many parts that the parser may take minutes; its strings are empty."""
_TOO_DEEP = f"lists or tables are nested too deep; an entry has {MAX_LEVELS} levels at most"


class Document(NamedTuple):
    """Entries of a scene, and the file that gave each of them: the scene's or one it extends."""

    file: Path
    entries: dict[str, Any]
    files: dict[str, Path]  # by path, also those of tables

    def under(self, file: Path, entries: dict[str, Any], faults: Faults) -> Document:
        """The document overridden by the entries of a file.

        Empty tables over entries of the document are added to `faults`, and left out.
        """
        for path, value in [*flat(entries)]:
            if value == {} and entry_at(self.entries, path):
                faults.append(Fault(path, "the table is empty; fill it or remove it", file))
                entries = replace_value(entries, path, None)
        paths = (table_path for path, _ in flat(entries) for table_path in _with_tables(path))
        files = self.files | dict.fromkeys(paths, file)
        return Document(file, merged(self.entries, entries), files)

    def without(self, path: str) -> Document:
        """A new document without the entry at `path`."""
        files = {key: file for key, file in self.files.items() if not is_within(key, path)}
        return Document(self.file, replace_value(self.entries, path, None), files)

    def file_of(self, key: str) -> Path:
        """The file that sets the entry at a key path, or else the table that contains it."""
        paths = _with_tables(re.sub(r"\[\d+\]", "", key))
        return next((self.files[path] for path in paths[::-1] if path in self.files), self.file)

    def line(self, fault: Fault) -> str:
        """Write a fault on one line, with its file unless it is the scene file itself."""
        file = fault.file or self.file_of(fault.key)
        has_entry = entry_at(self.entries, fault.key) is not None
        is_inherited = not fault.file and file != self.file and has_entry
        hint = f'; or leave it out here: without = ["{fault.key}"]' if is_inherited else ""
        location = "" if file == self.file else f" (in {name_of(file)})"
        return f"{fault.key}{location}: {fault.problem}{hint}"


def _with_tables(path: str) -> list[str]:
    """Paths of the tables that contain an entry, the outermost first, and of the entry."""
    return [*itertools.accumulate(path.split("."), "{}.{}".format)]


def read_document(path: Path, faults: Faults, extending: tuple[Path, ...] = ()) -> Document:
    """Read a scene file and the files that it extends.

    If the file sets ``fidelity.preset``, the other files' ``[fidelity]`` is left out. `extending`
    are the files that extend the file at `path`. Wrong paths in ``without`` are added to `faults`.
    `SceneFileError` is raised if a file cannot be read.
    """
    # A megabyte is parsed in half a second.
    table = _toml(path, 1_000_000 - sum(file.stat().st_size for file in extending))
    extends, without = table.pop("extends", None), table.pop("without", None)
    document = Document(path, {}, {}).under(path, table, faults)
    if extends is None:
        if without is not None:
            faults.append(Fault("without", 'nothing to remove: "without" needs "extends"', path))
        return document
    name = _KEYS["extends"].kind.read(extends, "extends", extends_faults := Faults())
    if extends_faults:
        raise SceneFileError(path, [document.line(extends_faults[0])])
    base_path, chain = scene_path(name, path.parent), (*extending, path)
    if len(chain) > 20:
        raise SceneFileError(
            path, [f"extends: {len(chain)} scenes extend one another; at most 20 may"]
        )
    if any(_is_same(base_path, file) for file in chain):
        circle = " extends ".join(name_of(file) for file in (*chain, base_path))
        raise SceneFileError(
            path,
            [f"extends: {quoted(name)} refers back to itself: {circle}; remove one of these"],
        )
    try:
        base = read_document(base_path, faults, chain)
    except SceneFileError as error:
        raise SceneFileError(path, [f"extends: {error}"]) from error
    base = _leave_out(base, without, path, faults)
    if entry_at(table, "fidelity.preset") is not None:
        base = base.without("fidelity")
    return base.under(path, table, faults)


def override_entries(document: Document, overrides: Mapping[str, Any], faults: Faults) -> Document:
    """Return a document with entries set to `overrides`, values by key path such as "pin.radius".

    Entries that `overrides` lists under ``without`` are removed first, and with a new
    ``fidelity.preset`` the whole table ``[fidelity]``.
    """
    overrides = dict(overrides)
    without = overrides.pop("without", None)
    paths = [without] if isinstance(without, str) else without
    document = _leave_out(document, paths, document.file, faults)
    if "fidelity.preset" in overrides:
        document = document.without("fidelity")
    for key, value in overrides.items():
        document = document.under(document.file, replace_value({}, key, value), faults)
    return document


def _leave_out(document: Document, value: Any, file: Path, faults: Faults) -> Document:
    """The document without the entries listed in `value`, the list ``without`` of `file`."""
    without_faults, entries = Faults(), document.entries
    with suppress(TooManyFaultsError):
        keys = (
            []
            if value is None
            else _KEYS["without"].kind.read(value, "without", without_faults) or []
        )
        for index, key in enumerate(keys):
            if entry_at(entries, key) is None:
                names = [*entries, *(path for path, _ in flat(entries))]
                hint = did_you_mean(key, names) if len(without_faults) < MAX_HINTS else ""
                without_faults.refuse(
                    f"without[{index}]",
                    f"{quoted(key)} is not an entry of {name_of(document.file)}{hint}; name one "
                    "that exists there",
                )
            document = document.without(key)
    faults += [fault._replace(file=file) for fault in without_faults]
    return document


def _toml(path: Path, max_bytes: int) -> dict[str, Any]:
    """Read one TOML file; raise `SceneFileError` if that fails."""
    try:
        if path.exists() and not path.is_file():
            kind = "a store" if (path / "zarr.json").exists() else "not a file"
            raise SceneFileError(path, [f"cannot be read: {kind}; give a scene file (TOML)"])
        content = read_file(path, max_bytes)
    except (OSError, ValueError) as error:
        reason = reason_of(error, path) if isinstance(error, OSError) else str(error)
        if isinstance(error, FileNotFoundError) and not reason.endswith(")"):
            hint = did_you_mean(path.stem, shipped_scenes())
            reason += hint or "; give a scene file, or a shipped scene (irg new --list)"
        raise SceneFileError(path, [f"cannot be read: {reason}"]) from error
    try:
        text = content.decode("utf-8-sig")
        without_strings = _STRING_OR_COMMENT.sub(_emptied, text)
        if long_key := _LONG_KEY.search(without_strings):
            line = without_strings.count("\n", 0, long_key.start()) + 1
            fault = f"line {line}: a key has too many parts; an entry has {MAX_LEVELS} at most"
            raise SceneFileError(path, [fault])
        max_parts = 100_000  # each is a table of 1 kB at worst
        if (count := sum(map(without_strings.count, ".["))) > max_parts:
            fault = f"has {count} points and brackets; at most {max_parts} are read"
            raise SceneFileError(path, [fault])
        tables, max_entries = tomllib.loads(text), 10_000  # materials have six each
        if (count := sum(1 for _ in flat(tables))) > max_entries:
            fault = f"has {count} entries outside of lists; at most {max_entries} are read"
            raise SceneFileError(path, [fault])
        if key := too_deep_key(tables):
            raise SceneFileError(path, [f"{key}: {_TOO_DEEP}"])
        return tables
    except UnicodeDecodeError as error:
        line = content.count(b"\n", 0, error.start) + 1
        fault = f"line {line} is not UTF-8; save the file in that encoding"
        raise SceneFileError(path, [fault]) from error
    except RecursionError as error:
        raise SceneFileError(path, [_TOO_DEEP]) from error
    except tomllib.TOMLDecodeError as error:
        raise SceneFileError(path, [f"is not valid TOML: {error}"]) from error
    except ValueError as error:  # Python reads whole numbers of 4300 digits at most
        fault = "a whole number has thousands of digits; give one below 2^63"
        raise SceneFileError(path, [fault]) from error


def _emptied(match: re.Match[str]) -> str:
    """An empty string in place of a string or comment, with as many lines."""
    return '""' + "\n" * match[0].count("\n")


def _is_same(first: Path, second: Path) -> bool:
    """True if both paths are of one file; False if one cannot be found."""
    try:
        return first.samefile(second)
    except OSError:
        return False


def text_of(tables: Entries) -> str:
    """Write merged tables as a scene file for people."""
    return "\n".join(_table_lines(tables, "")).strip() + "\n"


def _table_lines(table: Entries, table_path: str) -> Iterator[str]:
    """Yield the lines of the values of a table, and then those of the tables in it."""
    tables = {key: value for key, value in table.items() if isinstance(value, dict) and value}
    for key, value in table.items():
        if key not in tables:
            yield f"{key_path('', key)} = {_value_text(value)}"
    for key, inner_table in tables.items():
        path = key_path(table_path, key)
        if not all(isinstance(value, dict) for value in inner_table.values()):
            yield from ("", f"[{path}]")
        yield from _table_lines(inner_table, path)


def _value_text(value: Any) -> str:
    match value:
        case dict():
            items = (f"{key_path('', key)} = {_value_text(item)}" for key, item in value.items())
            return f"{{ {', '.join(items)} }}"
        case list() if value and isinstance(value[0], dict):  # a test or a row in each line
            return "\n".join(["[", *(f"  {_value_text(item)}," for item in value), "]"])
        case list():
            return f"[{', '.join(map(_value_text, value))}]"
        case float():
            return short if float(short := f"{value:g}") == value else repr(value)
    return json.dumps(value, ensure_ascii=False, default=str)
