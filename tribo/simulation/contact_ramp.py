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
from dataclasses import dataclass, replace

import numpy as np

from tribo.errors import InputError, TriboError, require_instance, require_number, require_positive
from tribo.loading import LoadStep, Stages
from tribo.simulation.cache import unworn_contact
from tribo.simulation.element_size import fit_elements
from tribo.simulation.loading_step import advance, start
from tribo.simulation.ramp_cache import PointMemo, RampCache, Recorder, SharedStep
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
        When all states were yielded, `Recorder.course` has the recorded values, and is empty
        without wear.

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
    scene = fit_elements(scene, normal_load)
    load_steps = list(scene.load_steps(normal_load, requested))
    levels, ramp_cache = tuple(scene.levels()), ramp_cache or RampCache()
    point = _Point(levels, normal_load, velocity, requested, load_steps, ramp_cache, recorder)
    if not scene.wears:
        yield from map(point.unworn_state, load_steps)
    elif point.has_stages or (recorder and load_steps[-1].on_trunk):
        yield from point.shared_states()  # higher loads continue from the end
    else:
        yield from point.states()


@dataclass(frozen=True, slots=True)
class _Point:
    """Arguments of `contacts`, with the load steps of the point and its scene on all grids."""

    levels: tuple[Scene, ...]  # on ever finer grids
    normal_load: float
    velocity: float
    requested: Container[int]
    load_steps: Sequence[LoadStep]
    ramp_cache: RampCache
    recorder: Recorder | None

    @property
    def scene(self) -> Scene:
        """The scene on the finest grid."""
        return self.levels[-1]

    @property
    def has_stages(self) -> bool:
        """True under load stages, all of whose steps are shared."""
        return isinstance(self.scene.loading, Stages)

    @property
    def memo(self) -> PointMemo:
        """Results of scenes that differ from this one in thermal constants only."""
        key = contact_key(self.scene, self.normal_load, self.velocity, self.requested)
        return self.ramp_cache.memo(key)

    def unworn_state(self, load_step: LoadStep) -> State:
        """State at a load step without wear, independent of earlier steps."""

        def compute() -> State:
            # Each load step starts from the unloaded state. With a guess from earlier steps,
            # results would depend on the load steps at which a temperature is requested.
            states = self._last_part(start(self.scene), load_step)
            return self._solve_requested(*states, load_step, is_judged=True)

        # The contact under a load does not depend on when the load is reached.
        key = mechanics(self.scene), load_step.normal_load, self.normal_load
        return self._later_state(unworn_contact(key, compute), load_step)

    def shared_states(self) -> Iterator[State]:
        """States of a point whose end higher loads pass through."""
        for step, is_new in self._reach(self.load_steps):
            if is_new and step.end.index != self.load_steps[-1].index:
                yield step.end
        end, memo = step.end, self.memo
        if end.pressure.any() and not end.is_requested:  # not solved on the finest grid
            yield from self.states()
            return
        if end.is_requested and self.scene.wears_by_strips and not self.has_stages:
            if memo.shared_end is None:
                memo.shared_end = solve_positions(self.scene, end)
            end = memo.shared_end
        yield end

    def states(self) -> Iterator[State]:
        """States of a point that leaves the shared ramp before its end."""
        shared_steps = list(itertools.takewhile(self._is_shared, self.load_steps))
        state = start(self.scene)
        for step, is_new in self._reach(shared_steps):
            state = step.history
            if is_new:
                yield step.end
        memo = self.memo
        if memo.ends is not None:
            yield from memo.ends
            return
        ends = list[State]()
        for end in self._final_states(state, self.load_steps[len(shared_steps) :]):
            if end.is_requested:
                ends.append(end)
            yield end
        if self.ramp_cache.has_room_for(ends):
            memo.ends = ends

    def _is_shared(self, load_step: LoadStep) -> bool:
        """True for a step of all points at higher loads that requests no temperature."""
        is_below = load_step.on_trunk and load_step.normal_load < self.normal_load
        return is_below and load_step.index not in self.requested

    @property
    def _records_increments(self) -> bool:
        return self.recorder is not None and not self.has_stages

    def _reach(self, load_steps: Sequence[LoadStep]) -> Iterator[tuple[SharedStep, bool]]:
        """Yield the shared steps up to the last of `load_steps`, and whether each is new."""
        scene, records = self.scene, self._records_increments
        increment = scene.ramp_increment(self.normal_load)
        key = mechanics(scene), self.velocity, increment, records
        return self.ramp_cache.reach(
            key, start(scene), load_steps, self._advance_shared, self.recorder
        )

    def _advance_shared(self, before: State, load_step: LoadStep) -> SharedStep:
        """Compute a shared step on the coarsest grid and, if it is requested, on the finest."""
        begin, after = self._last_part(before, load_step)
        is_judged = load_step.bounds_hold
        if not (is_judged or self._records_increments or load_step.index in self.requested):
            return SharedStep(after, after)
        try:
            finest = self._solve_requested(begin, after, load_step, is_judged)
        except TriboError:
            if is_judged:
                raise
            # The ramp continues, since the ends of points do not need this contact.
            return SharedStep(after, after)
        # Arrays for a next step would take half of the memory.
        return SharedStep(replace(finest, displacement=None, earlier=None), after)

    def _final_states(self, state: State, load_steps: Sequence[LoadStep]) -> Iterator[State]:
        """Yield the states after `state` at the last load steps of a point, shared by no other."""
        state_at_load = None
        for load_step in load_steps:
            is_end = load_step is load_steps[-1]
            if load_step.holding and state_at_load and not self.velocity:
                is_requested = is_end or load_step.index in self.requested
                later_state = self._later_state(state_at_load, load_step)
                yield replace(later_state, is_requested=is_requested)
                continue
            before, state = self._last_part(state, load_step, is_end)
            is_reached = load_step.normal_load == self.normal_load and not load_step.holding
            if not (is_end or is_reached or load_step.index in self.requested):
                yield state
                continue
            is_judged = is_end or load_step.normal_load >= self.normal_load
            requested_state = self._solve_requested(before, state, load_step, is_judged)
            state_at_load = requested_state if is_reached else state_at_load
            yield requested_state

    def _last_part(
        self, before: State, load_step: LoadStep, ends_hold: bool = False
    ) -> tuple[State, State]:
        """States before and after the last part of a step to `load_step`, on the coarsest grid."""
        scene, after, iterations = self.levels[0], before, 0
        observed = len(self.levels) == 1 and not scene.wears_by_strips
        for part in step_parts(scene, before, load_step, self.velocity, ends_hold):
            begin, after = after, advance(scene, after, part, self.velocity, observed=observed)
            iterations += after.iterations
        return begin, replace(after, iterations=iterations)

    def _solve_requested(
        self, before: State, after: State, load_step: LoadStep, is_judged: bool
    ) -> State:
        """Repeat a step on the finest grid, so that the state at its end can get a temperature.

        Under a pin that wears by strips of the disk, only the temperature of a step that verdicts
        use (`is_judged`) is a mean over positions.
        """
        if not after.pressure.any():
            return after
        finest = refine_step(self.levels, before, after, load_step, self.velocity)
        if is_judged or not self.scene.wears_by_strips:
            finest = solve_positions(self.scene, finest)
        return replace(finest, is_requested=True)

    def _later_state(self, contact: State, load_step: LoadStep) -> State:
        """The state `contact`, of equal load and without wear, at the time of a `load_step`."""
        return replace(
            contact,
            time=load_step.time,
            impulse=load_step.impulse,
            index=load_step.index,
            sliding_distance=abs(self.velocity) * load_step.time,
        )


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
