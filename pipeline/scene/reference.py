"""What is made from the format of scenes: ``workflows/SCENE.md``, and a JSON schema for editors.

A schema sees one file, and not what the scene that it extends or the library adds to it: so it
asks for no entry, and `pipeline.load_scene` alone says what is missing.
"""

from __future__ import annotations

import json
import math
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import tribo
from pipeline.scene.faults import quoted, write_new
from pipeline.scene.format import FIDELITY, SCENE
from pipeline.scene.kinds import (
    Flag,
    Kind,
    Number,
    OneOf,
    Quantity,
    Scalar,
    Share,
    UnitText,
    Whole,
)
from pipeline.scene.schema import (
    ByPath,
    Distribution,
    Either,
    Entry,
    List,
    Optional,
    Range,
    Table,
    Tables,
)
from tribo import InputError

_HEAD = """# The scene file

For whoever writes a scene. After it you know what each entry means, its unit and its default. This
page is made from the format itself by `make reference`.
[`YOUR_SYSTEM.md`](YOUR_SYSTEM.md) leads from a drawing or a measured surface to a diagram.

A scene is a TOML file in UTF-8. Quantities are text with a unit, such as `"750 N"`, in any unit of
the right dimension; decimals have a point; a bare number where a unit is due is a fault.
A velocity may be `"600 rpm at radius 25 mm"`, or `at diameter`.
`irg new scene.toml --full` writes a scene that holds all of this as comments, and
`irg check scene.toml` names every fault at once. `irg new --schema scene.schema.json` writes a JSON
schema, by which editors complete and explain the entries of a scene that begins with
`#:schema ./scene.schema.json`.
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


_QUANTITY = r"^\s*[+-]?(\d+\.?\d*|\.\d+)([eE][+-]?\d{1,3})?(\s+\S|[^\d.,\s])"
"""A number that something follows: whether that is a unit is not for a schema to know."""

_BOUNDS = {
    "above": "exclusiveMinimum",
    "at_least": "minimum",
    "below": "exclusiveMaximum",
    "at_most": "maximum",
}


def write_schema(path: str | Path) -> Path:
    """Write the JSON schema of scene files to a new file, which must be called ``.json``.

    Examples
    --------
    >>> import tempfile
    >>> write_schema(Path(tempfile.mkdtemp(), "scene.schema.json")).name
    'scene.schema.json'
    """
    path = Path(path)
    if path.suffix != ".json":
        raise InputError(f"{path}: a schema is a JSON file; give a name such as scene.schema.json")
    write_new(path, json.dumps(schema(), indent=2, ensure_ascii=False) + "\n")
    return path


def schema() -> dict[str, Any]:
    """The schema of a scene file, as plain data.

    Examples
    --------
    >>> schema()["properties"]["sweep"]["properties"]["loads"]["anyOf"][0]["items"]["examples"]
    ['200 N']
    """
    scene = _entry(SCENE)
    entries = scene["properties"]
    about = {"description": entries["oil"].pop("description")}
    # Or a name of the library in its place.
    entries["oil"] = {"anyOf": [entries["oil"], {"type": "string"}]} | about
    heads = {"$schema": "http://json-schema.org/draft-07/schema#", "title": "Scene of irg"}
    return heads | scene


def _table(*forms: Table) -> dict[str, Any]:
    """A table with the keys of all its forms."""
    keys = {key: entry for table in forms for key, entry in table.keys.items()}
    return {
        "type": "object",
        "properties": {key: _entry(entry) for key, entry in keys.items()},
        "additionalProperties": False,
    }


def _entry(entry: Entry) -> dict[str, Any]:
    """Values that an entry allows, and its meaning."""
    return _allowed(entry.kind) | ({"description": entry.meaning} if entry.meaning else {})


def _allowed(kind: Kind) -> dict[str, Any]:
    match kind:
        case Table():
            return _table(kind)
        case Either(Table() as usual, Table() as other):
            return _table(usual, other)
        case Either():
            return {"anyOf": [_allowed(kind.usual), _allowed(kind.other)]}
        case Tables():
            return {"type": "object", "additionalProperties": _table(kind.of)}
        case List():
            size = {"minItems": kind.length, "maxItems": kind.length} if kind.length else {}
            return {
                "type": "array",
                "items": _allowed(kind.of),
                "minItems": 1,
                "uniqueItems": kind.distinct,
            } | size
        case Range():
            return _table(kind.ends) | {"required": kind.ends.needed}
        case ByPath(Distribution() as of):
            forms = [_table(table) | {"required": table.needed} for table in of.forms]
            deeper = {"$ref": "#/properties/unknown"}  # a path in tables in tables
            one = {"anyOf": [*forms, _allowed(of.listed), deeper]}
            return {"type": "object", "additionalProperties": one}
        case ByPath():
            return {"type": "object", "additionalProperties": {"type": ["number", "object"]}}
        case Scalar():
            return {"type": ["number", "string"]}
        case OneOf():
            return {"enum": list(kind.options)}
        case Flag():
            return {"type": "boolean"}
        case Quantity():
            return {"type": "string", "pattern": _QUANTITY, "examples": [kind.example]}
        case UnitText():
            return {"type": "string", "examples": [kind.example]}
        case Share():
            return {"anyOf": [_allowed(Number(**kind.bounds)), {"type": "string", "pattern": "%"}]}
        case Number():
            bounds = {_BOUNDS[name]: bound for name, bound in kind.bounds.items()}
            return {"type": "integer" if isinstance(kind, Whole) else "number"} | bounds
    return {"type": "string", "minLength": 1}
