"""Tests on rigs that a scene names: transitions, and outcomes that were mild or severe."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import asdict, dataclass, replace
from typing import Any, Literal

_UNNAMED = "without a name"  # name of the oil of tests that name none, in a scene of another oil
OUTCOMES = ("mild", "severe")
"""Outcomes of a test; a transition has none."""


@dataclass(frozen=True, slots=True)
class Measurement:
    """A test on a rig: a measured transition to severe wear, or a point with its outcome."""

    normal_load: float  # on the whole pin [N]
    velocity: float  # [m/s]
    friction: float | None = None
    velocity_scatter: float | None = None  # standard deviation [m/s]
    bulk_temperature: float | None = None  # the same in both bodies [K]
    hold: float | None = None  # at the full load [s]
    outcome: Literal["mild", "severe"] | None = None  # None at a transition
    number: str | None = None  # number or name in answers
    run: str | None = None  # shared by the tests of one specimen
    oil: str | None = None  # the scene's if None

    @classmethod
    def of(cls, entry: Mapping[str, Any]) -> Measurement:
        """Make a test from its `entry` in a scene, with values in SI."""
        names = {k: str(entry[k]) for k in ("number", "run", "oil") if entry.get(k) is not None}
        return cls(**{"normal_load" if k == "load" else k: v for k, v in entry.items()} | names)

    def under_oil(self, oil: str | None) -> Measurement:
        """Copy of the test for a scene with the oil named `oil`; the same test if `oil` is None.

        The field `oil` of the copy is None if the test ran on the scene's oil. Otherwise the field
        is the name of the oil on which the test ran, or "without a name" if the test names none.
        """
        if oil is None:
            return self
        name = self.oil or _UNNAMED
        return replace(self, oil=None if name == oil else name)

    def as_dict(self) -> dict[str, Any]:
        """Return the fields as plain data, without those that are None (except friction)."""
        always = ("normal_load", "velocity", "friction")
        return {k: v for k, v in asdict(self).items() if v is not None or k in always}


def oils_of(names: Iterable[str | None]) -> list[str]:
    """Names of the oils of tests, each once and sorted; "" is the scene's oil."""
    return sorted({name or "" for name in names})


def own_tests(tests: Sequence[Measurement]) -> tuple[Measurement, ...]:
    """Tests that do not name an oil; if all do, tests of the oil that is first in the alphabet."""
    first, *_ = [*oils_of(test.oil for test in tests), ""]
    return tuple(test for test in tests if (test.oil or "") == first)
