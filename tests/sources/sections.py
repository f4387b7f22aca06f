"""Made from the format of scenes: its tables and keys by path."""

from __future__ import annotations

from collections.abc import Iterator
from typing import NamedTuple

from pipeline.kinds import Kind
from pipeline.scene.format import SceneFile
from pipeline.scene.table_kinds import Either, Entry, List, TableKind, Tables


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
        """Line that begins the table in a scene file, such as "[pin]" or "[[tests]]"."""
        return f"[[{self.path}]]" if self.is_list else f"[{self.path}]"

    def keys(self) -> dict[str, tuple[Entry, str]]:
        """Keys of the section that hold values: for each, its declaration and a table's name.

        Some sections allow one of several tables, such as a random or a measured surface. The name
        is that of the first of these tables that has the key. It is empty if all of them have it,
        with a default or without.
        """
        forms = forms_of(self.entry.kind)
        keys: dict[str, tuple[Entry, str]] = {}
        for table in forms:
            for key, entry in table.keys.items():
                if not forms_of(entry.kind):
                    needs = {form.keys[key].is_needed for form in forms if key in form.keys}
                    everywhere = all(key in form.keys for form in forms) and len(needs) == 1
                    keys.setdefault(key, (entry, "" if everywhere else table.form))
        return keys

    def path_of(self, key: str) -> str:
        """Path of a key of this table, from the top of the file."""
        return f"{self.path}.{key}" if self.path else key


_SCENE = Entry(TableKind(SceneFile), "The file itself, above its first table.", is_needed=True)


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


def forms_of(kind: Kind) -> tuple[TableKind, ...]:
    """Tables that a kind allows, the usual table first; empty for a kind without tables."""
    match kind:
        case TableKind():
            return (kind,)
        case Tables(item_kind) | List(item_kind):
            return forms_of(item_kind)
        case Either() if all(isinstance(option, TableKind) for option in kind.kinds):
            return tuple(option for option in kind.kinds if isinstance(option, TableKind))
    return ()


def all_keys() -> Iterator[tuple[str, Entry]]:
    """Yield the path and declaration of every key of the scene format that holds a value.

    In a path such as "materials.NAME.density", NAME stands for any name that the user gives.
    """
    for section in sections():
        for key, (entry, _) in section.keys().items():
            yield section.path_of(key), entry
