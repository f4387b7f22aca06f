"""Laws of a user's own in a scene: Python objects, which stand in place of entries of the file."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import fields, is_dataclass, replace
from typing import Any

import tribo
from pipeline.scene.document import Document, replace_entry
from pipeline.scene.faults import Faults, entry_at, quoted
from pipeline.sweep.codec import encode
from pipeline.sweep.laws import name_of
from tribo.errors import law_errors
from tribo.simulation.pins import sizes_of

_SIZES = dict.fromkeys(f"pin.{size}" for shape in tribo.PINS for size in sizes_of(shape))
_REPLACED = {
    "wear": ("wear",),
    "surface": ("disk.roughness",),
    "criterion": ("temperature.criterion",),
    "pin": ("pin.shape", "pin.material", *_SIZES),
}
"""Entries of a scene that each law stands for."""
_PROTOCOLS: dict[str, Any] = {"wear": tribo.WearLaw, "surface": tribo.Surface, "pin": tribo.Pin}
_PARAMETERS = {
    "wear": "wear.parameters",
    "surface": "disk.surface.parameters",
    "pin": "pin.parameters",
}
"""Tables of the fields of each law, where the scene gives them other values."""
_NAMES = {"wear.law": "wear", "disk.surface.law": "surface", "temperature.criterion": "criterion"}


def named_code(entries: dict[str, Any]) -> Iterator[str]:
    """Say of each law that a scene names as ``"module:name"`` that it is an object in Python."""
    for path, kind in _NAMES.items():
        if ":" in str(name := entry_at(entries, path)):
            yield (
                f"{path}: {quoted(name)} is code, which a scene file cannot name; give the object "
                f'in Python, pipeline.load_scene(…, laws={{"{kind}": …}})'
            )


def replace_by_laws(document: Document, laws: Mapping[str, Any]) -> Document:
    """The document without the entries that laws stand for; an `InputError` for an unfit law."""
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
    """Raise an `InputError` for a law that cannot be one, or that no store tells from others."""
    if kind == "criterion":
        if not isinstance(law, tribo.Rule):
            raise tribo.InputError(f"{law!r:.60} is not a tribo.Rule; give one")
    else:
        names = (name for name in vars(_PROTOCOLS[kind]) if not name.startswith("_"))
        if lacks := [name for name in names if not hasattr(law, name)]:
            about = f"see tribo.{_PROTOCOLS[kind].__name__}"
            raise tribo.InputError(f"{law!r:.60} has no {', '.join(lacks)}; {about}")
        if isinstance(law, type) or not is_dataclass(law):
            raise tribo.InputError(f"{law!r:.60} is not an object of a dataclass; give one")
        try:
            hash(law)
        except TypeError as error:
            raise tribo.InputError(
                f"{name_of(law)}: {error}; write @dataclass(frozen=True), and with an array "
                "@dataclass(frozen=True, eq=False)"
            ) from error
    encode(law, {})


def law_entries(laws: Mapping[str, Any]) -> dict[str, Any]:
    """Fields of laws, by the paths of the entries that give them other values."""
    return {
        f"{_PARAMETERS[kind]}.{one.name}": getattr(law, one.name)
        for kind, law in laws.items()
        if kind in _PARAMETERS
        for one in fields(law)
    }


def take_laws(
    laws: Mapping[str, Any], entries: dict[str, Any], faults: Faults
) -> tuple[dict[str, Any], dict[str, Any]]:
    """Laws with the values that entries give their fields, and the other entries.

    A pin of the same length stands in these for one that is a law.
    """
    taken = dict(laws)
    for kind, law in laws.items():
        if path := _PARAMETERS.get(kind):
            taken[kind] = _with_values(law, entry_at(entries, path) or {}, path, faults)
            entries = replace_entry(entries, path, None)
            table = path.rpartition(".")[0]
            entries = entries if entry_at(entries, table) else replace_entry(entries, table, None)
        for path in _REPLACED[kind]:
            if entry_at(entries, path) is not None:
                faults.refuse(path, f"laws.{kind} stands in its place; leave it out")
                entries = replace_entry(entries, path, None)
    if pin := taken.get("pin"):
        shape = "ball" if pin.length is None else "cylinder"
        sizes = {"radius": pin.radius} | ({} if pin.length is None else {"length": pin.length})
        stand_in = {name: f"{float(size)!r} m" for name, size in sizes.items()}
        stand_in |= {"shape": shape, "material": entry_at(entries, "disk.material")}
        entries = {**entries, "pin": {**entries.get("pin", {}), **stand_in}}
    return taken, entries


def _with_values(law: Any, values: Any, path: str, faults: Faults) -> Any:
    """A law with other values of some fields; those of numbers are in SI, and no text."""
    if not values:
        return law
    with faults.at(path), law_errors(name_of(law)):
        made = replace(law, **values)
        for name, value in values.items():
            if isinstance(value, str) != isinstance(usual := getattr(law, name), str):
                problem = f"{quoted(value)} does not fit; give one such as {usual!r}, in SI units"
                raise tribo.InputError(f"{name}: {problem}")
        return made
    return law
