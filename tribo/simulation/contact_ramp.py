"""Contact and wear along a loading: the first part of a point, before heat and verdict.

Contact and wear depend on the load, the surface, the elastic constants, the hardness, and on how
fast the sliding wears the pin, but not on thermal constants. Scenes of equal `mechanics` therefore
share cached ramps, and the contact at the end of the last point. `heat` is computed from contacts,
and verdicts from heat.

Without wear, the contact at a load is cached for all velocities.

No choice here depends on a temperature: neither larger elements before the last step, nor the short
implicit step that may end a step. `element_size` chooses the size of elements beforehand.
"""

from __future__ import annotations

import itertools
from collections.abc import Container, Hashable, Iterator, Sequence
from dataclasses import replace
from functools import partial

import numpy as np

from tribo.errors import InputError, TriboError, require_instance, require_number, require_positive
from tribo.loading import LoadStep, Stages
from tribo.loading.ramp import MOST_STEPS
from tribo.simulation.cache import unworn_contact
from tribo.simulation.element_size import fit_elements
from tribo.simulation.loading_step import advance, start
from tribo.simulation.ramp_cache import PointMemo, RampCache, Reached, Recorder
from tribo.simulation.requested_state import refine_step, solve_positions
from tribo.simulation.scene import Scene
from tribo.simulation.state import State
from tribo.simulation.step_wear import step_parts


def mechanics(scene: Scene) -> Scene:
    """Copy of a scene with all thermal constants set to 1.

    Scenes with equal copies have the same contacts at equal load and velocity.

    Examples
    --------
    >>> import tribo
    >>> from dataclasses import replace
    >>> insulating = replace(scene, disk=replace(scene.disk, thermal_conductivity=5.0))
    >>> mechanics(insulating) == mechanics(scene)
    True
    """
    athermal = {"thermal_conductivity": 1.0, "density": 1.0, "specific_heat": 1.0}
    pin = replace(scene.pin, material=replace(scene.pin.material, **athermal))
    return replace(scene, pin=pin, disk=replace(scene.disk, **athermal))


def contact_key(scene: Scene, load: float, velocity: float, requested: Container[int]) -> Hashable:
    """Key of the contacts of a point: mechanics, velocity, load and requested load steps."""
    indices = [
        load_step.index for load_step in scene.all_load_steps(load) if load_step.index in requested
    ]
    return mechanics(scene), velocity, load, *indices


def contacts(
    scene: Scene,
    normal_load: float,
    velocity: float,
    ramp_cache: RampCache | None = None,
    requested: Container[int] = (),
    recorder: Recorder | None = None,
) -> Iterator[State]:
    """Contact states during the loading to `normal_load` [N] and during its hold.

    The states have no temperature; `heat` computes that of the states with `State.is_requested`.

    Parameters
    ----------
    scene : Scene
        System to simulate.
    normal_load, velocity : float
        Load on the whole pin at the end [N], and sliding velocity [m/s].
    ramp_cache : RampCache, optional
        Cache of the ramps of other points. Steps found there are not repeated, and new steps below
        `normal_load` are added to it.
    requested : container of int, optional
        Indices of further steps, `LoadStep.index`, whose states shall have `State.is_requested`.
    recorder : Recorder, optional
        Value to record after each increment of the ramp below `normal_load`, on the finest grid.
        The last states with `State.is_requested` have the recorded values as `State.course`.

    Yields
    ------
    State
        State after every step that `ramp_cache` did not have yet. Without wear, only the states
        with `State.is_requested`.

    Raises
    ------
    InputError, ConvergenceError
        If load or velocity is not allowed, or a contact does not reach its tolerance.
    """
    _check_arguments(scene, normal_load, velocity)
    ramp_cache = RampCache() if ramp_cache is None else ramp_cache
    scene = fit_elements(scene, normal_load)
    levels = tuple(scene.levels())
    load_steps = list(scene.load_steps(normal_load, requested))
    if not scene.wears:
        for load_step in load_steps:
            yield _independent_state(levels, normal_load, velocity, load_step)
        return
    has_stages = isinstance(scene.loading, Stages)
    on_finest = range(MOST_STEPS + 1) if recorder and not has_stages else requested
    advance_step = partial(_advance_shared, levels, velocity, on_finest)
    key = mechanics(scene), velocity, scene.ramp_increment(normal_load), on_finest is requested
    memo = ramp_cache.memo(contact_key(scene, normal_load, velocity, requested))
    begin = start(scene)
    if has_stages or (recorder and load_steps[-1].on_trunk):  # higher loads continue from the end
        ramp = ramp_cache.reach(key, begin, load_steps, advance_step, recorder)
        for reached, load_step in zip(ramp, load_steps, strict=True):
            if reached.is_new and load_step is not load_steps[-1]:
                yield reached.state
        end = reached.state
        if end.is_requested or not end.pressure.any():
            end = end if has_stages else _with_positions(levels[-1], end, memo)
            yield replace(end, course=reached.course)
            return
    shared_steps = list(
        itertools.takewhile(
            lambda load_step: (
                load_step.on_trunk
                and load_step.normal_load < normal_load
                and load_step.index not in requested
            ),
            load_steps,
        )
    )
    reached = Reached(begin, is_new=False)
    for reached in ramp_cache.reach(key, begin, shared_steps, advance_step, recorder):
        if reached.is_new:
            yield reached.state
    if memo.ends is not None:  # solved for a scene that differs only in thermal constants
        yield from (replace(end, course=reached.course) for end in memo.ends)
        return
    before, final_states = reached.state.history or reached.state, list[State]()
    for end in _final_states(
        levels,
        before,
        load_steps[len(shared_steps) :],
        normal_load,
        velocity,
        requested,
    ):
        if end.is_requested:
            final_states.append(end)
        yield replace(end, course=reached.course) if end.is_requested else end
    if ramp_cache.has_room_for(final_states):
        memo.ends = final_states


def _with_positions(scene: Scene, last: State, memo: PointMemo) -> State:
    """The shared state `last` as the end of a point, with contacts at all positions of the disk."""
    if not (last.is_requested and scene.wears_by_strips):
        return last
    if memo.shared_end is None:  # not solved for a scene that differs only in thermal constants
        memo.shared_end = solve_positions(scene, last)
    return memo.shared_end


def _advance_shared(
    levels: tuple[Scene, ...],
    velocity: float,
    requested: Container[int],
    before: State,
    load_step: LoadStep,
) -> State:
    """Compute a shared step on the coarsest grid and, if it is requested, on the finest."""
    begin, after = _last_part(levels, velocity, before.history or before, load_step)
    if not (load_step.bounds_hold or load_step.index in requested):
        return after
    try:
        finest = _solve_requested(
            levels, begin, after, load_step, velocity, is_judged=load_step.bounds_hold
        )
    except TriboError:
        if load_step.bounds_hold:
            raise
        return after  # the ramp continues, since the ends of points do not need this contact
    if finest.history is None:
        return finest
    # The ramp continues from the history. Arrays for a next step would take half of the memory.
    return replace(finest, previous_pressure=after.previous_pressure, displacement=None)


def _final_states(
    levels: tuple[Scene, ...],
    state: State,
    load_steps: Sequence[LoadStep],
    normal_load: float,
    velocity: float,
    requested: Container[int],
) -> Iterator[State]:
    """Yield the states after `state` at the last load steps of a point, shared by no other."""
    is_worn, state_at_load = velocity != 0, None
    for load_step in load_steps:
        if load_step.holding and state_at_load and not is_worn:
            is_requested = load_step is load_steps[-1] or load_step.index in requested
            yield replace(
                _later_state(state_at_load, load_step, velocity), is_requested=is_requested
            )
            continue
        ends_hold = load_step is load_steps[-1]
        before, state = _last_part(levels, velocity, state, load_step, ends_hold)
        is_reached = load_step.normal_load == normal_load and not load_step.holding
        if load_step is load_steps[-1] or is_reached or load_step.index in requested:
            is_judged = load_step is load_steps[-1] or load_step.normal_load >= normal_load
            requested_state = _solve_requested(
                levels, before, state, load_step, velocity, is_judged
            )
            state_at_load = requested_state if is_reached else state_at_load
            yield requested_state
        else:
            yield state


def _check_arguments(scene: Scene, normal_load: float, velocity: float) -> None:
    """Raise `InputError` for a load or a velocity that is not allowed."""
    require_instance(Scene, scene=scene)
    require_number(velocity=velocity)
    if not np.isfinite(velocity):
        raise InputError(f"velocity is {velocity!r}; it must be finite")
    require_positive(normal_load=normal_load)
    if normal_load > scene.greatest_load * (1 + 1e-12):
        raise InputError(
            f"normal_load is {normal_load:g} N, but the window carries {scene.greatest_load:g}"
            f" N at most (its area times the hardness, {scene.hardness:g} Pa)"
        )


def _last_part(
    levels: tuple[Scene, ...],
    velocity: float,
    before: State,
    load_step: LoadStep,
    ends_hold: bool = False,
) -> tuple[State, State]:
    """States before and after the last part of a step to `load_step`, on the coarsest grid."""
    scene, after, iterations = levels[0], before, 0
    observed = len(levels) == 1 and not scene.wears_by_strips
    for part in step_parts(scene, before, load_step, velocity, ends_hold):
        begin, after = after, advance(scene, after, part, velocity, observed=observed)
        iterations += after.iterations
    return begin, replace(after, iterations=iterations)


def _solve_requested(
    levels: tuple[Scene, ...],
    before: State,
    after: State,
    load_step: LoadStep,
    velocity: float,
    is_judged: bool,
) -> State:
    """Repeat a step on the finest grid, so that the state at its end can get a temperature.

    Under a pin that wears by strips of the disk, only the temperature of a step that verdicts use
    (`is_judged`) is a mean over positions.
    """
    if not after.pressure.any():
        return after
    finest = refine_step(levels, before, after, load_step, velocity)
    if is_judged or not levels[-1].wears_by_strips:
        finest = solve_positions(levels[-1], finest)
    return replace(finest, is_requested=True)


def _independent_state(
    levels: tuple[Scene, ...],
    normal_load: float,
    velocity: float,
    load_step: LoadStep,
) -> State:
    """State at `load_step` in a loading to `normal_load` [N], independent of earlier steps."""
    scene = levels[-1]

    def compute() -> State:
        # Each load step starts from the unloaded state. With a guess from earlier steps, results
        # would depend on the load steps at which a temperature is requested.
        states = _last_part(levels, velocity, start(scene), load_step)
        return _solve_requested(levels, *states, load_step, velocity, is_judged=True)

    # The contact under a load does not depend on when the load is reached.
    contact = unworn_contact((mechanics(scene), load_step.normal_load, normal_load), compute)
    return _later_state(contact, load_step, velocity)


def _later_state(contact: State, load_step: LoadStep, velocity: float) -> State:
    """The state `contact`, of equal load and without wear, at the time of a `load_step`."""
    return replace(
        contact,
        time=load_step.time,
        impulse=load_step.impulse,
        index=load_step.index,
        sliding_distance=abs(velocity) * load_step.time,
    )
