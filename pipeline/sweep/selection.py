"""A fidelity picked for its accuracy, and the reasons, which are stored with the results."""

from __future__ import annotations

import math
import operator
from dataclasses import asdict, dataclass
from typing import Any

from pipeline.sweep.shown import shown
from tribo import PRESETS, Fidelity
from tribo.simulation.element_size import TIGHTEST
from tribo.simulation.parts_of_steps import ENOUGH_STEPS

KEPT_FIELDS = ("heat_model",)
"""Fields of a scene's own fidelity that it keeps: how heat acts."""

PRESET_BOUNDS = {"draft": 0.05, "standard": 0.015, "fine": 0.005, "reference": 0.005}
"""Relative error of the boundary velocity that a preset is to keep to, see CHOOSING.md.

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
"""How a field compares with that of a coarser preset; the other fields must be equal."""


def preset_of(fidelity: Fidelity) -> str | None:
    """Finest preset whose promise numerical choices keep, since none is coarser; None for none."""
    names = (name for name in reversed(PRESET_BOUNDS) if _is_as_fine(fidelity, PRESETS[name]))
    return next(names, None)


def _is_as_fine(fidelity: Fidelity, preset: Fidelity) -> bool:
    """True if no field is coarser than that of a preset, except those that a scene keeps."""
    without_effect = {*KEPT_FIELDS}
    if fidelity.pixels_per_element == 1:
        without_effect |= {"averaging", "fewest_summits"}
        if fidelity.history_coarsening == 1 and fidelity.contact_tolerance <= TIGHTEST:
            without_effect |= {"elements_per_summit", "fewest_elements"}
    own, least = (_acting(one) for one in (fidelity, preset))
    return all(
        _FINER.get(name, operator.eq)(value, least[name])
        for name, value in own.items()
        if name not in without_effect
    )


def _acting(fidelity: Fidelity) -> dict[str, Any]:
    """Fields as they act: steps of a hold are those of the ramp if 0, and no step is cut if 0."""
    whole = 0.0 if fidelity.increments >= ENOUGH_STEPS else math.inf
    return asdict(fidelity) | {
        "hold_increments": fidelity.hold_increments or fidelity.increments,
        "imprint": fidelity.imprint or whole,
    }


@dataclass(frozen=True, slots=True)
class Trial:
    """A fidelity that was tried, and by how much it moves the boundary velocity at most."""

    name: str
    fidelity: Fidelity
    error: float  # largest of the boundary velocity to expect, relative
    seconds: float  # processor time of the points of the probe [s]


@shown
@dataclass(frozen=True, slots=True)
class Selection:
    """The fidelity that was picked, and why; or the scene's own, and its error."""

    #: Largest relative error of the boundary velocity that was asked for; None of the scene's own.
    accuracy: float | None
    name: str  #: Name of the fidelity, as shown to the user.
    fidelity: Fidelity  #: The numerical choices.
    error: float  #: Largest relative error to expect, with what the yardstick itself may err.
    #: Largest relative change by elements of twice the pixels' size, against which the error does
    #: not count; None where pixels cannot be joined.
    coarser: float | None
    trials: tuple[Trial, ...]  #: Fidelities tried, from cheap to dear; the last one was picked.
    points: tuple[tuple[float, float], ...]  #: Loads [N] and velocities [m/s] of the probe.
    exact_seconds: float  #: Processor time of nearly exact steps at these points [s].
    seconds: float  #: Duration of the probe [s].

    def as_dict(self) -> dict[str, Any]:
        """Return all fields as plain data."""
        places = [{"load": load, "velocity": velocity} for load, velocity in self.points]
        return asdict(self) | {"points": places}

    @property
    def largest_error(self) -> float:
        """Largest relative error of the boundary velocity that is known."""
        return max(self.error, self.coarser or 0.0)

    def __str__(self) -> str:
        err = f"errs by at most {100 * self.error:.2g} % at any load"
        if self.largest_error > self.error:
            err = (
                f"errs by up to {100 * self.largest_error:.3g} %, the change with elements of "
                "twice the pixels' size: give smaller pixels"
            )
        if self.accuracy is not None and self.error > self.accuracy:
            err += ", more than asked for: nothing finer is known"
        tried = ", ".join(
            f"{trial.name} {100 * trial.error:.2g} % in {trial.seconds:.2g} s"
            for trial in self.trials[:-1]
        )
        why = f" (not accurate enough: {tried})" if tried else ""
        seconds = f"{self.trials[-1].seconds:.2g} s for the points of the probe"
        alone = "" if self.coarser is not None else "; its pixels cannot be joined to larger ones"
        picked = self.name
        if self.accuracy is not None:
            picked = f"accuracy {100 * self.accuracy:g} %: picked {self.name}"
        return (
            f"{picked}, whose boundary velocity "
            f"{err}, in {seconds}, nearly exact steps in {self.exact_seconds:.2g} s{why}{alone}; "
            f"the probe took {self.seconds:.1f} s"
        )
