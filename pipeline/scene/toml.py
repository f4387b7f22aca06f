"""Scene files as text: TOML with the scene that it extends, and entries that override both.

Tables are merged key by key, lists and values replaced; ``without`` leaves entries out.
"""

from __future__ import annotations

import json
import re
import tomllib
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Any

from pipeline.faults import Fault, SceneFileError
from pipeline.messages import did_you_mean, key_path, quoted
from pipeline.paths import is_binary, is_workbook, read_file, reason_of, workbook_problem
from pipeline.scene.entries import Entries, entry_at, flat, merged, replace_value
from pipeline.shipped import name_of, scene_path, shipped_scenes

FILES = ("disk.roughness.file", "loading.file", "sweep.along", "tests")
"""Entries that may name a file, relative to the folder of the scene that sets them."""
_MAX_BYTES = 200_000  # of a scene; those that come with the program have 3000
_LONG_KEY = re.compile(
    r"""(?<![\w"'-])(?:(?:[\w-]++|"(?:\\.|[^"\\\n])*+"|'[^'\n]*+')[ \t]*+\.[ \t]*+){20}"""
)
"""A dotted key of 20 parts: time and memory of the parser grow with the square of this number."""
_A_SCENE = "a scene is a text file (TOML), as irg new scene.toml writes it"
_MAX_CHAIN = 20  # scenes that extend one another


@dataclass(frozen=True)
class Document:
    """Entries of a scene and of the scenes that it extends, merged.

    `of_file` are the entries of the scene itself, and `base` is the scene that supplies all others.
    `folders` has the folder of the file that sets each of `FILES`.
    """

    file: Path
    entries: Entries = field(default_factory=dict)
    of_file: Entries = field(default_factory=dict)
    folders: Mapping[str, Path] = field(default_factory=dict)
    base: Path | None = None

    def under(self, entries: Entries) -> Document:
        """The document with further entries of its file, which replace those that it has."""
        folders = {path: self.file.parent for path in FILES if entry_at(entries, path)}
        return replace(
            self,
            entries=merged(self.entries, entries),
            of_file=merged(self.of_file, entries),
            folders={**self.folders, **folders},
        )

    def without(self, paths: object) -> Document:
        """The document without the entries at `paths`; a `SceneFileError` if one is not there."""
        listed = [] if paths is None else paths if isinstance(paths, list) else [paths]
        entries = self.entries
        for path in listed:
            if not isinstance(path, str) or entry_at(self.entries, path) is None:
                names = [*self.entries, *(name for name, _ in flat(self.entries))]
                problem = f"{quoted(path)} is not an entry of {name_of(self.base or self.file)}"
                hint = did_you_mean(str(path), names)
                fault = f"without: {problem}{hint}; name one that exists there"
                raise SceneFileError(self.file, [fault])
            entries = replace_value(entries, path, None)
        return replace(self, entries=entries)

    def line(self, fault: Fault) -> str:
        """Write a fault on one line, and where the entry is inherited from."""
        key = re.sub(r"\[\d+\]", "", fault.key)
        is_inherited = (
            entry_at(self.entries, key) is not None and entry_at(self.of_file, key) is None
        )
        if self.base is None or not is_inherited:
            return f"{fault.key}: {fault.problem}"
        return (
            f"{fault.key} (from {name_of(self.base)}): {fault.problem}; or leave it out here: "
            f'without = ["{key}"]'
        )


def read_document(path: Path, extending: Sequence[Path] = ()) -> Document:
    """Read a scene file and the files that it extends.

    If the file sets ``fidelity.preset``, the other files' ``[fidelity]`` is left out. `extending`
    are the files that extend the file at `path`. `SceneFileError` is raised if a file cannot be
    read.
    """
    table = _toml(path)
    extends, without = table.pop("extends", None), table.pop("without", None)
    if extends is None:
        if without is not None:
            fault = 'without: nothing to remove: "without" needs "extends"; add it'
            raise SceneFileError(path, [fault])
        return Document(path).under(table)
    chain = (*extending, path)
    if not isinstance(extends, str) or not extends:
        fault = f"extends: {quoted(extends)} is not text; give the name or path of a scene"
        raise SceneFileError(path, [fault])
    base_path = scene_path(extends, path.parent)
    if len(chain) > _MAX_CHAIN or base_path.resolve() in [file.resolve() for file in chain]:
        names = " extends ".join(map(name_of, (*chain[:4], base_path)))
        fault = f"extends: {names}; a scene may not extend itself, and at most {_MAX_CHAIN} others"
        raise SceneFileError(path, [fault])
    try:
        base = read_document(base_path, chain)
    except SceneFileError as error:
        raise SceneFileError(path, [f"extends: {error}"]) from error
    document = replace(base, file=path, of_file={}, base=base_path).without(without)
    return override(document, table)


def override(document: Document, table: Entries) -> Document:
    """The document with the entries of a table; a new preset replaces all numerical settings."""
    if entry_at(table, "fidelity.preset") is not None:
        document = replace(document, entries=replace_value(document.entries, "fidelity", None))
    return document.under(table)


def _toml(path: Path) -> dict[str, Any]:
    """Read one TOML file; raise `SceneFileError` if that fails."""
    try:
        content = read_file(path, _MAX_BYTES)
    except (OSError, ValueError) as error:
        reason = reason_of(error, path) if isinstance(error, OSError) else str(error)
        hint = did_you_mean(path.stem, shipped_scenes())
        advice = hint or "; give a scene file (TOML), or a shipped scene (irg new --list)"
        raise SceneFileError(path, [f"cannot be read: {reason}{advice}"]) from error
    if problem := _other_kind(path, content):
        raise SceneFileError(path, [f"{problem}; {_A_SCENE}"])
    try:
        text = content.decode("utf-8-sig")
        if key := _LONG_KEY.search(text):
            raise ValueError(f"more than 20 parts are joined by points: {quoted(key[0][:40])}")
        tables = tomllib.loads(text)
    except RecursionError as error:
        raise SceneFileError(path, ["lists are nested too deeply; correct it"]) from error
    except ValueError as error:  # also text that is not UTF-8
        fault = _slip(str(error), content) or f"is not valid TOML in UTF-8: {error}; correct it"
        raise SceneFileError(path, [fault]) from error
    if empty := next((entry for entry, value in flat(tables) if value == {}), None):
        raise SceneFileError(path, [f"{empty}: the table is empty; fill it or remove it"])
    return tables


def _other_kind(path: Path, content: bytes) -> str:
    """What a file is that is no scene, such as a table; empty if it may be a scene."""
    if is_workbook(path, content):
        return f"is {workbook_problem(path)} in a scene"
    if path.suffix.lower() in (".csv", ".tsv"):
        name = quoted(path.name)
        return f"is a table; name it in a scene: file = {name} in [[tests]], or along in [sweep]"
    return "is binary" if is_binary(content) else ""


def _slip(error: str, content: bytes) -> str:
    """The fault of a common slip in TOML, and what to write; empty if the `error` is another."""
    match = re.search(r"^(.*) \(at (?:line (\d+), column (\d+)|end of document)\)$", error)
    if match is None:
        return ""
    words, lines = match[1], content.decode("utf-8-sig").splitlines() or [""]
    number = int(match[2] or len(lines))
    line, column = lines[min(number, len(lines)) - 1], int(match[3] or 0)
    before = "\n".join([*lines[: number - 1], line[: max(column - 1, 0)]])
    is_in_braces = re.search(r"=\s*\{[^{}]*$", before) is not None
    if "hex value" in words or "Unescaped" in words:
        return f"line {number}: a backslash begins an escape; write / or put the text in '...'"
    if re.match("Illegal character|Unterminated|Expected \"'", words):
        return f"line {number}: a quote is not closed; write it at the end of the text"
    if table := re.search(r"Cannot (?:declare|mutate immutable namespace) \((.*?),?\)", words):
        name = ".".join(re.findall(r"'([^']*)'", table[1]))
        return f"line {number}: [{name}] occurs twice; write its entries below the first"
    if "Cannot overwrite" in words:
        return f"line {number}: the entry occurs twice; keep one"
    if is_in_braces and ("key part" in words or "Unclosed inline table" in words):
        return f"line {number}: a table in braces stands on one line, without a comma at its end"
    if re.search(r"\d$", line[: max(column - 1, 0)]) and line[column - 1 : column] == ",":
        return f"line {number}: a number has a comma; write decimals with a point"
    is_word = re.match(r"\s*[^\W\d]", line[max(column - 1, 0) :])
    if is_word and (words == "Invalid value" or words.startswith("Expected newline")):
        return f'line {number}: put text in quotes, such as "first_try" or "2 mm"'
    if words.startswith("Expected '='"):
        return f"line {number}: write = between a key and its value"
    if "Unclosed array" in words:
        return f"line {number}: a list has a comma between its values, and ] at its end"
    return ""


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
