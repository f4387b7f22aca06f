"""A user's own laws in a scene: Python objects, which replace entries of the file."""

from __future__ import annotations

import json
from collections.abc import Mapping
from dataclasses import asdict, fields, is_dataclass, replace
from typing import Any

import tribo
from pipeline.scene.document import Document
from pipeline.scene.faults import Faults, quoted
from pipeline.sweep.laws import ASKED, Law, StoredRule, is_user_law, law_record, name_of
from pipeline.sweep.measurement import Case
from pipeline.sweep.tables import entry_at, replace_value
from tribo.errors import law_errors
from tribo.simulation.pins import sizes_of

_SIZES = dict.fromkeys(f"pin.{size}" for shape in tribo.PINS for size in sizes_of(shape))
_REPLACED = {
    "wear": ("wear",),
    "surface": ("disk.roughness",),
    "criterion": ("temperature.criterion",),
    "pin": ("pin.shape", "pin.material", *_SIZES),
}
"""Entries of a scene that each law replaces."""
_PROTOCOLS: dict[str, Any] = {"wear": tribo.WearLaw, "surface": tribo.Surface, "pin": tribo.Pin}
_NAMES = {
    "wear": "wear.law",
    "surface": "disk.surface.law",
    "criterion": "temperature.criterion",
    "pin": "pin.law",
}
"""Entry with the name of each law."""
_PARAMETERS = {kind: f"{path.rpartition('.')[0]}.parameters" for kind, path in _NAMES.items()}
"""Tables in which a scene gives the fields of each law other values."""
_SOURCE = "source_sha256"


def replace_by_laws(document: Document, laws: Mapping[str, Any]) -> Document:
    """Remove from a document the entries that a user's `laws` replace.

    `laws` are Python objects by kind, such as "wear". Raises an `InputError` if a law does not fit.
    """
    for kind, law in laws.items():
        if kind not in _REPLACED:
            raise tribo.InputError(f"laws: {kind!r} is unknown; give {', '.join(_REPLACED)}")
        try:
            _require_law(kind, law)
        except tribo.InputError as error:
            raise tribo.InputError(f"laws.{kind}: {error}") from error
        for path in _REPLACED[kind]:
            document = document.replaced(path, None)
    return document


def _require_law(kind: str, law: Any) -> None:
    """Raise an `InputError` unless `law` has its kind's methods, and can be hashed and stored."""
    if kind == "criterion":
        if not isinstance(law, tribo.Rule):
            raise tribo.InputError(f"{law!r:.60} is not a tribo.Rule; give one")
    else:
        names = (name for name in vars(_PROTOCOLS[kind]) if not name.startswith("_"))
        if lacks := [name for name in names if not hasattr(law, name)]:
            about = f"see tribo.{_PROTOCOLS[kind].__name__}"
            raise tribo.InputError(f"{law!r:.60} has no {', '.join(lacks)}; {about}")
    try:
        if isinstance(law, type) or not is_dataclass(law):
            raise TypeError("it is not an object of a dataclass")
        hash(law)
        json.dumps([_plain(value) for _, value in law_record(law).parameters])
    except TypeError as error:
        raise tribo.InputError(
            f"{law!r:.60}: {error}; write @dataclass(frozen=True), or with an array "
            "@dataclass(frozen=True, eq=False), whose other fields are numbers or text"
        ) from error


def take_laws(
    laws: Mapping[str, Any], entries: dict[str, Any], faults: Faults
) -> tuple[dict[str, Any], dict[str, Any]]:
    """Return a user's laws by kind, and the scene's `entries` without those that concern the laws.

    A law is a user's Python object in place of entries of the scene. Its kind is "wear", "surface",
    "criterion" or "pin".

    - `laws` are the objects at hand, by kind. If entries set fields of an object, a copy with these
      values is returned.
    - The entries of a stored scene may record the name and fields of a law whose object is not at
      hand. Then a `Law` with this record is returned instead of the object.
    - An entry that a law replaces is a fault, which is added to `faults`.
    - A user's pin also gets entries in the result: a ball or a cylinder of the same size.
    """
    taken = dict(laws)
    for kind, path in _NAMES.items():
        table, sources = path.rpartition(".")[0], f"{path.rpartition('.')[0]}.{_SOURCE}"
        values, source = (entry_at(entries, one) for one in (_PARAMETERS[kind], sources))
        if kind in laws and values:
            taken[kind] = _with_values(laws[kind], values, _PARAMETERS[kind], faults)
        elif source and kind not in laws:
            pairs = ((name, _read(name, value)) for name, value in dict(values or {}).items())
            record = StoredRule if kind == "criterion" else Law
            taken[kind] = record(str(entry_at(entries, path)), tuple(pairs), str(source))
        if source:
            entries = replace_value(replace_value(entries, path, None), sources, None)
        if kind in taken:
            entries = replace_value(entries, _PARAMETERS[kind], None)
            entries = entries if entry_at(entries, table) else replace_value(entries, table, None)
    for kind in taken:
        for path in _REPLACED[kind]:
            if entry_at(entries, path) is not None:
                faults.refuse(path, f"laws.{kind} replaces this entry; leave the entry out")
                entries = replace_value(entries, path, None)
    if pin := taken.get("pin"):
        shape = "ball" if pin.length is None else "cylinder"
        sizes = {"radius": pin.radius} | ({} if pin.length is None else {"length": pin.length})
        stand_in = {name: f"{float(size)!r} m" for name, size in sizes.items()}
        stand_in |= {"shape": shape, "material": entry_at(entries, "disk.material")}
        entries = {**entries, "pin": {**entries.get("pin", {}), **stand_in}}
    return taken, entries


def _laws_of(case: Case) -> dict[str, Any]:
    scene = case.scene
    laws = {"wear": scene.wear, "surface": scene.roughness, "pin": scene.pin}
    return laws | {"criterion": case.conditions.criterion.rule}


def add_laws(entries: dict[str, Any], case: Case, like: Case | None = None) -> dict[str, Any]:
    """Return the entries of a scene with the user's laws added.

    A law is written as its name, its fields and the hash of its source code. A law that the scene
    `like`, if it is given, has too is left out, unless `entries` have a table for the law.
    """
    present = _laws_of(like) if like else {}
    for kind, part in _laws_of(case).items():
        is_kept = _NAMES[kind].partition(".")[0] in entries or not like or present[kind] != part
        if not (is_user_law(part) and is_kept):
            continue
        law, table = law_record(part), _NAMES[kind].rpartition(".")[0]
        for path in _REPLACED[kind]:
            entries = replace_value(entries, path, None)
        named: dict[str, Any] = {_NAMES[kind]: law.name, f"{table}.{_SOURCE}": law.source_sha256}
        named[_PARAMETERS[kind]] = {name: _plain(value) for name, value in law.parameters}
        for path, value in named.items():
            entries = replace_value(entries, path, value)
    return entries


def _plain(value: Any) -> Any:
    """Convert a parameter of a law to values that JSON can hold."""
    if isinstance(value, tribo.Material):
        return asdict(value)
    return [*map(_plain, value)] if isinstance(value, tuple) else value


def _read(name: str, value: Any) -> Any:
    if isinstance(value, dict) and name == "material":
        return tribo.Material(**value)
    return tuple(_read("", one) for one in value) if isinstance(value, list) else value


def _with_values(law: Any, values: Any, path: str, faults: Faults) -> Any:
    """Copy of a law with new `values` of its fields, or with a fault the law itself."""
    if isinstance(values, dict):
        own = {one.name for one in fields(law)}
        values = {key: one for key, one in values.items() if key in own or key not in ASKED}
    with faults.at(path), law_errors(name_of(law)):
        made = replace(law, **values)
        for name, value in values.items():
            if isinstance(value, str) != isinstance(usual := getattr(law, name), str):
                problem = f"{quoted(value)} does not fit; give one such as {usual!r}, in SI units"
                raise tribo.InputError(f"{name}: {problem}")
        return made
    return law
