"""The reference of the scene file, made from the format itself: ``workflows/SCENE.md``."""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import dataclass
from typing import Any

import tribo
from pipeline.scene.entries import quoted
from pipeline.scene.format import FORMAT
from pipeline.scene.kinds import Kind, Quantity
from pipeline.scene.meanings import MEANINGS, TABLES, VARIANTS
from pipeline.scene.schema import Either, List, Optional, Table, Tables

_HEAD = """# The scene file

Every table and key of a scene, made from the format itself by `make reference`.
[`YOUR_SYSTEM.md`](YOUR_SYSTEM.md) leads from a drawing or a measured surface to a diagram.

A scene is a TOML file in UTF-8. Quantities are text with a unit, such as `"750 N"`, in any unit of
the right dimension; decimals have a point; a bare number where a unit is due is a fault.
`irg new scene.toml` writes a scene that holds all of this as comments, and `irg check scene.toml`
names every fault at once. `irg new --schema scene.schema.json` writes a JSON schema, by which
editors complete and explain the entries of a scene that begins with `#:schema ./scene.schema.json`.
"""


@dataclass(frozen=True, slots=True)
class Section:
    """A table of the format.

    Attributes
    ----------
    path : str
        Path of the table; empty for the file itself.
    forms : tuple of Table
        The table; or both, where it has either of two forms, the usual one first.
    is_needed : bool
        True if a scene has to have it.
    is_list : bool
        True if there may be several, each in double brackets.
    """

    path: str
    forms: tuple[Table, ...]
    is_needed: bool
    is_list: bool = False

    @property
    def header(self) -> str:
        """The line that begins it in a file."""
        return f"[[{self.path}]]" if self.is_list else f"[{self.path}]"

    def keys(self) -> dict[str, tuple[Kind | Optional, str]]:
        """Keys that hold a value, each with its kind and the form that it belongs to, if to one."""
        entries = {}
        for form, table in enumerate(self.forms):
            for key, entry in table.keys.items():
                if forms_of(kind_of(entry)) or key in entries:
                    continue
                everywhere = all(key in other.keys for other in self.forms)
                entries[key] = entry, "" if everywhere else VARIANTS[self.path][form]
        return entries

    def path_of(self, key: str) -> str:
        """Path of a key of the table."""
        return f"{self.path}.{key}" if self.path else key


def sections(kind: Kind = FORMAT, path: str = "", is_needed: bool = True) -> Iterator[Section]:
    """All tables of a format, each before those within it."""
    forms = forms_of(kind)
    if isinstance(kind, Tables):
        path += ".NAME"
    yield Section(path, forms, is_needed, isinstance(kind, List))
    for key, entry in {key: entry for form in forms for key, entry in form.keys.items()}.items():
        if forms_of(kind_of(entry)):
            inner = f"{path}.{key}" if path else key
            yield from sections(kind_of(entry), inner, not isinstance(entry, Optional))


def forms_of(kind: Kind) -> tuple[Table, ...]:
    """The tables that a kind allows; none if it is that of a value."""
    match kind:
        case Table():
            return (kind,)
        case Tables(of) | List(Table() as of):
            return (of,)
        case Either(Table() as usual, Table() as other):
            return (usual, other)
        case List(Either(Table() as usual, Table() as other)):
            return (usual, other)
    return ()


def page() -> str:
    """The reference as a page of Markdown."""
    parts = [_HEAD]
    for section in sections():
        title = f"`{section.header}`" if section.path else "Top of the file"
        need = "" if section.is_needed else " May be left out."
        parts.append(f"## {title}\n\n{TABLES[section.path]}{need}\n")
        rows = [
            f"| `{key}` | {_cell(kind_of(entry))} | {_default_cell(section, entry, form)} | "
            f"{MEANINGS[section.path_of(key)]} |"
            for key, (entry, form) in section.keys().items()
        ]
        if rows:
            parts += ["| key | give | default | meaning |", "|---|---|---|---|", *rows, ""]
    return "\n".join([*parts, _presets()])


def _presets() -> str:
    names = list(tribo.PRESETS)
    (fidelity,) = (section for section in sections() if section.path == "fidelity")
    keys = [key for key in fidelity.keys() if key != "preset"]  # noqa: SIM118
    rows = [
        f"| `{key}` | {' | '.join(written(getattr(tribo.PRESETS[name], key)) for name in names)} |"
        for key in keys
    ]
    heads = [f"| {' | '.join(['', *names])} |", "|---" * (len(names) + 1) + "|"]
    about = "Choices of each preset; [`CHOOSING.md`](CHOOSING.md) has their costs.\n"
    return "\n".join(["## Presets\n", about, *heads, *rows, ""])


def _default_cell(section: Section, entry: Kind | Optional, form: str) -> str:
    if not isinstance(entry, Optional):
        words = "needed"
    elif section.path == "fidelity" and entry.default is None:
        words = "the preset's"
    else:
        is_said = entry.default not in (None, math.inf)
        words = f"`{written(entry.default, entry.kind)}`" if is_said else "–"
    return f"{words} ({form})" if form else words


def written(value: Any, kind: Kind | None = None) -> str:
    """Write a default as a scene file would."""
    match kind:
        case List(of) if isinstance(value, tuple):
            return f"[{', '.join(written(item, of) for item in value)}]"
        case Quantity(example=example) if "degC" in example:
            return f'"{value - 273.15:g} degC"'
    return f"{value:g}" if isinstance(value, float) else quoted(value)


def _cell(kind: Kind) -> str:
    return str(kind).replace("|", "\\|")


def kind_of(entry: Kind | Optional) -> Kind:
    """The kind of a key's value, which may be left out or not."""
    return entry.kind if isinstance(entry, Optional) else entry


if __name__ == "__main__":
    print(page(), end="")
