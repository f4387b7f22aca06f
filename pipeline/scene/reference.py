"""What is made from the format of scenes: their reference, and new scenes."""

from __future__ import annotations

import itertools
import math
import re
import shutil
import textwrap
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from importlib import resources
from pathlib import Path
from typing import Any

import tribo
from pipeline.scene.compounds import Either, Entry, List, Optional, Table, Tables
from pipeline.scene.document import as_toml, read_document
from pipeline.scene.faults import Faults, did_you_mean, entry_at, quoted
from pipeline.scene.format import FIDELITY, SCENE, UNKNOWN, USUAL_PRESET
from pipeline.scene.kinds import Flag, Kind, Number, OneOf, Quantity, UnitText, Whole
from pipeline.scene.shipped import shipped_scenes
from tribo import InputError


@dataclass(frozen=True, slots=True)
class Section:
    """A table of the format: its path, empty for the file itself, and its entry."""

    path: str
    entry: Entry

    @property
    def is_list(self) -> bool:
        """True if there may be several of the table, each in double brackets."""
        return isinstance(self.entry.kind, List)

    @property
    def header(self) -> str:
        """The line that begins it in a file."""
        return f"[[{self.path}]]" if self.is_list else f"[{self.path}]"

    def form_of(self, values: Mapping[str, Any]) -> str:
        """Name of the form that a table of these values has; empty if it has but one."""
        kind = self.entry.kind.of if isinstance(self.entry.kind, List) else self.entry.kind
        usual, *others = forms_of(kind)
        if isinstance(kind, Either) and kind.is_other(values):
            return others[0].form
        return usual.form

    def keys(self) -> dict[str, tuple[Entry, str]]:
        """Keys that hold a value, each with the form that it belongs to, if to one of two."""
        forms = forms_of(self.entry.kind)
        keys: dict[str, tuple[Entry, str]] = {}
        for table in forms:
            for key, entry in table.keys.items():
                if not forms_of(entry.kind):
                    everywhere = all(key in other.keys for other in forms)
                    keys.setdefault(key, (entry, "" if everywhere else table.form))
        return keys

    def path_of(self, key: str) -> str:
        """Path of a key of the table."""
        return f"{self.path}.{key}" if self.path else key


def sections(entry: Entry = SCENE, path: str = "") -> Iterator[Section]:
    """All tables of a format, each before those within it."""
    if isinstance(entry.kind, Tables):
        path += ".NAME"
    section = Section(path, entry)
    yield section
    inner = {k: e for form in forms_of(entry.kind) for k, e in form.keys.items()}
    for key in inner:
        if forms_of(inner[key].kind):
            yield from sections(inner[key], section.path_of(key))


def forms_of(kind: Kind) -> tuple[Table, ...]:
    """The tables that a kind allows, the usual one first; none if it is that of a value."""
    match kind:
        case Table():
            return (kind,)
        case Tables(of) | List(of):
            return forms_of(of)
        case Either(Table() as usual, Table() as other):
            return (usual, other)
    return ()


def meanings() -> dict[str, str]:
    """Sentence on each key, by its path; NAME stands for a name of the user's choice."""
    return {
        section.path_of(key): entry.meaning
        for section in sections()
        for key, (entry, _) in section.keys().items()
    }


def page() -> str:
    """The tables of all entries, as the page of the scene file has them behind its head."""
    parts = []
    for section in sections():
        title = f"`{section.header}`" if section.path else "Top of the file"
        need = " May be left out." if isinstance(section.entry, Optional) else ""
        parts.append(f"## {title}\n\n{section.entry.meaning}{need}\n")
        rows = [
            [f"`{key}`", str(entry.kind), _default_cell(section, entry, form), entry.meaning]
            for key, (entry, form) in section.keys().items()
        ]
        parts += _table(["key", "give", "default", "meaning"], rows) if rows else []
    presets = [
        [f"`{key}`", *(written(getattr(preset, key)) for preset in tribo.PRESETS.values())]
        for key in FIDELITY.keys
        if key != "preset"
    ]
    about = "Choices of each preset; [`CHOOSING.md`](CHOOSING.md) has their costs.\n"
    return "\n".join([*parts, "## Presets\n", about, *_table(["", *tribo.PRESETS], presets)])


def _table(heads: list[str], rows: list[list[str]]) -> list[str]:
    """Lines of a table in Markdown."""
    cells = [[cell.replace("|", "\\|") for cell in row] for row in (heads, *rows)]
    head, *below = [f"| {' | '.join(row)} |" for row in cells]
    return [head, "|---" * len(heads) + "|", *below, ""]


def _default_cell(section: Section, entry: Entry, form: str) -> str:
    if not isinstance(entry, Optional):
        words = "needed"
    elif section.path == "fidelity" and entry.default is None:
        words = "the preset's"
    else:
        usual = written(entry.default, entry.kind)
        words = f"`{usual}`" if usual else "–"
    return f"{words} ({form})" if form else words


def written(value: Any, kind: Kind | None = None) -> str:
    """A default as a scene file would have it; empty for none."""
    if value in (None, (), {}, math.inf):
        return ""
    match kind:
        case List(of) if isinstance(value, tuple):
            return f"[{', '.join(written(item, of) for item in value)}]"
        case Quantity(example=example) if "degC" in example:
            return f'"{value - 273.15:g} degC"'
    return f"{value:g}" if isinstance(value, float) else quoted(value)


_WIDTH = 98
_USUAL = "first_try"
_FILES = ("disk.roughness.file", "loading.file")
_HEAD = """\
# A scene to start from. Its entries are those of a steel cylinder on a ground steel disk in white
# oil: put your own in their place. An entry such as "#hold" is not used; take the # off to use it.
"""
_NEXT = """\
#
# Its meaning      irg check {name}.toml
# Its diagram      irg run {name}.toml, then irg plot results/{name}.zarr
"""


def new_scene(path: str | Path, like: str | None = None, full: bool = False) -> list[Path]:
    """Write a scene to start from: a short one, or one in which every entry is explained.

    Parameters
    ----------
    path : path
        File to write; it must not exist yet.
    like : str, optional
        Name of a shipped scene to begin with, every entry explained. By default a scene whose
        diagram takes seconds.
    full : bool
        Explain every entry of the template, too, and add those that it has not as comments.

    Returns
    -------
    list of Path
        The files written: the scene, and copies of those that it names.

    Raises
    ------
    InputError
        If there is no such scene, the file exists or cannot be written, or is not called ``.toml``.

    Examples
    --------
    >>> import tempfile
    >>> folder = Path(tempfile.mkdtemp())
    >>> [file.name for file in new_scene(folder / "mine.toml", like="fig8")]
    ['mine.toml', 'fig8_load_record.csv']
    """
    path, shipped = Path(path), shipped_scenes()
    if path.suffix != ".toml":
        name = path.stem or "scene"
        raise InputError(f"{path}: a scene is a TOML file; give a name such as {name}.toml")
    if like is not None and like not in shipped:
        raise InputError(
            f'"{like}" is not a shipped scene{did_you_mean(like, shipped)}; there are '
            f"{', '.join(shipped)}"
        )
    source = shipped[like or _USUAL]
    entries = read_document(source, Faults()).entries()
    if like is None:
        head = _HEAD
        entries |= {"title": "My system", "fidelity": {"preset": USUAL_PRESET}}
        del entries["measured"]
    else:
        lines = source.read_text(encoding="utf-8").splitlines(keepends=True)
        head = "".join(itertools.takewhile(lambda line: line.startswith("#"), lines))
    text = "\n".join([head + _NEXT.format(name=path.stem).rstrip(), *_lines(entries), ""])
    if like is None and not full:
        short = resources.files("pipeline.scene").joinpath("template.toml")
        text = short.read_text(encoding="utf-8").replace("NAME", path.stem)
    beside = [str(name) for key in _FILES if (name := entry_at(entries, key))]
    copies = [(source.parent / name, path.parent / Path(name).name) for name in beside]
    for file in (path, *(copy for _, copy in copies)):
        if file.exists():
            raise InputError(f"{file} exists already; give another name, or remove it")
    try:
        path.write_text(text, encoding="utf-8")
        for original, copy in copies:
            shutil.copyfile(original, copy)
    except OSError as error:
        folder = path.parent
        reason = error.strerror or error if folder.is_dir() else f"there is no folder {folder}"
        raise InputError(f"{path} cannot be written: {reason}") from error
    return [path, *(copy for _, copy in copies)]


def _lines(entries: Mapping[str, Any]) -> Iterator[str]:
    """A scene's entries with what each means, and those that it does not have as comments."""
    for section in sections():
        table, _, name = section.path.partition(".")
        values = entry_at(entries, section.path) if section.path else entries
        if name == "NAME":
            tables = [(f"[{table}.{key}]", one) for key, one in entries.get(table, {}).items()]
        elif section.is_list and values:
            tables = [(section.header, item) for item in values]
        elif isinstance(values, str):  # short for a name of the library
            tables = [(section.header, {"like": values})]
        else:
            tables = [(section.header if section.path else "", values)]
        for number, (header, held) in enumerate(tables):
            yield from _section(section, header, held, comment=number == 0)


def _section(
    section: Section, header: str, values: Mapping[str, Any] | None, comment: bool
) -> Iterator[str]:
    """Lines of one table: all keys with comments, or only those given without."""
    yield ""
    if comment and section.path:
        yield from _wrapped(section.entry.meaning)
    if header:
        yield header if values is not None else f"#{header}"
    entries = values or {}
    used = section.form_of(entries)
    others: dict[str, tuple[Entry, str]] = {}
    for key, (entry, form) in section.keys().items():
        if form not in ("", used):
            others[key] = entry, form
        elif comment or key in entries:
            yield from _key(section, key, entry, entries, comment)
    if others and comment:
        form = next(iter(others.values()))[1]
        yield from _wrapped(f"Or, for a {form}, in place of the keys of the {used}:")
        for key, (entry, _) in others.items():
            yield from _key(section, key, entry, {}, comment)


def _key(
    section: Section, key: str, entry: Entry, entries: Mapping[str, Any], comment: bool
) -> Iterator[str]:
    """Lines of one key: its meaning and the values allowed, and its value or an example."""
    default = entry.default
    if section.path == "fidelity" and key != "preset":
        default = getattr(tribo.PRESETS[entries.get("preset", USUAL_PRESET)], key)
    if comment:
        usual = written(default, entry.kind)
        ending = f"; default {usual}" if usual else ""
        yield from _wrapped(f"{entry.meaning} Give {entry.kind}{ending}.")
    value = entries[key] if key in entries else example(entry, default)
    mark = "" if key in entries else "#"
    if entry.kind is UNKNOWN:  # a line for each, since they are long
        for name, distribution in value.items():
            yield f"{mark}{key}.{name} = {as_toml(distribution)}"
    else:
        yield f"{mark}{key} = {as_toml(value)}"


def example(entry: Entry, default: Any = None) -> Any:
    """A value of an entry, as TOML has it: its example, its default, or one that is allowed."""
    return _allowed(entry.kind, default) if entry.example is None else entry.example


def _allowed(kind: Kind, default: Any) -> Any:
    match kind:
        case Quantity() | UnitText():
            return kind.example
        case List():
            return [_allowed(kind.of, None)] * (kind.length or 1)
        case Either():
            return _allowed(kind.usual, default)
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


def _wrapped(text: str) -> Iterator[str]:
    """Text as comments, without the marks of Markdown; quoted words stay on one line."""
    plain = re.sub(r"\[(\w+)\]\([^)]*\)", r"\1", text).replace("`", "")
    kept = re.sub('"[^"]*"', lambda match: match[0].replace(" ", "\N{NO-BREAK SPACE}"), plain)
    for line in textwrap.wrap(kept, _WIDTH, break_long_words=False, break_on_hyphens=False):
        yield "# " + line.replace("\N{NO-BREAK SPACE}", " ")


if __name__ == "__main__":
    print(page(), end="")
