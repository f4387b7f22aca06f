"""A step repeated with a short implicit end, where the wear scheme gets its last pressure wrong.

Where whole rows of elements come into contact at a time, as under heavy wear of smooth bodies, the
rise at the end of the loading would be off by up to 4 %, however many steps there are.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from tribo.constants import IMPLICIT_END, NEW_LOAD, RIM_PRESSURE
from tribo.loading import LoadStep
from tribo.simulation.loading_step import advance
from tribo.simulation.parts_of_steps import between
from tribo.simulation.scene import Scene
from tribo.simulation.state import State
from tribo.types import Mask
from tribo.wear import WEAR_SCHEMES


def end_implicitly(
    scene: Scene, before: State, after: State, load_step: LoadStep, velocity: float
) -> State:
    """Repeat a step, its last sixth by the implicit wear scheme, if much new area touches.

    The step leads from the state `before` to the state `after`, at `load_step`, on one grid.
    Returns the new state at the load step, or `after` if nothing was repeated.
    """
    if not _comes_into_contact(scene, before, after, velocity):
        return after
    near = after.pressure
    middle = advance(scene, before, between(before, load_step, 1 - IMPLICIT_END), velocity, near)
    end = advance(scene, middle, load_step, velocity, near, scheme="implicit")
    states = (after, middle, end)
    return replace(
        end,
        iterations=sum(state.iterations for state in states),
        residual=max(state.residual for state in states),
        history=after.history or after,
    )


def _comes_into_contact(scene: Scene, before: State, after: State, velocity: float) -> bool:
    """True if elements that were unloaded before a step carry much of the load after it."""
    stages = len(WEAR_SCHEMES[scene.fidelity.wear_scheme].weights)
    # Not a pin that rolls: it wears alike all around, and its shape does not follow the pressure.
    is_idle = not scene.wears or not after.normal_load
    if is_idle or stages == 1 or scene.sweeps_over or scene.windows_worn(velocity) > 1:
        return False
    worn = _is_worn(scene, after)
    new = worn & ~_is_worn(scene, before)
    # An element that comes into contact between the stages has to lose in the last one what it did
    # not lose in the first, and there carries up to (1 − γ)/γ = 2.4 times its share. The worn shape
    # is right all the same, since the next stages make up for it.
    load = float(after.pressure[new].sum() / after.pressure.sum())
    return load > max(NEW_LOAD, RIM_PRESSURE * np.count_nonzero(new) / np.count_nonzero(worn))


def _is_worn(scene: Scene, state: State) -> Mask:
    """True at elements of the pin that the pressure of a state wears, shape (nx, ny)."""
    touched: Mask = state.pressure > 0
    if scene.contact_pattern == "swept":
        touched = touched | touched.any(axis=1, keepdims=True)
    return touched
