"""One point of the diagram: a loading at constant velocity, with wear and friction heat."""

from __future__ import annotations

import math
from collections.abc import Iterable, Iterator
from dataclasses import replace

import numpy as np

from tribo.contact.solver import ContactSolution, solve_contact
from tribo.errors import InputError, require_positive
from tribo.loading.ramp import Station
from tribo.simulation.heating import heat, heated_since
from tribo.simulation.invariants import check_contact, check_wear, within_range
from tribo.simulation.kernels import elastic_bodies
from tribo.simulation.scene import Scene
from tribo.simulation.state import State
from tribo.simulation.warning import PointWarning, WarningKind
from tribo.thermal.duhamel import HeatHistory
from tribo.types import Array
from tribo.wear import EXPLICIT_LIMIT, WEAR_SCHEMES, Stage

__all__ = ["advance", "leads_to", "measures", "simulate", "start", "warnings"]


_FEW_NODES = 400  # below which `draft` errs by over 8 % and `standard` by over 3 % in most scenes,
# and a coarse history of heavy wear, which does not know the summits that wear, by up to 80 %
_FEWEST_STEPS = 3  # in which heavy wear knows the rise to about 10 %
_OF_CONTACT = (
    "contact_fraction",
    "contact_width",
    "max_pressure",
    "mean_pressure",
    "saturated_fraction",
)
_FARTHEST = 2.0  # steps of the load over which its last step is extrapolated


def simulate(
    scene: Scene, normal_load: float, velocity: float, trunk: State | None = None
) -> Iterator[State]:
    """Bring the load up to `normal_load` at constant `velocity`, and through its hold.

    Parameters
    ----------
    scene : Scene
        System to simulate.
    normal_load : float
        Load on the whole pin at the end [N].
    velocity : float
        Velocity of the disk along +x [m/s].
    trunk : State, optional
        A state on the trunk of a lower load at the same velocity, from which to go on; the
        result is the same as from the start, bit for bit. Loads share a trunk where `Scene.trunk`
        is the same.

    Yields
    ------
    State
        State after every step. The one that reaches `normal_load` and the last one have their
        temperature, besides those that the fidelity asks for.

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
    capacity = scene.hardness * scene.grid.area * scene.pin.patches(scene.grid)
    if normal_load > capacity * (1 + 1e-12):
        raise InputError(
            f"normal_load is {normal_load:g} N; the window carries at most {capacity:g} N, its "
            f"area times the hardness of {scene.hardness:g} Pa"
        )
    state = start(scene) if trunk is None else trunk
    if not leads_to(scene, state, normal_load):
        raise InputError(
            f"cannot go on to {normal_load:g} N from the state at {state.normal_load:g} N; "
            "it must lie on the trunk that leads there, at a lower load"
        )
    if scene.remembers_heat != (state.heat_history is not None):
        heat_model = scene.fidelity.heat_model
        raise InputError(f"heat model {heat_model!r} cannot go on from a state of the other one")
    interval = scene.fidelity.temperature_interval
    levels = tuple(scene.levels())
    on_own_grid = _on_own_grid(scene, normal_load, velocity)
    stations = list(scene.stations(normal_load, after=state.normal_load))
    for station in stations:
        before, state = state, advance(levels[0], state, station, velocity)
        reached = station.normal_load == normal_load and not station.holding
        asked = reached or station is stations[-1] or (interval and station.index % interval == 0)
        if asked and state.heat is None and state.pressure.any():
            refined = _refined(levels, before, state, station, velocity)
            if refined.history and scene.wear and _ordered_nodes(scene, refined) < _FEW_NODES:
                refined = replace(_reaching(station.index, on_own_grid, refined), history=state)
            yield replace(refined, heat=heat(scene, refined, velocity))
        else:
            yield state


def leads_to(scene: Scene, state: State, normal_load: float) -> bool:
    """Whether the simulation of a load passes through a state, and can go on from it."""
    if not state.on_trunk or state.normal_load >= normal_load:
        return False
    return math.isclose(state.normal_load, state.index * scene.trunk(normal_load))


def start(scene: Scene) -> State:
    """The unloaded, unworn state."""
    zero = np.zeros(next(scene.levels()).grid.shape)
    return State(
        pressure=zero,
        wear_depth=zero,
        normal_load=0.0,
        time=0.0,
        sliding_distance=0.0,
        impulse=0.0,
        on_trunk=True,
        index=0,
        iterations=0,
        residual=0.0,
        previous_pressure=zero,
        previous_load=0.0,
        heat_history=HeatHistory() if scene.remembers_heat else None,
    )


@within_range("a step of the loading")
def advance(
    scene: Scene, state: State, station: Station, velocity: float, guess: Array | None = None
) -> State:
    """Slide and load until `station`, wearing the pin by the scheme of the fidelity.

    Parameters
    ----------
    scene : Scene
        System to simulate.
    state : State
        State at an earlier time.
    station : Station
        Time and load at the end of the step.
    velocity : float
        Velocity of the disk along +x [m/s].
    guess : ndarray, shape (nx, ny), optional
        Guess of the pressure [Pa]; extrapolated from the last two states if not given.

    Returns
    -------
    State
        State at the station, with its temperature where that depends on the earlier ones, else
        without.
    """
    wear_depth, iterations, residual = state.wear_depth, 0, 0.0
    distance = abs(velocity) * (station.time - state.time)
    for stage in _stages(scene, state, station, distance):
        contact, displacement = _solved(scene, state, stage, wear_depth, guess)
        iterations, residual = iterations + contact.iterations, max(residual, contact.residual)
        if scene.wear:
            wear_depth = wear_depth + scene.wear.depth(contact.pressure, stage.distance)
    if scene.wear:
        volume = scene.wear.specific_wear_rate * abs(velocity) * station.impulse
        check_wear(state.wear_depth, wear_depth, _element_area(scene), volume)
    advanced = State(
        pressure=contact.pressure,
        wear_depth=wear_depth,
        normal_load=station.normal_load,
        time=station.time,
        sliding_distance=state.sliding_distance + distance,
        impulse=station.impulse,
        on_trunk=station.on_trunk,
        index=station.index,
        iterations=iterations,
        work=iterations * contact.pressure.size,
        residual=residual,
        previous_pressure=state.pressure,
        previous_load=state.normal_load,
        displacement=displacement,
        previous_displacement=state.displacement,
    )
    if state.heat_history is None:
        return advanced
    return heated_since(scene, state.heat_history, advanced, velocity)


def _stages(scene: Scene, state: State, station: Station, distance: float) -> Iterable[Stage]:
    """Contacts that the step from `state` to `station` has to solve."""
    if not scene.wear:
        return [Stage(station.normal_load, 0.0, 0.0)]
    loads = state.normal_load, station.normal_load
    mean_load = (station.impulse - state.impulse) / (station.time - state.time)
    scheme = WEAR_SCHEMES[scene.fidelity.wear_scheme]
    return scheme.stages(loads, max(0.0, mean_load), distance)


def _solved(
    scene: Scene, state: State, stage: Stage, wear_depth: Array, guess: Array | None
) -> tuple[ContactSolution, Array]:
    """Contact of a stage after a state, and its elastic displacement."""
    solid, separation = elastic_bodies(scene)
    fidelity, wear = scene.fidelity, scene.wear
    initial, displacement = (
        _extrapolated(state, stage.normal_load) if guess is None else (guess, None)
    )
    if wear:
        solid = wear.yielding(solid, stage.implicit_distance)
        if displacement is not None and initial is not None:
            displacement += wear.depth(initial, stage.implicit_distance)
    shape = separation + wear_depth
    contact = solve_contact(
        solid,
        shape,
        stage.normal_load / scene.pin.patches(scene.grid),
        hardness=scene.hardness,
        tolerance=fidelity.contact_tolerance,
        criterion=fidelity.contact_criterion,
        initial_pressure=initial,
        initial_displacement=displacement,
    )
    check_contact(
        contact.pressure,
        stage.normal_load,
        _element_area(scene),
        scene.hardness,
        contact.residual,
        fidelity.contact_tolerance if fidelity.contact_criterion == "gap" else np.inf,
    )
    displacement = contact.gap + contact.approach - shape
    if wear:
        displacement -= wear.depth(contact.pressure, stage.implicit_distance)
    return contact, displacement


def _element_area(scene: Scene) -> float:
    """Area that an element stands for, on the whole pin [m²]."""
    return scene.grid.element_area * scene.pin.patches(scene.grid)


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
        and ``pin_heat_share``, NaN where the temperature was not asked for. What the size of the
        elements decides, ``contact_fraction`` to ``saturated_fraction``, is NaN at the steps that
        are taken on the coarser grid of the history; see `Fidelity.history_coarsening`.

    Notes
    -----
    A rough surface on larger elements touches on more of the window. In the paper's system, at
    200 and 750 N on two surfaces, the presets ``standard`` and ``draft`` have 14 to 17 % and 40 to
    50 % more contact than the pixels themselves, 12 to 14 % and 29 to 34 % less mean pressure, and
    27 to 31 % and 57 to 68 % less of it at the hardness; width and highest pressure agree within
    1.5 %.
    """
    pressure, patch = state.pressure, scene.grid  # as large on the grid of the history
    pin_area = patch.area * scene.pin.patches(patch)
    if pressure.shape != patch.shape:
        of_contact = dict.fromkeys(_OF_CONTACT, np.nan)
    else:
        of_contact = dict(zip(_OF_CONTACT, _contact_measures(scene, pressure), strict=True))
    return {
        "time": state.time,
        "normal_load": state.normal_load,
        "sliding_distance": state.sliding_distance,
        **of_contact,
        "wear_depth_max": float(state.wear_depth.max()),
        "wear_volume": float(state.wear_depth.mean()) * pin_area,
        "iterations": float(state.iterations),
        "residual": state.residual,
        "max_rise": state.heat.max_rise if state.heat else np.nan,
        "mean_rise": state.heat.mean_rise if state.heat else np.nan,
        "pin_heat_share": state.heat.pin_heat_share if state.heat else np.nan,
    }


def _contact_measures(scene: Scene, pressure: Array) -> tuple[float, ...]:
    """What `_OF_CONTACT` names."""
    contact = pressure > 0
    nodes = int(np.count_nonzero(contact))
    rows = np.flatnonzero(contact.any(axis=1))
    width = int(rows[-1] - rows[0]) + 1 if nodes else 0
    return (
        nodes / pressure.size,
        width / len(pressure) * scene.grid.size[0],
        float(pressure.max()),
        float(pressure.sum()) / max(nodes, 1),
        np.count_nonzero(pressure >= scene.hardness) / max(nodes, 1),
    )


def warnings(scene: Scene, state: State) -> list[PointWarning]:
    """What a user should know about a state before relying on it."""
    found = [*_unstable_wear(scene, state), *_few_steps(scene, state)]
    touched = [
        f"{name} edge"
        for name, axis in (("x", 0), ("y", 1))
        if not scene.grid.periodic[axis] and np.take(state.pressure, (0, -1), axis=axis).any()
    ]
    if touched:
        text = (
            f"contact touches the window's {' and '.join(touched)} at {state.normal_load:g} N; "
            "a wider window would carry load there too"
        )
        found.append(PointWarning(WarningKind.CONTACT_AT_EDGE, text))
    return found + _few_nodes(scene, state)


def _few_nodes(scene: Scene, state: State) -> list[PointWarning]:
    """Whether so few elements touch that larger ones than the pixels err by many percent."""
    nodes, known = int(np.count_nonzero(state.pressure)), _ordered_nodes(scene, state)
    if not 0 < known < _FEW_NODES or scene.fidelity.pixels_per_element == 1:
        return []
    text = (
        f"only {nodes} elements touch at {state.normal_load:g} N, so that the boundary may be off "
        f"by some {60 / np.sqrt(known):.0f} %; take smaller elements (pixels_per_element = 1), "
        "or ask for an accuracy"
    )
    return [PointWarning(WarningKind.FEW_NODES, text)]


def _ordered_nodes(scene: Scene, state: State) -> int:
    """Elements that touch; in a plane, where they are in order of their heat, as many squared."""
    nodes = int(np.count_nonzero(state.pressure))
    return nodes**2 if scene.is_plane else nodes


def _few_steps(scene: Scene, state: State) -> list[PointWarning]:
    """Whether what wears has come here in fewer steps than its shape is known with."""
    wears = scene.wear is not None and scene.wear.specific_wear_rate > 0
    if not wears or not 0 < state.index < _FEWEST_STEPS:
        return []
    text = (
        f"{state.normal_load:g} N is reached in {state.index} steps, in which the shape of the "
        f"wear is known poorly; take increments that lead there in {_FEWEST_STEPS} or more"
    )
    return [PointWarning(WarningKind.FEW_STEPS, text)]


def _step_lengths(scene: Scene, state: State, holding: bool) -> list[float]:
    """Durations of the steps so far, those of the hold or those before it [s]."""
    if state.on_trunk:
        return [] if holding else [state.time / state.index] * state.index
    loading = scene.loading.stations(state.normal_load, scene.fidelity.increments)
    stations = [station for station in loading if station.time <= state.time]
    times = [0.0, *(station.time for station in stations)]
    return [
        station.time - before
        for before, station in zip(times, stations, strict=False)
        if station.holding == holding
    ]


def _unstable_wear(scene: Scene, state: State) -> list[PointWarning]:
    """Where steps so far have been too long for explicit wear, and how many would do."""
    fidelity = scene.fidelity
    if not scene.wear or fidelity.wear_scheme != "explicit" or not state.normal_load:
        return []
    solid, _ = elastic_bodies(scene)
    velocity = state.sliding_distance / state.time
    found = []
    for holding, name in ((False, "increments"), (True, "steps of the hold")):
        lengths = _step_lengths(scene, state, holding)
        stiffness = scene.wear.stiffness(solid, velocity * max(lengths, default=0.0))
        if stiffness >= EXPLICIT_LIMIT:
            count = len(lengths) if holding else fidelity.increments
            text = (
                f"explicit wear is unstable: k·dS is {stiffness:.1f} times the smallest compliance "
                f"of the grid, the limit is {EXPLICIT_LIMIT:g}; take at least "
                f"{int(count * stiffness / EXPLICIT_LIMIT) + 1} {name}, or another wear scheme"
            )
            found.append(PointWarning(WarningKind.UNSTABLE_WEAR, text))
    return found


def _refined(
    levels: tuple[Scene, ...], before: State, after: State, station: Station, velocity: float
) -> State:
    """Repeat the step from `before` to `after` on ever finer grids, each begun with the last."""
    state = after
    for scene in levels[1:]:
        on_grid = replace(
            before,
            pressure=_prolonged(before.pressure, scene.grid.shape),
            wear_depth=_prolonged_along_x(before.wear_depth, scene.grid.shape),
            previous_pressure=_prolonged(before.previous_pressure, scene.grid.shape),
        )
        guess = _prolonged(state.pressure, scene.grid.shape)
        finer = advance(scene, on_grid, station, velocity, guess)
        state = replace(
            finer,
            iterations=state.iterations + finer.iterations,
            work=state.work + finer.work,
            history=after,
        )
    return state


def _prolonged(field: Array, shape: tuple[int, int]) -> Array:
    """A field on finer elements, each with the value of the one that it was part of."""
    for axis, n in enumerate(shape):
        field = np.repeat(field, n // field.shape[axis], axis)
    return field


def _prolonged_along_x(wear_depth: Array, shape: tuple[int, int]) -> Array:
    """Swept wear on finer elements: linear along x, and uniform along y."""
    at, known = ((np.arange(n) + 0.5) / n for n in (shape[0], len(wear_depth)))
    profile = np.interp(at, known, wear_depth[:, 0])
    return np.repeat(profile[:, None], shape[1], axis=1)


def _on_own_grid(scene: Scene, normal_load: float, velocity: float) -> Iterator[State]:
    """The simulation from its start with no coarser history, as long as it is asked for."""
    state = start(replace(scene, fidelity=replace(scene.fidelity, history_coarsening=1)))
    for station in scene.stations(normal_load):
        state = advance(scene, state, station, velocity)
        yield state


def _reaching(index: int, states: Iterator[State], instead_of: State) -> State:
    """The one of the states that has an index, with the work of all that led to it."""
    work = instead_of.work
    for state in states:
        work += state.work
        if state.index == index:
            return replace(state, work=work)
    return instead_of


def _extrapolated(state: State, normal_load: float) -> tuple[Array | None, Array | None]:
    """Pressure and elastic displacement at the next load, linear through the last two states.

    The pressure as it is where the load has hardly changed before, as in a hold.
    """
    if state.normal_load == 0.0:
        return None, None
    change, before = normal_load - state.normal_load, state.normal_load - state.previous_load
    if state.previous_load == 0.0 or abs(change) >= _FARTHEST * abs(before):
        return state.pressure, None
    ratio = change / before
    pressure = state.pressure + ratio * (state.pressure - state.previous_pressure)
    if state.displacement is None or state.previous_displacement is None:
        return pressure, None
    rise = state.displacement - state.previous_displacement
    return pressure, state.displacement + ratio * rise
