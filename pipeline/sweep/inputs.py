"""Uncertain inputs of a scene: entries with a standard uncertainty, and the points that need them.

The input is ln(value), or a temperature in kelvin. A simulated input is one further case, in which
its value is larger by one standard uncertainty; conditions act after the simulation and need none.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from typing import NamedTuple

from pipeline.quantities import display
from pipeline.sweep.measurement import Case, Measurement

CRITICAL = "temperature.critical"
"""Entry that may also be found from tests alone."""
RISE = "model.rise"
"""Entry whose uncertainty is a part of the rise."""
Place = tuple[float, float]
"""Load [N] and velocity [m/s]."""
_FACTORS = 0.5  # standard uncertainty of ln(value) from which a factor says it


@dataclass(frozen=True, slots=True)
class Input:
    """An entry whose value is uncertain.

    `spread` is the standard uncertainty: of ln(value), or in kelvin of a temperature. Without one
    the value comes from the tests alone.
    """

    path: str
    text: str  # the uncertainty as written, such as "20 %"
    value: float  # [SI]
    unit: str  # in which the value is shown
    spread: float | None
    is_kelvin: bool = False
    #: The scene, and each test by its number, with the value larger by one standard uncertainty.
    case: Case | None = field(default=None, compare=False, repr=False)
    tests: Mapping[int, Case] = field(default_factory=dict, compare=False, repr=False, hash=False)

    def words(self, value: float | None = None, width: float | None = None) -> str:
        """Value and standard uncertainty in words, such as "45 W/(m K) ± 20 %"; as given if None.

        `width` is in the unit of `spread`.
        """
        value = self.value if value is None else value
        if self.path == RISE:
            shown = f"{100 * value:+.3g} %"
        else:
            shown = display(value, self.unit, 4) if self.unit else f"{value:.3g}"
        if width is None:
            text = self.text.removeprefix("±").strip()
        elif self.is_kelvin:
            text = f"{width:.2g} K"
        elif width < _FACTORS:
            text = f"{100 * width:.2g} %"
        else:
            text = f"factor {math.exp(width):.2g}"
        return f"{shown} ± {text}".replace("± factor", "×/÷")

    @property
    def is_simulated(self) -> bool:
        """True if the input changes what is simulated."""
        return self.case is not None


class InputPoints(NamedTuple):
    """Points of one case that an uncertain input needs.

    `path` is that of the input, empty for the scene itself; `test` is the number of the test at
    whose places the points are, None for places of the plane.
    """

    simulated: Case
    places: tuple[Place, ...]
    path: str = ""
    test: int | None = None


def spread_places(loads: Sequence[float], velocities: Sequence[float]) -> tuple[Place, ...]:
    """Places of the plane at which inputs are simulated: ends and middle of both axes."""
    moving = [velocity for velocity in velocities if velocity > 0] or [*velocities]
    axes = [
        sorted({axis[0], axis[len(axis) // 2], axis[-1]})
        for axis in (sorted(loads), sorted(moving))
    ]
    return tuple((load, velocity) for load in axes[0] for velocity in axes[1])


def input_points(
    inputs: Sequence[Input], base: Case, places: tuple[Place, ...], tests: Sequence[Measurement]
) -> list[InputPoints]:
    """Points that simulated inputs need: of the scene itself, of each input, and of its tests."""
    simulated = [(one, one.case) for one in inputs if one.case]
    if not simulated:
        return []
    points = [InputPoints(base, places)]
    for one, case in simulated:
        points.append(InputPoints(case, places, one.path))
        points += [
            InputPoints(own, tests[number].places, one.path, number)
            for number, own in one.tests.items()
            if number < len(tests)  # where the tests are left out
        ]
    return points
