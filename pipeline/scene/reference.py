"""What is made from the format of scenes: its sections, and ``workflows/SCENE.md``."""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from typing import Any

import tribo
from pipeline.scene.faults import quoted
from pipeline.scene.format import FIDELITY, SCENE
from pipeline.scene.kinds import Kind, Quantity
from pipeline.scene.schema import Either, Entry, List, Optional, Table, Tables

_HEAD = """# The scene file

For whoever writes a scene. After it you know what each entry means, its unit and its default. This
page is made from the format itself by `make reference`.
[`YOUR_SYSTEM.md`](YOUR_SYSTEM.md) leads from a drawing or a measured surface to a diagram.

A scene is a TOML file in UTF-8. Quantities are text with a unit, such as `"750 N"`, in any unit of
the right dimension; decimals have a point; a bare number where a unit is due is a fault.
A velocity may be `"600 rpm at radius 25 mm"`, or `at diameter`.
`irg new scene.toml --full` writes a scene that holds all of this as comments, and
`irg check scene.toml` names every fault at once.
"""


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
    for key, inner in {k: e for form in forms_of(entry.kind) for k, e in form.keys.items()}.items():
        if forms_of(inner.kind):
            yield from sections(inner, section.path_of(key))


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
    """The reference as a page of Markdown."""
    parts = [_HEAD]
    for section in sections():
        title = f"`{section.header}`" if section.path else "Top of the file"
        need = " May be left out." if isinstance(section.entry, Optional) else ""
        parts.append(f"## {title}\n\n{section.entry.meaning}{need}\n")
        rows = [
            f"| `{key}` | {_cell(entry.kind)} | {_default_cell(section, entry, form)} | "
            f"{entry.meaning} |"
            for key, (entry, form) in section.keys().items()
        ]
        if rows:
            parts += ["| key | give | default | meaning |", "|---|---|---|---|", *rows, ""]
    return "\n".join([*parts, _presets()])


def _presets() -> str:
    names = list(tribo.PRESETS)
    keys = [key for key in FIDELITY.keys if key != "preset"]
    rows = [
        f"| `{key}` | {' | '.join(written(getattr(tribo.PRESETS[name], key)) for name in names)} |"
        for key in keys
    ]
    heads = [f"| {' | '.join(['', *names])} |", "|---" * (len(names) + 1) + "|"]
    about = "Choices of each preset; [`CHOOSING.md`](CHOOSING.md) has their costs.\n"
    return "\n".join(["## Presets\n", about, *heads, *rows, ""])


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


def _cell(kind: Kind) -> str:
    return str(kind).replace("|", "\\|")


if __name__ == "__main__":
    print(page(), end="")
