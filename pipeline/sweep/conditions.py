"""The conditions under which wear is judged, after the simulation."""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping
from dataclasses import dataclass, fields, replace
from typing import Any

import tribo
from pipeline.quantities import units_in_si
from pipeline.sweep.laws import Law, LawError, name_of
from tribo import Criterion, Friction, InputError, MeasuredLoad, Ramp, Rule
from tribo.simulation.verdict import Judging
from tribo.types import Array

Bulk = float | str | Mapping[str, float | str]
"""A bulk temperature [K] or with a unit; or one for each body, by ``"pin"`` and ``"disk"``."""

PATHS = {
    "friction": "friction.coefficient",
    "bulk_temperature": "temperature.bulk",
    "critical_temperature": "temperature.critical",
    "share": "temperature.failing_share",
    "criterion": "temperature.criterion",
    "unmodelled_rise": "model.rise",
}
"""Entries of the scene file that act after the simulation, by the names of `changes_of`."""
FIELDS = {"failing_share" if name == "share" else name: path for name, path in PATHS.items()}
"""Entries of the scene file that act after the simulation, by the fields of `Conditions`."""
_NUMBERS = (
    "friction", "bulk_temperature", "disk_temperature", "critical_temperature", "failing_share",
    "unmodelled_rise",
)  # fmt: skip
UNITS = {name: unit or "1" for name, unit in units_in_si(*_NUMBERS).items()}
"""Units of the fields that are numbers."""


@dataclass(frozen=True, slots=True)
class Conditions(Judging):
    """Conditions by which points are judged mild or severe.

    They are those of `tribo.Conditions`, with the criterion given by its name and share.

    Attributes
    ----------
    failing_share : float
        Wear is severe if more than this share of the contact area is above the critical
        temperature. The share is at least 0 (Blok's criterion, the maximum temperature) and below
        1.
    criterion : str
        Kind of criterion, one of `tribo.CRITERIA`, or the name of a rule. Only the kind "share"
        uses the failing share.
    rule : Rule, Law or None
        A criterion of your own; a `Law` if it comes from a store, which has only its name. It is
        dropped if `criterion` is not its name.

    Raises
    ------
    InputError
        If a value is out of range; if friction varies, but the bodies have unequal bulk
        temperatures; or if the criterion is unknown, and there is no rule.

    Examples
    --------
    >>> from dataclasses import replace
    >>> white_oil = Conditions(0.1, bulk_temperature=298.15, critical_temperature=418.15)
    >>> replace(white_oil, friction=0.12).failing_share
    0.1
    >>> white_oil.changed(share=0.0).failing_share
    0.0
    """

    failing_share: float = 0.1
    criterion: str = "share"
    rule: Rule | Law | None = None

    def __post_init__(self) -> None:
        if self.rule and name_of(self.rule) != self.criterion:
            object.__setattr__(self, "rule", None)
        for name in UNITS:
            value = getattr(self, name)
            if value is not None and (isinstance(value, Iterable) or not math.isfinite(value)):
                raise InputError(f"{name} is {value!r}; it must be one finite number here")
        own = {one.name: getattr(self, one.name) for one in fields(Judging)}
        criterion = Criterion() if isinstance(self.rule, Law) else self.decisive
        tribo.Conditions(**own, criterion=criterion)  # raises for what is out of range

    @property
    def decisive(self) -> Criterion:
        """Criterion by which wear is judged severe.

        Raises a `LawError` if a store has only the name of the user's criterion.
        """
        if isinstance(self.rule, Law):
            raise LawError(
                f"the store is judged by the criterion {self.criterion}, a Python object, of which "
                "it has only the name; give another criterion, such as --criterion=share, or in "
                "Python pipeline.at(ds, criterion=rule); irg plot --kind=temperature needs none"
            )
        return Criterion(self.criterion, self.failing_share, self.rule)

    def as_dict(self) -> dict[str, Any]:
        """Return the values as plain data, without the rule, whose name is the criterion.

        A disk temperature or corrections that are None are left out.
        """
        plain = {one.name: getattr(self, one.name) for one in fields(self) if one.name != "rule"}
        plain["corrections"] = self.corrections and self.corrections.as_dict()
        rare = ("disk_temperature", "corrections")
        return {k: v for k, v in plain.items() if v is not None or k not in rare}

    def friction_at(self, velocity: float) -> float:
        """Coefficient of friction at a sliding velocity [m/s]."""
        return self.friction * float(self.friction_factor(velocity))

    @property
    def has_friction_curve(self) -> bool:
        """True if friction depends on the velocity."""
        return bool(self.friction_law.by_velocity)

    def friction_factor(self, velocity: Array | float) -> Array:
        """Factor by which to multiply the coefficient `friction`, at sliding velocities [m/s].

        It is 1 unless friction depends on velocity. The shape is that of `velocity`.
        """
        factor: Array = replace(self.friction_law, coefficient=1.0).at(velocity)
        return factor

    def replace_friction(self, friction: float | None) -> Conditions:
        """The conditions with a friction coefficient that was measured at one point.

        It also replaces curves of friction over velocity or temperature. With None nothing changes.
        """
        if friction is None:
            return self
        corrections = self.corrections and replace(self.corrections, friction=Friction())
        return replace(self, friction=friction, corrections=corrections)

    def row_conditions(self, row: Mapping[str, Any]) -> Conditions:
        """The conditions with some values replaced by those in a row of a table.

        A row may have the measured ``friction``, a ``bulk_temperature`` of both bodies [K] and a
        ``critical_temperature`` [K].
        """
        own = self.changed(
            bulk_temperature=row.get("bulk_temperature"),
            critical_temperature=row.get("critical_temperature"),
        )
        return own.replace_friction(row.get("friction"))

    def under(self, loading: Ramp | MeasuredLoad) -> Conditions:
        """The conditions with the load history of `loading` added to their corrections, if any."""
        corrections = self.corrections and self.corrections.under(loading)
        return self if corrections == self.corrections else replace(self, corrections=corrections)

    def known_critical_temperature(self) -> float:
        """Critical temperature [K]; raises an `InputError` if it is not known."""
        if self.critical_temperature is None:
            raise InputError(
                "temperature.critical is missing, and this needs it; add one to the scene, such as "
                'critical = "145 degC", or give --critical-temperature (in Python '
                "critical_temperature) where it is taken"
            )
        return self.critical_temperature

    def changed(self, **changes: Any) -> Conditions:
        """The conditions with some values replaced; keywords are the arguments of `changes_of`."""
        return replace(self, **changes_of(**changes))


def changes_of(
    friction: float | None = None,
    bulk_temperature: float | Mapping[str, float | None] | None = None,
    critical_temperature: float | None = None,
    share: float | None = None,
    criterion: str | Rule | None = None,
    unmodelled_rise: float | None = None,
) -> dict[str, Any]:
    """Values of the fields of `Conditions`, by name, for those arguments that are not None.

    If a share is given without a criterion, the criterion becomes "share".
    """
    entries: dict[str, Any] = {
        "friction": friction,
        "critical_temperature": critical_temperature,
        "failing_share": share,
        "unmodelled_rise": unmodelled_rise,
        "criterion": "share" if criterion is None and share is not None else criterion,
    }
    changes = {name: value for name, value in entries.items() if value is not None}
    if isinstance(criterion, Rule):
        changes |= {"criterion": name_of(criterion), "rule": criterion}
    return changes | ({} if bulk_temperature is None else bulk_entries(bulk_temperature))


def bulk_entries(bulks: float | Mapping[str, float | None] | None) -> dict[str, Any]:
    """Bulk temperatures [K] by name of the field of `Conditions`.

    `bulks` is one temperature of both bodies, or a mapping with the keys "pin" and "disk". The
    field for the disk is None if both bodies have the same temperature.
    """
    if not isinstance(bulks, Mapping):
        return {"bulk_temperature": bulks, "disk_temperature": None}
    if set(bulks) != {"pin", "disk"}:
        raise InputError(
            f"bulk_temperature names {', '.join(map(str, bulks)) or 'no body'}; give one "
            "temperature for both bodies, or one for pin and one for disk"
        )
    disk = bulks["disk"] if bulks["disk"] != bulks["pin"] else None
    return {"bulk_temperature": bulks["pin"], "disk_temperature": disk}
