"""Tests of a scene, numbers from the library, and words on when wear is severe."""

from __future__ import annotations

from collections.abc import Collection, Iterable, Iterator, Mapping, Sequence
from dataclasses import asdict, dataclass, replace
from typing import Any, Literal, NamedTuple

from pipeline.quantities import display
from pipeline.sweep.conditions import PATHS, Conditions
from pipeline.sweep.shown import Line

_UNNAMED = "without a name"  # oil of tests that name none, in a scene of another
OUTCOMES = ("mild", "severe")
"""Outcomes of a test; a transition has none."""


@dataclass(frozen=True, slots=True)
class Measurement:
    """A test on a rig: a transition to severe wear, or a point that was mild or severe."""

    normal_load: float  # on the whole pin [N]
    velocity: float  # [m/s]
    friction: float | None = None
    velocity_scatter: float | None = None  # standard deviations [m/s, 1]
    friction_scatter: float | None = None
    bulk_temperature: float | None = None  # the same in both bodies [K]
    hold: float | None = None  # at the full load [s]
    outcome: Literal["mild", "severe"] | None = None  # None at a transition
    number: str | None = None  # by which answers call it
    run: str | None = None  # shared by the tests of one specimen
    oil: str | None = None  # the scene's if None

    @classmethod
    def of(cls, entry: Mapping[str, Any]) -> Measurement:
        """The test of an entry of a scene."""
        names = {k: str(entry[k]) for k in ("number", "run", "oil") if entry.get(k) is not None}
        return cls(**{"normal_load" if k == "load" else k: v for k, v in entry.items()} | names)

    def under_oil(self, oil: str | None) -> Measurement:
        """The test in a scene of an oil, which its tests do not name; itself if None."""
        if oil is None:
            return self
        name = self.oil or _UNNAMED
        return replace(self, oil=None if name == oil else name)

    def as_dict(self) -> dict[str, Any]:
        """Return all fields as plain data, of those after the friction only what is known."""
        always = ("normal_load", "velocity", "friction")
        return {k: v for k, v in asdict(self).items() if v is not None or k in always}


def oils_of(names: Iterable[str | None]) -> list[str]:
    """Oils of tests in the order of their names, first the scene's: empty, of tests without one."""
    return sorted({name or "" for name in names})


def own_tests(tests: Sequence[Measurement]) -> tuple[Measurement, ...]:
    """Tests of the scene's own oil; of the first by name where all name theirs."""
    first, *_ = [*oils_of(test.oil for test in tests), ""]
    return tuple(test for test in tests if (test.oil or "") == first)


class FromLibrary(NamedTuple):
    """A number that a scene takes from the library: key path, value with unit, and its source."""

    key: str
    value: str
    source: str


def library_tables(taken: Iterable[FromLibrary]) -> Iterator[tuple[str, str]]:
    """Numbers of each table that are from one source, in words, and that source."""
    tables: dict[tuple[str, str], list[str]] = {}
    for key, value, source in taken:
        table, _, name = key.rpartition(".")
        tables.setdefault((table, source), []).append(f"{name.replace('_', ' ')} {value}")
    for (table, source), values in tables.items():
        yield f"{table}: {', '.join(values)}", source


def condition_rows(conditions: Conditions, drawn: Collection[str] = ()) -> Iterator[Line]:
    """Say when wear is severe, a row for each subject; of paths that are drawn, that they are."""
    bulk = f"bulk {display(conditions.bulk_temperature, '°C')}"
    if conditions.disk_temperature is not None:
        bulk += f" (pin) and {display(conditions.disk_temperature, '°C')} (disk)"
    if any(path.startswith(PATHS["bulk_temperature"]) for path in drawn):
        bulk = "bulk of each sample"
    friction = f"{conditions.friction:g}"
    yield "friction", f"{'of each sample' if PATHS['friction'] in drawn else friction}, {bulk}"
    if conditions.corrections:
        yield "corrections", conditions.corrections.text
    if conditions.critical_temperature is not None:
        yield "severe", severe_words(conditions, drawn)


def judged_by(several: Iterable[Conditions], drawn: Collection[str] = ()) -> str:
    """Say in a line when wear is severe under some conditions, each part of them once."""
    each = [
        (
            severe_words(one, drawn),
            " ".join(next(condition_rows(one, drawn))),
            one.corrections.text if one.corrections else "no correction",
        )
        for one in several
    ]
    parts = [" or ".join(dict.fromkeys(part)) for part in zip(*each, strict=True)]
    return f"severe wear: {'; '.join(part for part in parts if part != 'no correction')}"


def severe_words(conditions: Conditions, drawn: Collection[str] = ()) -> str:
    """When wear is severe; of paths that are drawn, that they are those of each sample."""
    severe = conditions.decisive.severe
    if PATHS["share"] in drawn:
        severe = "more than the share of each sample of its contact above"
    critical = display(conditions.known_critical_temperature(), "°C")
    if conditions.critical_sd:
        critical = f"{critical} ± {display(conditions.critical_sd, 'K', 3)}"
    if PATHS["critical_temperature"] in drawn:
        critical = "the critical temperature of each sample"
    return f"{severe} {critical}"
