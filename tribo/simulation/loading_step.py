"""One step of a loading: contact and wear from one state to the next."""

from __future__ import annotations

import math
from collections.abc import Iterable, Iterator

import numpy as np

from tribo.constants import GUESSED_CONTACT, MAX_EXTRAPOLATION
from tribo.contact import ContactSolution, solve_contact
from tribo.loading import LoadStep
from tribo.simulation.cache import elastic_bodies
from tribo.simulation.disk_positions import Pass, passes, separation_at
from tribo.simulation.invariants import check_contact, check_wear, guard_range
from tribo.simulation.scene import Scene
from tribo.simulation.state import EarlierContact, State
from tribo.simulation.step_wear import step_wear
from tribo.types import Array
from tribo.wear import Wear, WearScheme


def start(scene: Scene) -> State:
    """Unloaded, unworn state from which all ramps of a scene begin, on its coarsest grid.

    Examples
    --------
    >>> import tribo
    >>> start(scene).normal_load
    0.0
    """
    zero = np.zeros(next(scene.levels()).grid.shape)
    return State(
        pressure=zero,
        wear_depth=zero,
        normal_load=0.0,
        time=0.0,
        sliding_distance=0.0,
        impulse=0.0,
        index=0,
        iterations=0,
        residual=0.0,
    )


@guard_range("a step of the loading")
def advance(
    scene: Scene,
    state: State,
    load_step: LoadStep,
    velocity: float,
    guess: Array | None = None,
    observed: bool = True,
    scheme: WearScheme = "sdirk2",
) -> State:
    """Advance load and sliding to `load_step`; the pin wears meanwhile.

    Parameters
    ----------
    scene : Scene
        System to simulate.
    state : State
        State at an earlier time.
    load_step : LoadStep
        Time and load at the end of the step.
    velocity : float
        Sliding velocity [m/s], which the disk has along +x unless the scene has a motion.
    guess : ndarray, shape (nx, ny), optional
        Guess of the first contact's pressure [Pa]; extrapolated from the last two states if not
        given.
    observed : bool, optional
        Under swept wear the pin wears against a shifted disk. True to solve the contact with the
        unshifted disk afterwards, which gives the pressure of the state.
    scheme : {"sdirk2", "implicit"}, optional
        Time integration of the wear, one of `tribo.wear.WEAR_SCHEMES`.

    Returns
    -------
    State
        State at the load step, without a temperature.

    Examples
    --------
    >>> import tribo
    >>> first = next(iter(scene.load_steps(10.0)))
    >>> advance(scene, start(scene), first, velocity=0.065).normal_load
    10.0
    """
    wear_depth, iterations, residual = state.wear_depth, 0, 0.0
    distance = abs(velocity) * (load_step.time - state.time)
    wear = step_wear(scene, state, distance, velocity)
    last_pressure = state.pressure if guess is None else guess
    for contact_pass in passes(scene, state, load_step, wear, velocity, observed, scheme):
        # The best guess for the unshifted disk is extrapolated from the last two states. For
        # shifted positions it is the pressure of the last contact.
        is_shifted = contact_pass.shift is not None or contact_pass.strip_shifts
        extrapolated = (guess is None and not is_shifted) or not last_pressure.any()
        pass_guess = None if extrapolated else last_pressure
        contact, displacement = solve_pass(scene, state, contact_pass, wear, wear_depth, pass_guess)
        iterations, residual = iterations + contact.iterations, max(residual, contact.residual)
        if wear:
            wear_depth = wear_depth + wear.depth(contact.pressure, contact_pass.stage.distance)
        last_pressure = contact.pressure
    if wear:
        area = _element_area(scene) * scene.windows_worn(velocity)
        volume = _worn_volume(scene, wear, state, load_step, velocity, area)
        check_wear(state.wear_depth, wear_depth, area, volume)
    return State(
        pressure=contact.pressure,
        wear_depth=wear_depth,
        normal_load=load_step.normal_load,
        time=load_step.time,
        # Not summed over the steps, so that the last bits do not depend on the steps.
        sliding_distance=abs(velocity) * load_step.time,
        impulse=load_step.impulse,
        index=load_step.index,
        iterations=iterations,
        residual=residual,
        displacement=displacement,
        earlier=EarlierContact(state.pressure, state.normal_load, state.displacement),
    )


def _worn_volume(
    scene: Scene,
    wear: Wear,
    state: State,
    load_step: LoadStep,
    velocity: float,
    element_area: float,
) -> float:
    """Volume that the whole pin has lost from the start to `load_step`, the end of a step [m³]."""
    rate = wear.specific_wear_rate * abs(velocity)
    if scene.wears_by_law:  # the rate is that of this step only
        volume_before = float(state.wear_depth.sum()) * element_area
        return volume_before + rate * (load_step.impulse - state.impulse)
    return rate * load_step.impulse


def solve_pass(
    scene: Scene,
    state: State,
    contact_pass: Pass,
    wear: Wear | None,
    wear_depth: Array,
    guess: Array | None,
) -> tuple[ContactSolution, Array]:
    """Solve one of the contacts of a step; return the solution and elastic displacement [m].

    `contact_pass` has the load, and the shift of the disk. The pin is already worn by `wear_depth`
    [m]. If `wear` is not None, the pressure that is sought wears the pin, too. The solver starts
    from the pressure `guess` [Pa], or from an extrapolation of the pressures of `state` and the
    state before if `guess` is None.
    """
    solid, stage = elastic_bodies(scene).solid, contact_pass.stage
    initial, displacement = (
        _extrapolate(state, stage.normal_load) if guess is None else (guess, None)
    )
    if wear:
        # The unknown pressure also wears the shape, which acts as an additional compliance.
        solid = wear.yielding(solid, stage.implicit_distance)
        if displacement is not None and initial is not None:
            displacement += wear.depth(initial, stage.implicit_distance)
    shape = separation_at(scene, contact_pass.shift, contact_pass.strip_shifts) + wear_depth
    contact = solve_contact(
        solid,
        shape,
        stage.normal_load / scene.pin.windows(scene.grid),
        hardness=scene.hardness,
        tolerance=scene.contact_tolerance,
        initial_pressure=initial,
        initial_displacement=displacement,
    )
    check_contact(
        contact.pressure,
        stage.normal_load,
        _element_area(scene),
        scene.hardness,
        contact.residual,
        scene.contact_tolerance,
    )
    displacement = contact.gap + contact.approach - shape
    if wear:
        displacement -= wear.depth(contact.pressure, stage.implicit_distance)
    return contact, displacement


def guess_pressure(scene: Scene, state: State, shapes: Iterable[Array]) -> Iterator[Array]:
    """Guess the pressures [Pa] on `shapes` [m], from a contact of the same pin on other roughness.

    That contact is the `state`, on elements of any size. The pin is displaced as in that contact,
    on average along y, and elements carry the load in proportion to their overlap.
    """
    displacement = state.displacement
    if displacement is None:
        displacement = elastic_bodies(scene).solid(state.pressure)
    rows = displacement.mean(axis=1).repeat(scene.grid.shape[0] // len(displacement))
    share = GUESSED_CONTACT * np.count_nonzero(state.pressure) / state.pressure.size
    load = state.normal_load / _element_area(scene)
    for shape in shapes:
        gap = shape + rows[:, None]
        touching = min(math.ceil(share * gap.size), gap.size - 1)
        overlap = np.maximum(np.partition(gap, touching, axis=None)[touching] - gap, 0.0)
        total = float(overlap.sum())
        yield np.minimum(overlap * (load / total), scene.hardness) if total else np.ones(gap.shape)


def _element_area(scene: Scene) -> float:
    """Area of the whole pin that one element of the window represents [m²]."""
    return scene.grid.element_area * scene.pin.windows(scene.grid)


def _extrapolate(state: State, normal_load: float) -> tuple[Array | None, Array | None]:
    """Pressure [Pa] and displacement [m] at a load [N], extrapolated from two states, or None."""
    if state.normal_load == 0.0:
        return None, None
    earlier = state.earlier
    if earlier is None or earlier.normal_load == 0.0:
        return state.pressure, None
    change, last_change = normal_load - state.normal_load, state.normal_load - earlier.normal_load
    if abs(change) >= MAX_EXTRAPOLATION * abs(last_change):
        return state.pressure, None
    ratio = change / last_change
    pressure = state.pressure + ratio * (state.pressure - earlier.pressure)
    if state.displacement is None or earlier.displacement is None:
        return pressure, None
    return pressure, state.displacement + ratio * (state.displacement - earlier.displacement)
