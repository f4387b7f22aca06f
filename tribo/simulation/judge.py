"""One point simulated and judged."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from tribo.errors import InputError, TriboError, require_instance, require_number
from tribo.loading import Ramp, Stages
from tribo.simulation.conditions import Conditions
from tribo.simulation.corrections import Corrections
from tribo.simulation.point import simulate, stages_of
from tribo.simulation.point_warnings import warnings
from tribo.simulation.ramp_cache import RampCache
from tribo.simulation.scene import Scene
from tribo.simulation.state import State
from tribo.simulation.step_measures import measures
from tribo.simulation.usual_values import unusual_values
from tribo.simulation.verdict import Verdict, verdict


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
        Mild or severe at the worst time, when the rise is highest, once the load is reached. The
        candidates are the beginning and the end of a hold, or all its steps if bodies keep heat.
        For a specimen in stages they are onset and end of all stages up to this one. Its
        `warnings` are those of the last state, and of values outside their usual range.

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
