"""Headings of tables, and the quantities that they name."""

from __future__ import annotations

import re
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from typing import NamedTuple

from pipeline.quantities import units_in_si
from pipeline.scene.faults import quoted
from pipeline.scene.units import is_unit, unit_of_table
from pipeline.sweep.conditions import FIELDS

UNITS = units_in_si(
    "load", "velocity", "friction", "bulk_temperature", "hold", "time", "friction_force",
    "critical_temperature", "failing_share",
)  # fmt: skip
"""SI units of quantities by name; empty for a plain number."""
_EXACT = {
    "normal_load": "load", "sliding_velocity": "velocity", "bulk": "bulk_temperature",
    **{path: name for name, path in FIELDS.items() if name in UNITS},
}  # fmt: skip
BESIDE = "friction.", "temperature."
"""Beginnings of the paths of entries, by which a heading names its quantity exactly."""
_WITH_UNIT = (
    r"(.*?)\s*\[([^\[\]]*)\]", r"(.*?)\s*\(([^()]*(?:\([^()]*\)[^()]*)?)\)", r"(.*?)\s+in\s+(\S.*)",
    r"(.*?)\s+/\s*(\S.*)", r"([^/]*?),?\s+(\S+)",
    r"(.*?)_(k?N|kgf?|g|m?s|sec|min|h|mps|m?m[/_]s|degC|[CK]|rpm|Hz|[mu]m)",
    r"([^/]*?)/(\S.*)", r"(.*?)\s*,\s*(\S.*)",
)  # fmt: skip
"""Patterns of a title with a unit behind it; they count only if that is a unit."""


class Heading(NamedTuple):
    """Heading of a column: its text in the file, its title without the unit, and the unit."""

    text: str
    title: str
    unit: str

    @classmethod
    def of(cls, text: str) -> Heading:
        """Split a heading into title and unit.

        Examples
        --------
        >>> Heading.of("Normal load (kN)")[1:], Heading.of("F_N / N")[1:], Heading.of("COF")[1:]
        (('Normal load', 'kN'), ('F_N', 'N'), ('COF', ''))
        """
        text = text.strip().strip('"')
        for way in _WITH_UNIT:
            if (match := re.fullmatch(way, text)) and match[1]:
                unit = unit_of_table(match[2])
                if way is _WITH_UNIT[0] or (is_unit(unit) if unit else text[-1] == ")"):
                    return cls(text, match[1].strip(" /"), unit)
        return cls(text, text, "")

    @property
    def name(self) -> str:
        """Name of the quantity that the heading's title names, else the title in snake case."""
        name = self.title.lower().replace(" ", "_")
        return _EXACT.get(name, name)


@dataclass(frozen=True)
class Names:
    """Quantities to look for in a table, with their SI units; None stands for text.

    Columns are found by their headings; `chosen` has those that the user chose, by quantity.
    """

    units: Mapping[str, str | None]
    chosen: Mapping[str, str] = field(default_factory=dict)

    def match_score(self, name: str, heading: Heading) -> float:
        """How surely a heading names the quantity `name`: higher is surer, 0 is not at all."""
        if name in self.chosen:
            return self.is_chosen(name, heading)
        return 3.0 if self.fits(name, heading) and heading.name == name else 0.0

    def is_chosen(self, name: str, heading: Heading) -> float:
        """1 if the user chose the column with this heading for the quantity `name`, else 0."""
        head = self.chosen[name]
        return float(bool(heading.text) and heading.text in (head, Heading.of(head).title))

    def fits(self, name: str, heading: Heading) -> bool:
        """True if the unit in a heading, if it has one, suits the quantity `name`."""
        unit, like = heading.unit, self.units[name]
        return not unit or (not is_unit(unit) if like is None else is_unit(unit, like))

    def count(self, headings: Sequence[Heading]) -> int:
        """Number of columns in which quantities are found by their headings."""
        return len({*self.columns(headings)[0].values()})

    def columns(self, headings: Sequence[Heading]) -> tuple[dict[str, int], dict[str, str]]:
        """Column number by quantity, found from the headings, and faults by quantity.

        A quantity has a fault if several headings fit it equally well.
        """
        places, faults = dict[str, int](), dict[str, str]()
        for name in self.units:
            sure = [self.match_score(name, heading) for heading in headings]
            best = max(sure, default=0.0)
            found = [k for k, rank in enumerate(sure) if rank == best > 0]
            if found:
                places[name] = found[0]
            if len(found) > 1:
                several = ", ".join(quoted(headings[k].text) for k in found)
                way = f'--column "{name}={headings[found[0]].text}"'
                faults[name] = f"{len(found)} columns may be {name}: {several}; choose by {way}"
        return places, faults
