"""One point of the diagram: a load ramp at constant velocity, with wear and friction heat."""

from __future__ import annotations

import functools
from collections.abc import Iterator
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from tribo.conduction import ConductingHalfSpace
from tribo.contact import solve_contact
from tribo.elasticity import ElasticHalfSpace
from tribo.errors import InputError, require_positive
from tribo.loading import Station
from tribo.material import contact_modulus
from tribo.partition import HeatPartition, partition_heat
from tribo.scene import Scene
from tribo.transition import contact_quantiles

__all__ = ["Heat", "State", "advance", "heat", "measures", "simulate", "start", "warnings"]

Array = NDArray[np.float64]


@dataclass(frozen=True, slots=True, eq=False)
class Heat:
    """Temperature of the contact, per unit friction coefficient.

    Attributes
    ----------
    rise : ndarray, shape (nx, ny)
        Of the pin's surface above bulk [K].
    rise_quantile : ndarray, shape (len(QUANTILES),)
        Of the rise over the contact area [K].
    max_rise, mean_rise : float
        Over the contact area [K].
    pin_heat_share : float
        Share of the friction heat that goes into the pin.
    """

    rise: Array
    rise_quantile: Array
    max_rise: float
    mean_rise: float
    pin_heat_share: float


@dataclass(frozen=True, slots=True, eq=False)
class State:
    """The contact at one moment of the ramp.

    Attributes
    ----------
    pressure : ndarray, shape (nx, ny)
        [Pa].
    wear_depth : ndarray, shape (nx, ny)
        Lost by the pin since the start [m].
    normal_load : float
        On the whole pin [N].
    time : float
        Since the start [s].
    sliding_distance : float
        Since the start [m].
    on_trunk : bool
        Whether the simulation of a higher load passes through this state.
    iterations : int
        Convolutions that the contact took.
    residual : float
        Of the contact.
    previous_pressure : ndarray, shape (nx, ny)
        One station before [Pa]; the next pressure is extrapolated from it.
    previous_load : float
        The load at that station [N].
    heat : Heat or None
        Where the temperature was asked for.
    """

    pressure: Array
    wear_depth: Array
    normal_load: float
    time: float
    sliding_distance: float
    on_trunk: bool
    iterations: int
    residual: float
    previous_pressure: Array
    previous_load: float
    heat: Heat | None = None


def simulate(
    scene: Scene, normal_load: float, velocity: float, trunk: State | None = None
) -> Iterator[State]:
    """Ramp the load up to `normal_load` at constant `velocity`.

    Parameters
    ----------
    scene : Scene
    normal_load : float
        On the whole pin at the end [N].
    velocity : float
        Of the disk along +x [m/s].
    trunk : State, optional
        A state on the trunk of a lower load at the same velocity, from which to go on; the
        result is the same as from the start, bit for bit.

    Yields
    ------
    State
        After every step, the last one at `normal_load` with its temperature.

    Raises
    ------
    InputError
        If the load is not positive, exceeds what the hardness carries, or the velocity is not
        finite.
    ConvergenceError
        If a contact or a heat partition does not reach its tolerance.
    """
    if not np.isfinite(velocity):
        raise InputError(f"velocity is {velocity!r}; it must be finite")
    require_positive(normal_load=normal_load)
    state = start(scene) if trunk is None else trunk
    if not state.on_trunk or state.normal_load >= normal_load:
        raise InputError(
            f"cannot go on to {normal_load:g} N from the state at {state.normal_load:g} N; "
            "it must lie on the trunk, at a lower load"
        )
    fidelity = scene.fidelity
    interval = fidelity.temperature_interval
    first = round(state.normal_load / scene.loading.reference_load * fidelity.increments) + 1
    stations = scene.loading.stations(normal_load, fidelity.increments, after=state.normal_load)
    for index, station in enumerate(stations, start=first):
        state = advance(scene, state, station, velocity)
        at_end = station.normal_load == normal_load
        if at_end or (interval and index % interval == 0):
            yield replace(state, heat=heat(scene, state, velocity))
        else:
            yield state


def start(scene: Scene) -> State:
    """The unloaded, unworn state."""
    zero = np.zeros(scene.grid.shape)
    return State(
        pressure=zero,
        wear_depth=zero,
        normal_load=0.0,
        time=0.0,
        sliding_distance=0.0,
        on_trunk=True,
        iterations=0,
        residual=0.0,
        previous_pressure=zero,
        previous_load=0.0,
    )


def advance(scene: Scene, state: State, station: Station, velocity: float) -> State:
    """Slide and load until `station`, wearing the pin by the implicit scheme.

    Parameters
    ----------
    scene : Scene
    state : State
        At an earlier time.
    station : Station
    velocity : float
        [m/s].

    Returns
    -------
    State
        Without temperature.
    """
    solid, separation = _bodies(scene)
    distance = abs(velocity) * (station.time - state.time)
    if scene.wear is not None:
        solid = scene.wear.yielding(solid, distance)
    contact = solve_contact(
        solid,
        separation + state.wear_depth,
        station.normal_load / scene.pin.patches(scene.grid),
        hardness=scene.hardness,
        tolerance=scene.fidelity.contact_tolerance,
        initial_pressure=_extrapolated(state, station.normal_load),
    )
    wear_depth = state.wear_depth
    if scene.wear is not None:
        wear_depth = wear_depth + scene.wear.depth(contact.pressure, distance)
    return State(
        pressure=contact.pressure,
        wear_depth=wear_depth,
        normal_load=station.normal_load,
        time=station.time,
        sliding_distance=state.sliding_distance + distance,
        on_trunk=station.on_trunk,
        iterations=contact.iterations,
        residual=contact.residual,
        previous_pressure=state.pressure,
        previous_load=state.normal_load,
    )


def measures(scene: Scene, state: State) -> dict[str, float]:
    """What is kept of a state at every step, by the name of its variable in the dataset.

    Returns
    -------
    dict
        ``time`` [s], ``normal_load`` [N], ``sliding_distance`` [m], ``contact_fraction`` (of the
        window), ``contact_width`` (between the outermost elements in contact along x) [m],
        ``max_pressure`` and ``mean_pressure`` (over the contact) [Pa], ``saturated_fraction``
        (of the contact, at the hardness), ``wear_depth_max`` [m], ``wear_volume`` (of the whole
        pin) [m³], ``iterations`` and ``residual`` of the contact; ``max_rise``, ``mean_rise`` [K]
        and ``pin_heat_share``, NaN where the temperature was not asked for.
    """
    grid, pressure = scene.grid, state.pressure
    contact = pressure > 0
    nodes = int(np.count_nonzero(contact))
    rows = np.flatnonzero(contact.any(axis=1))
    return {
        "time": state.time,
        "normal_load": state.normal_load,
        "sliding_distance": state.sliding_distance,
        "contact_fraction": nodes / pressure.size,
        "contact_width": float(rows[-1] - rows[0] + 1) * grid.spacing[0] if nodes else 0.0,
        "max_pressure": float(pressure.max()),
        "mean_pressure": float(pressure.sum()) / nodes if nodes else 0.0,
        "saturated_fraction": float(np.mean(pressure[contact] >= scene.hardness)) if nodes else 0.0,
        "wear_depth_max": float(state.wear_depth.max()),
        "wear_volume": float(state.wear_depth.sum()) * grid.element_area * scene.pin.patches(grid),
        "iterations": float(state.iterations),
        "residual": state.residual,
        "max_rise": state.heat.max_rise if state.heat else np.nan,
        "mean_rise": state.heat.mean_rise if state.heat else np.nan,
        "pin_heat_share": state.heat.pin_heat_share if state.heat else np.nan,
    }


def warnings(scene: Scene, state: State) -> list[str]:
    """What a user should know about a state before relying on it."""
    touched = [
        f"{name} edge"
        for name, axis in (("x", 0), ("y", 1))
        if not scene.grid.periodic[axis] and np.take(state.pressure, (0, -1), axis=axis).any()
    ]
    if touched:
        return [
            f"contact touches the window's {' and '.join(touched)} at {state.normal_load:g} N; "
            "a wider window would carry load there too"
        ]
    return []


def heat(scene: Scene, state: State, velocity: float) -> Heat:
    """Temperature of a state, at friction coefficient 1 and with both bodies' bulk equal.

    The present friction heat is taken to act since time 0 (Bosman & de Rooij).
    """
    contact = state.pressure > 0
    split = _partition(scene, state, velocity, contact)
    on_contact = split.rise[contact]
    return Heat(
        rise=split.rise,
        rise_quantile=contact_quantiles(split.rise, contact),
        max_rise=float(on_contact.max()),
        mean_rise=float(on_contact.mean()),
        pin_heat_share=split.pin_share,
    )


def _partition(
    scene: Scene, state: State, velocity: float, contact: NDArray[np.bool_]
) -> HeatPartition:
    grid = scene.grid
    return partition_heat(
        ConductingHalfSpace(grid, scene.pin.material, 0.0, state.time),
        ConductingHalfSpace(grid, scene.disk, velocity, state.time),
        abs(velocity) * state.pressure,
        contact,
        method=scene.fidelity.partition,
        tolerance=scene.fidelity.heat_tolerance,
    )


def _extrapolated(state: State, normal_load: float) -> Array | None:
    """Pressure at the next load, linear in the load through the last two states."""
    if state.normal_load == 0.0:
        return None
    if state.previous_load == 0.0:
        return state.pressure
    ratio = (normal_load - state.normal_load) / (state.normal_load - state.previous_load)
    return state.pressure + ratio * (state.pressure - state.previous_pressure)


@functools.lru_cache(maxsize=2)
def _bodies(scene: Scene) -> tuple[ElasticHalfSpace, Array]:
    """The elastic map and the undeformed separation, which no step changes."""
    modulus = contact_modulus(scene.pin.material, scene.disk)
    return ElasticHalfSpace(scene.grid, modulus), scene.separation()
