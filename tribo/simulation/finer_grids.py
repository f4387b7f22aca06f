"""The last step of a point on the scene's grid, after earlier steps on a coarse grid."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from tribo.loading import LoadStep
from tribo.simulation.disk_positions import Pass, passes, separation_at
from tribo.simulation.implicit_end import end_implicitly
from tribo.simulation.loading_step import advance, guess_pressure, solve_pass
from tribo.simulation.scene import Scene
from tribo.simulation.state import State
from tribo.simulation.step_wear import step_wear
from tribo.types import Array
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
        return replace(_solve_on_finest(finest, state), history=after)
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
        state = replace(finer, iterations=state.iterations + finer.iterations, history=after)
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
        previous_displacement=None,
        history=after,
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
