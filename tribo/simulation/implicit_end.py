"""Steps repeated with a short implicit end if the wear scheme gets the last pressure wrong.

Where whole rows of elements come into contact at a time, as under heavy wear of smooth bodies, the
rise at the end of the loading would be off by up to 4 %, however many steps there are.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from tribo.constants import IMPLICIT_END, NEW_LOAD_SHARE, RIM_PRESSURE
from tribo.loading import LoadStep
from tribo.simulation.loading_step import advance
from tribo.simulation.parts_of_steps import interpolate_step
from tribo.simulation.scene import Scene
from tribo.simulation.state import State
from tribo.types import Mask


def end_implicitly(
    scene: Scene, before: State, after: State, load_step: LoadStep, velocity: float
) -> State:
    """Repeat a step, its last sixth by the implicit wear scheme, if much new area touches.

    The step leads from the state `before` to the state `after`, at `load_step`, on one grid.
    Returns the new state at the load step, or `after` if nothing was repeated.
    """
    if not _gains_contact(scene, before, after, velocity):
        return after
    guess, observed = after.pressure, not scene.wears_by_strips
    first_part = interpolate_step(before, load_step, 1 - IMPLICIT_END)
    middle = advance(scene, before, first_part, velocity, guess, observed)
    end = advance(scene, middle, load_step, velocity, guess, observed, scheme="implicit")
    states = (after, middle, end)
    return replace(
        end,
        iterations=sum(state.iterations for state in states),
        residual=max(state.residual for state in states),
        history=after.history or after,
    )


def _gains_contact(scene: Scene, before: State, after: State, velocity: float) -> bool:
    """True if elements that were unloaded before a step carry much of the load after it."""
    # A rolling pin wears evenly around its track, so that its shape does not follow the pressure.
    is_unworn = not scene.wears or not after.normal_load
    if is_unworn or scene.sweeps_over or scene.windows_worn(velocity) > 1:
        return False
    worn = _is_worn(scene, after)
    newly_worn = worn & ~_is_worn(scene, before)
    # An element that comes into contact between the stages makes up in the last stage for the wear
    # that it missed in the first, and carries up to (1 − γ)/γ = 2.4 times its share there. The worn
    # shape is still right, since the next stages compensate.
    load = float(after.pressure[newly_worn].sum() / after.pressure.sum())
    return load > max(
        NEW_LOAD_SHARE, RIM_PRESSURE * np.count_nonzero(newly_worn) / np.count_nonzero(worn)
    )


def _is_worn(scene: Scene, state: State) -> Mask:
    """True at elements of the pin that the pressure of a state wears, shape (nx, ny)."""
    touched: Mask = state.pressure > 0
    if scene.contact_pattern == "swept":
        touched = touched | touched.any(axis=1, keepdims=True)
    return touched
