"""Entries of a scene that take several values each, and the scenes with every combination."""

from __future__ import annotations

import itertools
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any

Label = float | int | str
"""Value along a dimension in front of load and velocity."""
Variant = tuple[tuple[str, Label], ...]
"""Names of the dimensions in front of load and velocity, and a value of each."""


@dataclass(frozen=True, slots=True)
class Axis:
    """An entry and its values."""

    path: str  # its name as a dimension
    values: tuple[float | str, ...]  # ascending [SI]; or words, in the order of the scene
    written: tuple[Any, ...]  # as they stand in the scene
    unit: str | None  # of SI; None for words


@dataclass(frozen=True, slots=True)
class Over:
    """Entries with several values each, and the scenes that follow from them.

    For each combination of values, those of the last entry first: the fields of the `Sweep` that
    differ from its own, and the first combination with the same contacts at all velocities.
    """

    axes: tuple[Axis, ...]
    parts: Mapping[Variant, tuple[tuple[str, Any], ...]] = field(hash=False)
    leads: Mapping[Variant, Variant] = field(hash=False)

    @property
    def note(self) -> str:
        """Note that a command prints which computes one value of each entry alone."""
        return "sweep.over is set aside; " + ", ".join(
            f'{axis.path} is the scene\'s own or the first listed: --set "{axis.path}=..." '
            "takes another"
            for axis in self.axes
        )

    def written(self, variant: Variant) -> list[Any]:
        """Values of a combination as they stand in the scene."""
        return [
            axis.written[axis.values.index(value)]
            for axis, (_, value) in zip(self.axes, variant, strict=True)
        ]


def combinations(axes: Mapping[str, Sequence[Label]]) -> tuple[Variant, ...]:
    """Every combination of the values of some dimensions; one, ``()``, of no dimensions.

    Examples
    --------
    >>> combinations({"realization": (3, 4)})
    ((('realization', 3),), (('realization', 4),))
    """
    return tuple(
        tuple(zip(axes, values, strict=True)) for values in itertools.product(*axes.values())
    )
