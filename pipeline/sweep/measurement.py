"""Tests on rigs that a scene names: transitions, and outcomes that were mild or severe."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import asdict, dataclass
from typing import Any, Literal

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

    @classmethod
    def of(cls, entry: Mapping[str, Any]) -> Measurement:
        """Make a test from its `entry` in a scene, with values in SI."""
        names = {k: str(entry[k]) for k in ("number", "run") if entry.get(k) is not None}
        own = {"normal_load" if k == "load" else k: v for k, v in entry.items() if k != "oil"}
        return cls(**own | names)

    def as_dict(self) -> dict[str, Any]:
        """Return the fields as plain data, without those that are None (except friction)."""
        always = ("normal_load", "velocity", "friction")
        return {k: v for k, v in asdict(self).items() if v is not None or k in always}
