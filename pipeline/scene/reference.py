"""Made from the format of scenes: its tables and keys by path, and new scene files."""

from __future__ import annotations

import itertools
import re
import shutil
import tomllib
from collections.abc import Iterator, Mapping
from importlib import resources
from pathlib import Path
from typing import Any, NamedTuple

import tribo
from pipeline.paths import reason_of, user_path
from pipeline.scene.declare import Either, Entry, List, Range, Table, Tables, table_of
from pipeline.scene.document import as_toml
from pipeline.scene.faults import did_you_mean
from pipeline.scene.format import SceneFile
from pipeline.scene.kinds import Flag, Kind, Number, OneOf, Quantity, UnitText, Whole
from pipeline.scene.shipped import shipped_scenes
from pipeline.sweep.tables import entry_at
from tribo import InputError


class Section(NamedTuple):
    """A table of the scene format: its path, and `entry`, the declaration of what it may contain.

    The path of the top of the file is empty.
    """

    path: str
    entry: Entry

    @property
    def is_list(self) -> bool:
        """True if a file may have several such tables, under double brackets."""
        return isinstance(self.entry.kind, List)

    @property
    def header(self) -> str:
        """Line that begins the table in a scene file, such as "[pin]" or "[[measured]]"."""
        return f"[[{self.path}]]" if self.is_list else f"[{self.path}]"

    def keys(self) -> dict[str, tuple[Entry, str]]:
        """Keys of the section that hold values: for each, its declaration and a table's name.

        Some sections allow one of several tables, such as a random or a measured surface. The name
        tells which of these tables has the key. It is empty if all of them have the key.
        """
        forms = forms_of(self.entry.kind)
        keys: dict[str, tuple[Entry, str]] = {}
        for table in forms:
            for key, entry in table.listed.items():
                if not forms_of(entry.kind):
                    everywhere = all(key in other.keys for other in forms)
                    keys.setdefault(key, (entry, "" if everywhere else table.form))
        return keys

    def path_of(self, key: str) -> str:
        """Path of a key of this table, from the top of the file."""
        return f"{self.path}.{key}" if self.path else key


_SCENE = Entry(table_of(SceneFile), "The file itself, above its first table.", is_needed=True)


def sections(entry: Entry = _SCENE, path: str = "") -> Iterator[Section]:
    """All tables of the scene format at and within an `entry`, outer tables first.

    `path` is the path of the entry. By default the entry is the whole file.
    """
    if isinstance(entry.kind, Tables):
        path += ".NAME"
    section = Section(path, entry)
    yield section
    inner = {k: e for form in forms_of(entry.kind) for k, e in form.keys.items()}
    for key in inner:
        if forms_of(inner[key].kind):
            yield from sections(inner[key], section.path_of(key))


def forms_of(kind: Kind) -> tuple[Table, ...]:
    """Tables that a kind allows, the usual table first; empty for a kind without tables."""
    match kind:
        case Table():
            return (kind,)
        case Tables(of) | List(of):
            return forms_of(of)
        case Either() if all(isinstance(one, Table) for one in kind.kinds):
            return tuple(one for one in kind.kinds if isinstance(one, Table))
    return ()


def all_keys() -> Iterator[tuple[str, Entry]]:
    """Yield the path and declaration of every key of the scene format that holds a value.

    In a path such as "materials.NAME.density", NAME stands for any name that the user gives.
    """
    for section in sections():
        for key, (entry, _) in section.keys().items():
            yield section.path_of(key), entry


def find_entry(path: str) -> Entry | None:
    """Declaration of the entry that a path names, such as "pin.length"; None if there is none.

    The path must be that of a single value, not of a table such as "pin". In a path such as
    "materials.steel.density" the material may have any name.
    """
    parts = path.split(".")
    if parts[0] == "materials" and len(parts) > 2:
        parts[1] = "NAME"
    return dict(all_keys()).get(".".join(parts))


def number_in(kind: Kind) -> Quantity | Number | None:
    """The kind of number within a kind, such as a list; None if there are no numbers."""
    match kind:
        case Quantity() | Number():
            return kind
        case List(of) | Range(of):
            return number_in(of)
        case Either():
            found = (number_in(one) for one in kind.kinds)
            return next((one for one in found if one), None)
    return None


def number_at(path: str) -> Quantity | Number:
    """Kind of the number that the entry at a path holds: its unit, bounds and usual range.

    If there is no such entry, or it holds no number, the result is a `Number` without bounds.
    """
    entry = find_entry(path)
    return (entry and number_in(entry.kind)) or Number()


Listed = dict[str, str]
"""Header of the first list of tables that has a key, by key."""


def new_keys(section: Section, listed: Listed) -> tuple[dict[str, tuple[Entry, str]], str]:
    """Keys of a list of tables, such as ``[[tested]]``, that are in no earlier list of tables.

    Returns these keys, as `Section.keys` does, and the header of an earlier list that has the other
    keys, or "" if all keys are new. A section that is not a list of tables keeps all its keys.
    `listed` maps each key to the header of the first list that has it, and gets the new keys.
    """
    keys = section.keys()
    if "." in section.path or not section.is_list:
        return keys, ""
    own = {key: entry for key, entry in keys.items() if key not in listed}
    like = next((listed[key] for key in keys if key in listed), "")
    listed |= dict.fromkeys(own, section.header)
    return own, like


FILES = ("disk.roughness.file", "loading.file")
_MEANT, _LONGEST = 40, 80  # column in which comments begin, and their greatest length


def new_scene(path: str | Path, like: str | None = None, full: bool = False) -> list[Path]:
    """Write a scene to start from: a short scene, a shipped scene, or a scene with every entry.

    Parameters
    ----------
    path : path
        File to write; it must not exist yet.
    like : str, optional
        Name of a shipped scene to copy. By default a short scene whose diagram takes seconds.
    full : bool
        Add every other entry as a comment, with its meaning; not used with `like`.

    Returns
    -------
    list of Path
        The files written: the scene, and copies of the files that it names.

    Raises
    ------
    InputError
        If there is no such scene, the file exists or cannot be written, or is not called ``.toml``.

    Examples
    --------
    >>> import pipeline, tempfile
    >>> from pathlib import Path
    >>> folder = Path(tempfile.mkdtemp())
    >>> [file.name for file in pipeline.new_scene(folder / "mine.toml", like="fig8")]
    ['mine.toml', 'fig8_load_record.csv']
    """
    path, shipped = user_path(path), shipped_scenes()
    if path.suffix != ".toml":
        name = path.stem or "scene"
        raise InputError(f"{path}: a scene is a TOML file; give a name such as {name}.toml")
    if like is not None and like not in shipped:
        raise InputError(
            f'"{like}" is not a shipped scene{did_you_mean(like, shipped)}; there are '
            f"{', '.join(shipped)}"
        )
    short = resources.files("pipeline.scene").joinpath("template.toml")
    text = short.read_text(encoding="utf-8").replace("NAME", path.stem)
    copies = []
    if like is not None:
        text = shipped[like].read_text(encoding="utf-8")
        entries, folder = tomllib.loads(text), shipped[like].parent
        beside = [str(name) for key in FILES if (name := entry_at(entries, key))]
        copies = [(folder / name, path.parent / Path(name).name) for name in beside]
    elif full:
        head = "".join(itertools.takewhile(lambda line: line[0] == "#", text.splitlines(True)))
        text = "\n".join([head + _MARKS, *_scene_lines(tomllib.loads(text)), ""])
    files = [path, *(copy for _, copy in copies)]
    for file in files:
        if file.exists() or file.is_symlink():
            raise InputError(f"{file} exists already; give another name, or remove it")
    try:
        path.write_text(text, encoding="utf-8")
        for original, copy in copies:
            shutil.copyfile(original, copy)
    except OSError as error:
        raise InputError(f"{path} cannot be written: {reason_of(error, path)}") from error
    return files


_MARKS = '# An entry such as "#hold" is not used; take the # off to use it.'


def _scene_lines(entries: Mapping[str, Any]) -> Iterator[str]:
    """Yield lines of a scene file with every entry of the format, as comments if not in use."""
    listed: Listed = {}
    for section in sections():
        table, _, name = section.path.partition(".")
        path, values = section.path, entry_at(entries, section.path) if section.path else entries
        if name == "NAME":
            ((name, values),) = entries[table].items()
            path = f"{table}.{name}"
        keys, like = new_keys(section, listed)
        meaning = f"Keys as in {like}, and these" if like else section.entry.meaning
        if path:
            yield _entry("" if values else "#", section.header.replace(section.path, path), meaning)
        for key, (entry, form) in keys.items():
            default = entry.default
            if path == "fidelity" and key != "preset":
                default = getattr(tribo.PRESETS[entries["fidelity"]["preset"]], key)
            mark, value = "#", example(entry, default)
            if key in (values or {}):
                mark, value = "", values[key]
            yield _entry(mark, f"{key} = {as_toml(value)}", entry.meaning, form and f" ({form})")


def _entry(mark: str, line: str, meaning: str, form: str = "") -> str:
    """Line of a scene file after a `mark` ("#" or none), with its meaning and form as a comment."""
    plain = re.sub(r"\[(\w+)\]\([^)]*\)", r"\1", meaning).replace("`", "")
    # The first sentence alone, or its first clause if the sentence is long.
    sentence = re.split(r"[;.](?: |$)", plain)[0]
    clause = sentence if len(sentence) <= _LONGEST else re.split("[,:] ", sentence)[0]
    return f"{mark + line:{_MEANT}} # {clause}{form}"


def example(entry: Entry, default: Any) -> Any:
    """Value of an entry to show in a new file: its example, its default, or any allowed value."""
    return _allowed(entry.kind, default) if entry.example is None else entry.example


def _allowed(kind: Kind, default: Any) -> Any:
    match kind:
        case Quantity() | UnitText():
            return kind.example
        case List():
            return [_allowed(kind.of, None)] * (kind.length or 1)
        case Either():
            return _allowed(kind.kinds[0], default)
        case _ if default is not None:
            return default
        case OneOf():
            return kind.options[0]
        case Flag():
            return False
        case Whole():
            return int(max(kind.at_least, 0))
        case Number():
            return 0.1
    return "text"
