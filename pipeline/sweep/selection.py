"""Numerical choices (`tribo.Fidelity`): what presets promise, and what was measured."""

from __future__ import annotations

import math
import operator
from dataclasses import asdict, dataclass
from typing import Any

from tribo import PRESETS, Fidelity
from tribo.simulation.element_size import TIGHTEST
from tribo.simulation.parts_of_steps import ENOUGH_STEPS

KEPT_FIELDS = ("heat_model",)
"""Fields of a scene's own fidelity that stay when another one is picked: how heat acts."""

PRESET_BOUNDS = {"draft": 0.05, "standard": 0.015, "fine": 0.005, "reference": 0.005}
"""Relative error of the critical velocity that each preset promises, see CHOOSING.md.

Judged by `make promises`.
"""


_FINER = {
    "pixels_per_element": operator.le,
    "history_coarsening": operator.le,
    "elements_per_summit": operator.ge,
    "fewest_summits": operator.ge,
    "fewest_elements": operator.ge,
    "increments": operator.ge,
    "hold_increments": operator.ge,
    "imprint": operator.le,
    "contact_tolerance": operator.le,
    "heat_tolerance": operator.le,
}
"""Comparison by which a field is as fine as a preset's; other fields must be equal."""


def preset_of(fidelity: Fidelity) -> str | None:
    """Name of the finest preset that all numerical choices match or exceed; None without one."""
    names = (name for name in reversed(PRESET_BOUNDS) if _is_as_fine(fidelity, PRESETS[name]))
    return next(names, None)


def _is_as_fine(fidelity: Fidelity, preset: Fidelity) -> bool:
    """True if all numerical choices that matter are at least as fine as those of a preset."""
    without_effect = {*KEPT_FIELDS}
    if fidelity.pixels_per_element == 1:
        without_effect |= {"averaging", "fewest_summits"}
        if fidelity.history_coarsening == 1 and fidelity.contact_tolerance <= TIGHTEST:
            without_effect |= {"elements_per_summit", "fewest_elements"}
    own, least = (_effective_fields(one) for one in (fidelity, preset))
    return all(
        _FINER.get(name, operator.eq)(value, least[name])
        for name, value in own.items()
        if name not in without_effect
    )


def _effective_fields(fidelity: Fidelity) -> dict[str, Any]:
    """Numerical choices by name; a 0 of special meaning is replaced by what it stands for."""
    whole = 0.0 if fidelity.increments >= ENOUGH_STEPS else math.inf
    return asdict(fidelity) | {
        "hold_increments": fidelity.hold_increments or fidelity.increments,
        "imprint": fidelity.imprint or whole,
    }


@dataclass(frozen=True, slots=True)
class Choice:
    """One set of numerical choices: its cost, and its error compared with the reference set."""

    name: str  # a preset's, or "the scene's own fidelity"
    fidelity: Fidelity
    velocity_errors: tuple[float, ...]  # relative, of the boundary at each point, with sign
    velocity_error: float  # largest at any point, without sign
    error_at_any_load: float  # largest error to expect: at the points, plus a margin
    seconds: float  # processor time of the points [s]
