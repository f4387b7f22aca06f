"""One point of the diagram: its contacts, the temperatures of the requested steps, its verdict.

The calls of a point, from the outermost inwards: `contacts` in `contact_ramp` goes through
the steps of a loading. `advance` in `loading_step` computes one step. It solves the contacts that
`disk_positions` and the stages of `tribo.wear` ask for. `requested_state` repeats the last step on
the scene's grid. `heat` in `temperature` computes the temperature, and `verdict` judges it.
"""

from __future__ import annotations

from collections.abc import Container, Iterator
from dataclasses import replace

import numpy as np

from tribo.errors import InputError, TriboError, require_instance, require_number
from tribo.loading import Ramp, Stages
from tribo.simulation.conditions import Conditions
from tribo.simulation.contact_ramp import contacts
from tribo.simulation.corrections import Corrections
from tribo.simulation.point_warnings import touched_edges, warnings
from tribo.simulation.ramp_cache import RampCache, Recorder
from tribo.simulation.scene import Scene
from tribo.simulation.state import State, measures
from tribo.simulation.temperature import heat
from tribo.simulation.usual_values import unusual_values
from tribo.simulation.verdict import Verdict, verdict


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
    heated_states = recorder.course or map(add_requested_heat, states)
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


@np.errstate(under="ignore")
def judge(
    scene: Scene,
    load: float,
    velocity: float,
    conditions: Conditions,
    ramp_cache: RampCache | None = None,
) -> Verdict:
    """Simulate one point, and judge its wear.

    Parameters
    ----------
    scene : Scene
        System to simulate.
    load, velocity : float
        Load on the whole pin [N] and sliding velocity [m/s].
    conditions : Conditions
        Friction and temperatures. The motion and the loading in their `corrections` are
        replaced by those of the scene.
    ramp_cache : RampCache, optional
        Cached ramps of other points. Their steps are not repeated, and new ones are added.

    Returns
    -------
    Verdict
        Mild or severe at the time of the highest rise, once the load is reached: the beginning or
        the end of a hold, or any of its steps if bodies keep heat; for load stages, the onset or
        the end of any stage up to this one. Its `warnings` are those of the last state, and of
        values outside their usual range.

    Raises
    ------
    InputError
        If a value is not allowed, or nothing is in contact at `load`.
    ConvergenceError
        If a contact or a heat partition does not reach its tolerance. The notes of an error name
        values outside their usual range.

    Examples
    --------
    >>> import tribo
    >>> steel = tribo.Material(elastic_modulus=210e9, poisson_ratio=0.3, hardness=6.6e9,
    ...                        thermal_conductivity=45.0, density=7800.0, specific_heat=470.0)
    >>> scene = tribo.Scene(pin=tribo.Cylinder(2e-3, 3.4e-3, steel), disk=steel,
    ...                     pixels=tribo.Grid((192, 2), (2e-6, 228e-6)),
    ...                     loading=tribo.Ramp(rate=150.0, reference_load=750.0))
    >>> oil = tribo.Conditions(friction=0.1, bulk_temperature=298.0, critical_temperature=418.0)
    >>> point = judge(scene, load=600.0, velocity=1.25, conditions=oil)
    >>> point.is_severe, f"{point.governing_temperature:.0f} K = 298 + {point.contact_rise:.0f}"
    (True, '422 K = 298 + 124')
    """
    require_instance(Scene, scene=scene)
    require_instance(Conditions, conditions=conditions)
    require_number(load=load, velocity=velocity)
    conditions = conditions.with_loading(scene.loading)
    if corrections := conditions.corrections:
        conditions = replace(conditions, corrections=replace(corrections, motion=scene.motion))
    try:
        states, min_load = _states(scene, load, velocity, corrections, ramp_cache)
    except TriboError as error:
        for text in unusual_values(scene, load, velocity, conditions):
            error.add_note(text)
        raise
    records = [{**measures(scene, state), **state.heat.columns} for state in states if state.heat]
    columns = {name: np.array([record[name] for record in records]) for name in records[0]}
    reasons = tuple(warnings(scene, states[-1], conditions))
    return replace(verdict(columns, min_load, conditions), warnings=reasons)


def _states(
    scene: Scene,
    load: float,
    velocity: float,
    corrections: Corrections | None,
    ramp_cache: RampCache | None,
) -> tuple[list[State], float]:
    """States by which a point is judged, and their least load [N]."""
    if isinstance(scene.loading, Stages):
        states, min_load = stages_of(scene, load, velocity, ramp_cache), 0.0
    else:
        requested: list[int] = []
        if corrections and corrections.keeps_heat and isinstance(scene.loading, Ramp):
            load_steps = scene.all_load_steps(load)
            requested = [load_step.index for load_step in load_steps if load_step.holding]
        states, min_load = list(simulate(scene, load, velocity, ramp_cache, requested)), load
    states = [state for state in states if state.heat is not None and state.normal_load >= min_load]
    if not states:
        raise InputError(f"load is {load:g} N, at which nothing is in contact")
    return states, min_load
