"""Entries as text: what was read of a file, complete and in its units, and readable again."""

from __future__ import annotations

import math
from typing import Any

import tribo
from pipeline.quantities import DIMENSIONS, ZERO
from pipeline.scene.declare import ByPath, Either, List, Table, Tables, table_of
from pipeline.scene.format import Fidelity
from pipeline.scene.kinds import Kind, Quantity
from pipeline.scene.units import si_unit, to_si

_FEWEST, _MOST = 6, 17  # digits of a number


def entries_of(kind: Kind, value: Any) -> Any:
    """Entries that read as a value of a kind, defaults among them; None where there is none."""
    match kind:
        case _ if value is None or value == math.inf or value == ():
            return None
        case Either():
            return entries_of(_form_of(kind, value), value)
        case Table(keys):
            texts = {key: entries_of(one.kind, getattr(value, key)) for key, one in keys.items()}
            return {key: text for key, text in texts.items() if text is not None}
        case List(of):
            return [entries_of(of, one) for one in value]
        case Tables(of) | ByPath(of):
            return {key: entries_of(of, one) for key, one in value.items()}
        case Quantity():
            return _quantity_text(kind, value)
    return value


def complete_fidelity(preset: str, made: tribo.Fidelity) -> Any:
    """The table of numerical choices with each of them, and the preset's name beside them."""
    choices = [key for key in table_of(Fidelity).keys if key != "preset"]
    return Fidelity(preset=preset, **{key: getattr(made, key) for key in choices})


def _form_of(kind: Either, value: Any) -> Kind:
    """The one of several kinds as which a value was read."""
    for one in kind.kinds:
        is_table = isinstance(one, Table) and isinstance(value, one.make)  # type: ignore[arg-type]
        if is_table or (isinstance(one, List) and isinstance(value, tuple)):
            return one
    return kind.kinds[0]


def _quantity_text(kind: Quantity, value: float) -> str:
    """A quantity in the unit of its example, in as few digits as read as the same number."""
    unit, zero = kind.unit, float(ZERO.get(kind.unit, 0))
    one = 1.0 if zero else to_si(f"1 {unit}", kind.example)
    texts = (f"{(value - zero) / one:.{digits}g} {unit}" for digits in range(_FEWEST, _MOST + 1))
    exact = f"{value!r} {next(iter(DIMENSIONS[si_unit(kind.example)].units))}"
    return next((text for text in texts if to_si(text, kind.example) == value), exact)
