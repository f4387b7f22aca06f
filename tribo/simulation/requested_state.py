"""States whose temperature is requested: a step repeated on the scene's grid, at all positions.

Steps lead to them on a coarse grid. The last step is repeated on ever finer grids. Before this, it
is repeated with a short implicit end if the wear scheme gets the last pressure wrong: where whole
rows of elements come into contact at a time, as under heavy wear of smooth bodies, the rise at the
end of the loading would be off by up to 4 %, however many steps there are. At last the contact is
solved at further positions of the disk if too few elements touch at one position.
"""

from __future__ import annotations

import itertools
from collections.abc import Iterable
from dataclasses import replace

import numpy as np

from tribo.constants import IMPLICIT_END, NEW_LOAD_SHARE, RIM_PRESSURE
from tribo.loading import LoadStep
from tribo.simulation.disk_positions import Pass, further_positions, passes, separation_at
from tribo.simulation.loading_step import advance, guess_pressure, solve_pass
from tribo.simulation.scene import Scene
from tribo.simulation.state import State
from tribo.simulation.step_wear import interpolate_step, step_wear
from tribo.types import Array, Mask
from tribo.wear import Stage


def refine_step(
    levels: tuple[Scene, ...], before: State, after: State, load_step: LoadStep, velocity: float
) -> State:
    """Repeat the step from `before` to `after` on ever finer grids; return the state on the finest.

    `levels` has the scene on each grid, coarsest first, and `load_step` is the end of the step.
    Each grid starts from the result on the grid before, so that it solves the contact only once.

    If the wear is a mean over positions of the disk, `after` keeps its wear, and only its contact
    is solved on the finest grid.
    """
    finest = levels[-1]
    if finest.sweeps_over and len(levels) > 1:
        return _solve_on_finest(finest, after)
    state = end_implicitly(levels[0], before, after, load_step, velocity)
    if finest.wears_by_strips:
        return _solve_on_finest(finest, state)
    wear_depth = _rewind(levels[0], before, state, load_step, velocity)
    for scene in levels[1:]:
        shape = scene.grid.shape
        pressure = _prolong(state.pressure, shape)
        start_state = replace(
            before,
            pressure=_prolong(before.pressure, shape),  # on which the rate of a wear law depends
            wear_depth=_interpolate(wear_depth, shape),
            displacement=None,
        )
        finer = advance(scene, start_state, load_step, velocity, pressure, scheme="implicit")
        state = replace(finer, iterations=state.iterations + finer.iterations)
    return state


def _rewind(
    scene: Scene, before: State, after: State, load_step: LoadStep, velocity: float
) -> Array:
    """Wear depth [m] to start from, so that one implicit step ends at the wear depth of `after`."""
    distance = abs(velocity) * (after.time - before.time)
    wear = step_wear(scene, before, distance, velocity)
    stage = next(passes(scene, before, load_step, wear, velocity, True, "implicit")).stage
    if wear is None or stage.normal_load != after.normal_load:  # the load falls to zero
        return before.wear_depth
    return after.wear_depth - wear.depth(after.pressure, stage.distance)


def _solve_on_finest(scene: Scene, after: State) -> State:
    """The state `after`, from a coarser grid, with its contact solved on the grid of `scene`."""
    # The step is not repeated. Its wear is a mean over many positions of the disk, which the coarse
    # grid resolves, while each position would be one more contact to solve on the fine grid.
    wear_depth = _interpolate(after.wear_depth, scene.grid.shape)
    unworn = Pass(Stage(after.normal_load, 0.0, 0.0))
    if scene.wears_by_strips:
        (guess,) = guess_pressure(scene, after, [separation_at(scene, None) + wear_depth])
    else:
        guess = _prolong(after.pressure, scene.grid.shape)
    contact, displacement = solve_pass(scene, after, unworn, None, wear_depth, guess)
    return replace(
        after,
        pressure=contact.pressure,
        wear_depth=wear_depth,
        iterations=after.iterations + contact.iterations,
        residual=max(after.residual, contact.residual),
        displacement=displacement,
        earlier=None,
    )


def _prolong(field: Array, shape: tuple[int, int]) -> Array:
    """Copy a field to a finer grid of `shape`; elements get the value of the coarse element."""
    for axis, n in enumerate(shape):
        field = np.repeat(field, n // field.shape[axis], axis)
    return field


def _interpolate(wear_depth: Array, shape: tuple[int, int]) -> Array:
    """Interpolate wear depths linearly to a finer grid of `shape`; the mean stays equal."""
    for n in shape[::-1]:  # along the last axis, then transposed
        fine, coarse = ((np.arange(size) + 0.5) / size for size in (n, wear_depth.shape[1]))
        wear_depth = np.array([np.interp(fine, coarse, row) for row in wear_depth]).T
    return np.ascontiguousarray(wear_depth)


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


def solve_positions(scene: Scene, state: State) -> State:
    """Solve the contact at further positions of the disk, to average the heat over them.

    Returns `state` with the pressures at these positions, `State.passing`; unchanged if one
    position is enough. Its pressure and wear remain those with the unshifted disk.
    """
    stage, contacts = Stage(state.normal_load, 0.0, 0.0), []
    shifts = further_positions(scene, state.normal_load)
    guesses: Iterable[Array] = itertools.repeat(state.pressure, len(shifts))
    if scene.wears_by_strips:
        shapes = (separation_at(scene, shift) + state.wear_depth for shift in shifts)
        guesses = guess_pressure(scene, state, shapes)
    for shift, guess in zip(shifts, guesses, strict=True):
        contact, _ = solve_pass(scene, state, Pass(stage, shift), None, state.wear_depth, guess)
        contacts.append(contact)
    if not contacts:
        return state
    iterations = sum(contact.iterations for contact in contacts)
    return replace(
        state,
        passing=tuple(contact.pressure for contact in contacts),
        iterations=state.iterations + iterations,
        residual=max(state.residual, *(contact.residual for contact in contacts)),
    )
