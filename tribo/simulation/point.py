"""One point of the diagram: its contacts, and the temperatures of the requested steps.

The calls of a point, from the outermost inwards: `contacts` in `contact_ramp` goes through
the steps of a loading. `advance` in `loading_step` computes one step. It solves the contacts that
`disk_positions` and the stages of `tribo.wear` ask for. `finer_grids` repeats the last step on the
scene's grid. `heat` in `temperature` computes the temperature.
"""

from __future__ import annotations

from collections.abc import Container, Iterator
from dataclasses import replace

from tribo.errors import InputError
from tribo.simulation.contact_ramp import contacts
from tribo.simulation.point_warnings import touched_edges
from tribo.simulation.ramp_cache import RampCache, Recorder
from tribo.simulation.scene import Scene
from tribo.simulation.state import State
from tribo.simulation.temperature import heat


def simulate(
    scene: Scene,
    normal_load: float,
    velocity: float,
    ramp_cache: RampCache | None = None,
    requested: Container[int] = (),
) -> Iterator[State]:
    """Simulate a loading up to `normal_load` at constant `velocity`; yield the states of its steps.

    The load grows as the scene's loading prescribes. If the loading has a hold, the load then stays
    at `normal_load`.

    Parameters
    ----------
    scene : Scene
        System to simulate.
    normal_load : float
        Load on the whole pin at the end [N].
    velocity : float
        Sliding velocity [m/s], which the disk has along +x unless the scene has a motion.
    ramp_cache : RampCache, optional
        Cache of states on ramps of the load, which points at several loads share. States found in
        the cache are neither computed again nor yielded, and new ones are added to it. The cache
        does not change the numbers of the yielded states.
    requested : container of int, optional
        Indices of further steps at whose end the temperature is computed, counted from 1.

    Yields
    ------
    State
        State after every step that was not in `ramp_cache`. The state that reaches `normal_load`,
        the last state and the states of `requested` have their temperature, if anything touches.
        Without wear, these are the only states.

    Raises
    ------
    InputError
        If the load is not positive, or exceeds what the hardness carries, or a value is not finite.
    ConvergenceError
        If a contact or a heat partition does not reach its tolerance.

    Examples
    --------
    >>> import tribo
    >>> for state in tribo.simulate(scene, normal_load=10.0, velocity=0.065):
    ...     print(f"{state.normal_load:g} N after {state.time:g} s")
    10 N after 1 s
    10 N after 61 s
    """
    for state in contacts(scene, normal_load, velocity, ramp_cache, requested):
        if state.is_requested:
            yield replace(state, heat=heat(scene, state, velocity))
        else:
            yield state


def stages_of(
    scene: Scene, normal_load: float, velocity: float, ramp_cache: RampCache | None = None
) -> list[State]:
    """States with a temperature at onset and end of each stage up to the requested one.

    The stage is that at `normal_load` [N]. The temperatures have `Heat.sampling`.

    Raises
    ------
    InputError
        If there is no such stage, or its contact reaches an edge of the window.

    Examples
    --------
    >>> import tribo
    >>> stages = tribo.Stages(loads=(5.0, 10.0), hold_times=(1.0, 1.0), rate=10.0)
    >>> for state in stages_of(replace(scene, loading=stages), 10.0, 0.065):
    ...     print(f"{state.normal_load:g} N, {state.time:g} s: {0.1 * state.heat.max_rise:.1f} K")
    5 N, 0.5 s: 4.8 K
    5 N, 1.5 s: 4.8 K
    10 N, 2 s: 7.4 K
    10 N, 3 s: 7.4 K
    """

    def add_requested_heat(contact: State) -> State | None:
        if not contact.is_requested:
            return None
        return replace(contact, heat=heat(scene, contact, velocity, is_sampled=True))

    recorder = Recorder(("stages", scene, velocity), add_requested_heat)
    states = list(contacts(scene, normal_load, velocity, ramp_cache, recorder=recorder))
    # Without wear a stage depends on no other, and there is no course.
    heated_states = states[-1].course or map(add_requested_heat, states)
    stage_states = [state for state in heated_states if state is not None]
    if edges := touched_edges(scene, states[-1]):
        raise InputError(
            f"the stage at {normal_load:g} N and {velocity:g} m/s reaches the "
            f"{' and '.join(edges)} of the window, beyond which it would carry load as well; "
            "increase window.pixels"
        )
    return stage_states


def add_temperature(scene: Scene, contact: State, velocity: float) -> State:
    """Copy of a state from `contacts` with its contact temperature at a sliding velocity [m/s].

    The copy also has the sliding distance at this velocity. Its temperature, `State.heat`, is None
    unless `contact.is_requested` is True. Velocity and thermal constants may differ from those used
    for the contact. The product of specific wear rate and velocity must be the same.

    Examples
    --------
    Without wear a contact is the same at all velocities:

    >>> import tribo
    >>> *_, contact = contacts(scene, normal_load=10.0, velocity=0.065)
    >>> *_, state = tribo.simulate(scene, normal_load=10.0, velocity=0.13)
    >>> add_temperature(scene, contact, 0.13).heat.max_rise == state.heat.max_rise
    True
    """
    temperature = heat(scene, contact, velocity) if contact.is_requested else None
    distance = abs(velocity) * contact.time
    return replace(contact, sliding_distance=distance, heat=temperature)
