"""Names that laboratories use for quantities, and quantities computed from others."""

from __future__ import annotations

import functools
import re
import tomllib
from collections.abc import Collection, Mapping, Sequence
from dataclasses import dataclass, field
from importlib import resources
from typing import Any, NamedTuple

import numpy as np

from pipeline.scene.faults import quoted
from pipeline.scene.names import BESIDE, UNITS, Heading, Names
from pipeline.scene.sheet import Sheet

_STEEPEST = 2.0  # largest slide-roll ratio: one surface at rest


class Derived(NamedTuple):
    """Rule to compute the quantity `name` from the quantities `inputs`, all in SI."""

    name: str
    inputs: tuple[str, ...]
    make: Any


RULES = (
    Derived("velocity", ("rotation", "track_radius"), lambda n, r: np.abs(n) * r),
    Derived("velocity", ("rotation", "track_diameter"), lambda n, d: np.abs(n) * d / 2),
    Derived("velocity", ("frequency", "stroke"), lambda f, s: 2 * f * s),
    Derived("velocity", ("slide_roll_ratio", "rolling_velocity"), lambda s, u: np.abs(s * u)),
    Derived("velocity", ("velocity_1", "velocity_2"), lambda u, v: np.abs(u - v)),
    Derived("velocity", ("rotation_1", "rotation_2", "disc_diameter"),
         lambda m, n, d: np.abs(m - n) * d / 2),
    Derived("friction", ("friction_force", "load"), lambda f, load: np.abs(f / load)),
    Derived("friction", ("friction_torque", "load", "track_radius"), lambda m, F, r: m / F / r),
)  # fmt: skip
"""Rules in order of priority: a quantity is computed by its first rule whose inputs are known."""
INGREDIENTS = [*dict.fromkeys(x for rule in RULES for x in rule.inputs if x not in UNITS)]


class Patterns(NamedTuple):
    """SI unit of a quantity (None for text), and patterns that headings must and must not match."""

    unit: str | None
    named: re.Pattern[str]
    other: re.Pattern[str]


@functools.cache
def vocabulary() -> Mapping[str, Any]:
    """Contents of ``words.toml``: words for a test's outcome, and patterns of column headings.

    The patterns are regular expressions, by the name of the quantity that a column has. The words
    are those that tables use for mild and severe wear, such as "passed" and "scuffed".
    """
    text = resources.files("pipeline.laboratory").joinpath("words.toml").read_text("utf-8")
    return tomllib.loads(text)


@functools.cache
def patterns_of(name: str) -> Patterns | None:
    """Unit of a quantity, and patterns that find its heading; None if ``words.toml`` lacks it."""
    table = vocabulary().get(name)
    if not isinstance(table, dict):
        return None
    return Patterns(table.get("unit"), re.compile(table["is"]), re.compile(table.get("not", "$^")))


def units_of(names: Collection[str]) -> dict[str, str | None]:
    """SI unit of each quantity of `names`, None for text."""
    known = {name: patterns_of(name) for name in names}
    return {name: one.unit if one else UNITS.get(name) for name, one in known.items()}


@dataclass(frozen=True)
class WordNames(Names):
    """Find the columns of quantities by words in headings.

    Columns that the user chose, or that an export format names (`exported`, pattern by quantity),
    have precedence.
    """

    exported: Mapping[str, str] = field(default_factory=dict)  # patterns of headings

    def __post_init__(self) -> None:
        object.__setattr__(self, "units", {**units_of(INGREDIENTS), **self.units})

    def match_score(self, name: str, heading: Heading) -> float:
        """How surely a heading names the quantity `name`: 4 at most, 0 for not at all."""
        if name in self.chosen:
            return self.is_chosen(name, heading)
        if not heading.title or not self.fits(name, heading):
            return 0.0
        pattern = self.exported.get(name)
        texts = (heading.text, heading.title)
        if pattern and any(re.fullmatch(pattern, text, re.IGNORECASE) for text in texts):
            return 4.0
        if pattern == "":
            return 0.0
        exact = heading.name
        if exact in self.units and self.fits(exact, heading):
            return 3.0 * (exact == name)
        title = re.sub(r"[\W_]+", " ", heading.title.lower()).strip()
        known = patterns_of(name)
        if known is None or heading.title.startswith(BESIDE):
            return 0.0
        if not known.named.search(title) or known.other.search(title):
            return 0.0
        if known.unit and not heading.unit and len(title) < 3:
            return 0.0  # one or two letters, such as t or v, are ambiguous without a unit
        is_doubtful = len(title) == 1 or re.search(vocabulary()["wished"], title)
        return (2 if heading.unit else 1) - 0.5 * bool(is_doubtful)

    def columns(self, headings: Sequence[Heading]) -> tuple[dict[str, int], dict[str, str]]:
        """Column number by quantity, found from the headings, and faults by quantity.

        Faults of quantities that are not needed are left out.
        """
        places, faults = super().columns(headings)
        made = {x for rule in RULES if rule.name in places for x in rule.inputs}
        wanted = {x for rule in RULES if rule.name not in places for x in rule.inputs}
        idle = made - wanted - {"load"}
        return places, {name: fault for name, fault in faults.items() if name not in idle}


def derive(sheet: Sheet, needed: Collection[str] = ()) -> dict[str, str]:
    """Add columns to a sheet that follow from other columns, such as velocity from rotation.

    Returns, by quantity, a message on the input that is missing to compute it. For quantities in
    `needed` this message is also added to the sheet's faults.
    """
    missing = dict[str, str]()
    for name in [one for one in dict.fromkeys(rule.name for rule in RULES) if one in sheet.units]:
        rules = [rule for rule in RULES if rule.name == name and name not in sheet.places]
        ready = [rule for rule in rules if {*rule.inputs} <= sheet.places.keys()]
        begun = [rule for rule in rules if {*rule.inputs} & (sheet.places.keys() - {"load"})]
        if ready:
            _add_derived(sheet, ready[0])
        elif begun:
            inputs = begun[0].inputs
            lacks = [one for one in inputs if one not in sheet.places]
            has = quoted(sheet.heading(next(x for x in inputs if x in sheet.places)).text)
            options = " ".join(f'--given "{one}=... {sheet.units[one]}"' for one in lacks)
            missing[name] = (
                f"{name} follows from {has} and {' and '.join(lacks)}, which is missing; give "
                f"{options}, or a column"
            )
    sheet.faults += [words for name, words in missing.items() if name in needed]
    return missing


def _add_derived(sheet: Sheet, rule: Derived) -> None:
    """Add the column that a rule computes, unless the inputs have faults."""
    before = len(sheet.faults)
    inputs = {one: sheet.numbers(one) for one in rule.inputs}
    ratio = inputs.get("slide_roll_ratio")
    if ratio is not None and np.nanmax(np.abs(ratio), initial=0.0) > _STEEPEST:
        text = sheet.heading("slide_roll_ratio").text
        sheet.faults.append(
            f"column {quoted(text)} is above 2, the largest possible; if it is in percent, name it "
            f'--column "slide_roll_ratio={text} [%]"'
        )
    if len(sheet.faults) > before:
        return
    with np.errstate(divide="ignore", invalid="ignore"):
        values = rule.make(*inputs.values())
    sheet.sources |= {sheet.places[one] for one in rule.inputs}
    texts = [f"{value:.12g}" if np.isfinite(value) else "" for value in values]
    sheet.add(rule.name, sheet.units[rule.name] or "", texts)
    sheet.form.append(f"{rule.name} from {' and '.join(rule.inputs)}")
