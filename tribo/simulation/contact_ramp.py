"""Contact and wear along a loading: the first of the three layers of a point.

Contact and wear know the load, the surface, the elastic constants, the hardness, and of the sliding
velocity V only how fast it wears the pin. A step of the duration t wears by

    h = k V t p = w t p,   w = kV,                                                            (1)

k the specific wear rate, p the pressure. So two systems of one wear number w have the same contacts
at every load, whatever their velocities and thermal constants, and these need to be solved only
once for all of them. `tribo.heat` acts on contacts, and the conditions of wear on heat.
`inseparable` says where that does not hold.

Where nothing wears, w is 0 at every velocity, and the contact at a load is kept for the next ones.
Where the pin wears, a ramp of contacts is long, and whoever asks for many keeps what he needs.

That counts for all contacts of a point, also those of larger elements before its last step, of a
step's short end, and of smaller elements where few touch: none of these choices asks for a
temperature.
"""

from __future__ import annotations

import functools
import math
from collections.abc import Iterable, Iterator
from dataclasses import fields, replace
from typing import Any

import numpy as np

from tribo.errors import InputError, require_positive
from tribo.laws import OwnWear
from tribo.loading import Station
from tribo.simulation.cache import unworn_contact
from tribo.simulation.disk_positions import Pass, spread
from tribo.simulation.fidelity import Fidelity
from tribo.simulation.implicit_end import ended
from tribo.simulation.loading_step import advance, solved, start
from tribo.simulation.point_warnings import FEW_NODES, ordered_nodes
from tribo.simulation.scene import Scene
from tribo.simulation.state import State
from tribo.types import Array
from tribo.wear import Stage

# Tolerance of the contacts where few elements touch, whose hottest are few: on 57 random scenes
# `standard` had rises up to 2.5 % off with its own, and up to 0.3 % with this.
_TIGHT = 1e-3


def wear_number(scene: Scene, velocity: float) -> float:
    """Wear of the pin per pressure and time, ``w = k |V|`` [m/(Pa s)]; Eq. (1) of this module.

    Examples
    --------
    >>> import tribo
    >>> from dataclasses import fields, replace
    >>> mild = tribo.critical_temperature_rig()
    >>> worn = replace(mild, wear=tribo.Wear(2e-15))
    >>> tribo.wear_number(mild, 0.5), tribo.wear_number(worn, 0.5)
    (0.0, 1e-15)
    """
    return scene.wear.specific_wear_rate * abs(velocity) if scene.wear else 0.0


def mechanics(scene: Scene) -> Scene:
    """The scene with a wear rate and thermal constants of 1: the same for all that share contacts.

    Contacts of one such scene are the same at one load and `wear_number`.

    Examples
    --------
    >>> import tribo
    >>> from dataclasses import replace
    >>> scene = tribo.critical_temperature_rig()
    >>> insulating = replace(scene, disk=replace(scene.disk, thermal_conductivity=5.0))
    >>> tribo.mechanics(insulating) == tribo.mechanics(scene)
    True
    """
    athermal = {"thermal_conductivity": 1.0, "density": 1.0, "specific_heat": 1.0}
    parts = {field.name: getattr(scene, field.name) for field in fields(Scene)}
    parts["pin"] = replace(scene.pin, material=replace(scene.pin.material, **athermal))
    parts["disk"] = replace(scene.disk, **athermal)
    if scene.wear and scene.wears and not isinstance(scene.wear, OwnWear):
        parts["wear"] = replace(scene.wear, specific_wear_rate=1.0)
    return Scene(**parts)


def inseparable(scene: Scene, velocities: Iterable[float]) -> str | None:
    """Reason why contacts of one wear number differ from velocity to velocity; None if they do not.

    Parameters
    ----------
    scene : Scene
        System to simulate, with any wear rate.
    velocities : iterable of float
        Sliding velocities that would share contacts [m/s].

    Examples
    --------
    >>> import tribo
    >>> from dataclasses import fields, replace
    >>> scene = tribo.critical_temperature_rig()
    >>> print(tribo.inseparable(scene, (0.1, 0.2)))
    None
    >>> history = replace(scene.fidelity, heat_model="history", history_coarsening=1)
    >>> tribo.inseparable(replace(scene, fidelity=history), (0.1, 0.2))
    "heat_model is 'history': temperatures depend on the heat of all the steps before"
    """
    if scene.remembers_heat:
        return "heat_model is 'history': temperatures depend on the heat of all the steps before"
    if isinstance(scene.wear, OwnWear):
        return "the wear follows a law of one's own, by the distance slid"
    if scene.wears and len({scene.windows_worn(velocity) for velocity in velocities}) > 1:
        return "the pin rolls at some of the velocities and stands still at others"
    return None


def contacts(
    scene: Scene, normal_load: float, velocity: float, trunk: State | None = None
) -> Iterator[State]:
    """Contact states along the way to `normal_load` and through its hold, without temperatures.

    They depend on the velocity through `wear_number` alone, but for `State.sliding_distance`, and
    where `inseparable` says why they do not.

    Parameters
    ----------
    scene, normal_load, velocity, trunk
        See `tribo.simulate`.

    Yields
    ------
    State
        State after every step; `State.is_asked` where a temperature is asked for, which
        `tribo.heat` gives. Where it depends on the heat of the steps before, they have it.

    Raises
    ------
    InputError, ConvergenceError
        See `tribo.simulate`.

    Examples
    --------
    Twice the wear rate at half the velocity:

    >>> import tribo
    >>> from dataclasses import fields, replace
    >>> scene = tribo.critical_temperature_rig()
    >>> one, other = (replace(scene, wear=tribo.Wear(k, "local")) for k in (1e-15, 2e-15))
    >>> *_, slow = tribo.contacts(other, normal_load=10.0, velocity=0.1)
    >>> *_, fast = tribo.contacts(one, normal_load=10.0, velocity=0.2)
    >>> bool((slow.pressure == fast.pressure).all())
    True
    """
    if not np.isfinite(velocity):
        raise InputError(f"velocity is {velocity!r}; it must be finite")
    require_positive(normal_load=normal_load)
    if normal_load > scene.greatest_load * (1 + 1e-12):
        raise InputError(
            f"normal_load is {normal_load:g} N; the window carries at most "
            f"{scene.greatest_load:g} N, its area times the hardness of {scene.hardness:g} Pa"
        )
    state = start(scene) if trunk is None else trunk.history or trunk
    if not leads_to(scene, state, normal_load):
        raise InputError(
            f"cannot go on to {normal_load:g} N from the state at {state.normal_load:g} N; "
            "it must lie on the trunk that leads there, at a lower load"
        )
    if scene.remembers_heat != (state.heat_history is not None):
        heat_model = scene.fidelity.heat_model
        raise InputError(f"heat model {heat_model!r} cannot go on from a state of the other one")
    interval, levels = scene.fidelity.temperature_interval, tuple(scene.levels())
    stations = list(scene.stations(normal_load, after=state.normal_load))
    closer, system = _Closer(scene, normal_load, velocity), mechanics(scene)

    def unworn(station: Station, is_asked: bool) -> State:
        # Where nothing remembers the way, not even a first guess may, or results would depend on
        # the stations at which a temperature is asked for.
        alone = _Closer(scene, normal_load, velocity)
        return _contact(levels, alone, start(scene), station, velocity, is_asked)[1]

    for station in stations:
        reached = station.normal_load == normal_load and not station.holding
        on_way = interval > 0 and station.index % interval == 0
        is_asked = reached or on_way or station is stations[-1]
        if scene.remembers_steps:
            state, shown = _contact(levels, closer, state, station, velocity, is_asked)
            yield shown
        else:
            key = system, normal_load, station, is_asked
            shown = unworn_contact(key, functools.partial(unworn, station, is_asked))
            yield replace(shown, sliding_distance=abs(velocity) * station.time)


def _contact(
    levels: tuple[Scene, ...],
    closer: _Closer,
    before: State,
    station: Station,
    velocity: float,
    is_asked: bool,
) -> tuple[State, State]:
    """State at a station from which the ramp goes on, and the one that is shown of it."""
    state = advance(levels[0], before, station, velocity, observed=len(levels) == 1)
    if is_asked and state.pressure.any():
        shown = closer.instead_of(_refined(levels, before, state, station, velocity))
        return state, replace(shown, is_asked=True)
    if state.heat is not None and levels[-1].fidelity.fewest_elements:
        return state, replace(state, heat=None)  # that might be of other elements than the last
    return state, state


def leads_to(scene: Scene, state: State, normal_load: float) -> bool:
    """True if the simulation of a load passes through a state, and can go on from it."""
    if not state.on_trunk or state.normal_load >= normal_load:
        return False
    return math.isclose(state.normal_load, state.index * scene.trunk(normal_load))


def _refined(
    levels: tuple[Scene, ...], before: State, after: State, station: Station, velocity: float
) -> State:
    """Repeat the step from `before` to `after` on ever finer grids, each begun with the last."""
    if levels[-1].sweeps_over and len(levels) > 1:
        return _observed(levels[-1], after)
    state, on_grid = after, before
    for scene in levels[1:]:
        on_grid = replace(
            before,
            pressure=_prolonged(before.pressure, scene.grid.shape),
            wear_depth=_prolonged_along_x(before.wear_depth, scene.grid.shape),
            previous_pressure=_prolonged(before.previous_pressure, scene.grid.shape),
            displacement=None,
        )
        guess = _prolonged(state.pressure, scene.grid.shape)
        finer = advance(scene, on_grid, station, velocity, guess)
        state = replace(
            finer,
            iterations=state.iterations + finer.iterations,
            work=state.work + finer.work,
            history=after,
        )
    return ended(levels[-1], on_grid, state, station, velocity)


def _observed(scene: Scene, after: State) -> State:
    """The contact at the disk's own position on the finest grid, worn as on the coarsest."""
    wear_depth = spread(after.wear_depth, scene.grid.shape)
    stage = Pass(Stage(after.normal_load, 0.0, 0.0))
    guess = _prolonged(after.pressure, scene.grid.shape)
    contact, displacement = solved(scene, after, stage, None, wear_depth, guess)
    return replace(
        after,
        pressure=contact.pressure,
        wear_depth=wear_depth,
        iterations=after.iterations + contact.iterations,
        work=after.work + contact.iterations * contact.pressure.size,
        residual=max(after.residual, contact.residual),
        displacement=displacement,
        previous_displacement=None,
        history=after,
    )


def _prolonged(field: Array, shape: tuple[int, int]) -> Array:
    """A field on finer elements, each with the value of the one that it was part of."""
    for axis, n in enumerate(shape):
        field = np.repeat(field, n // field.shape[axis], axis)
    return field


def _prolonged_along_x(wear_depth: Array, shape: tuple[int, int]) -> Array:
    """Swept wear on finer elements: linear along x, and uniform along y."""
    fine, coarse = ((np.arange(n) + 0.5) / n for n in (shape[0], len(wear_depth)))
    profile = np.interp(fine, coarse, wear_depth[:, 0])
    return np.repeat(profile[:, None], shape[1], axis=1)


class _Closer:
    """The point once more from its start, where few elements touch: on smaller ones or one grid.

    It is computed as far as it is asked for.
    """

    def __init__(self, scene: Scene, normal_load: float, velocity: float) -> None:
        self._scene, self._to = scene, (normal_load, velocity)
        self._states: dict[Fidelity, Iterator[State]] = {}

    def instead_of(self, state: State) -> State:
        """The same moment with more elements in contact, or as known as these allow."""
        scene = self._closer(state)
        if scene is None:
            return state
        if scene.fidelity not in self._states:
            self._states[scene.fidelity] = contacts(scene, *self._to)
        work = state.work
        for closer in self._states[scene.fidelity]:
            work += closer.work
            if closer.index == state.index:
                return replace(closer, work=work, history=state.history or state)
        return state

    def _closer(self, state: State) -> Scene | None:
        """The scene with which a state is known better, if there is need of it."""
        scene, fidelity = self._scene, self._scene.fidelity
        nodes, fewest = ordered_nodes(scene, state), fidelity.fewest_elements
        block, changes = fidelity.pixels_per_element, dict[str, Any]()
        sizes = [size for size in range(1, block) if block % size == 0]
        if sizes and nodes < fewest:
            enough = [size for size in sizes if nodes * (block / size) ** 2 >= fewest]
            changes["pixels_per_element"] = max(enough, default=1)
            nodes *= (block // changes["pixels_per_element"]) ** 2
            changes["history_coarsening"] = 1
        elif scene.wear and scene.coarsening > 1 and nodes < max(fewest, FEW_NODES):
            changes["history_coarsening"] = 1
        if fewest and nodes < FEW_NODES:
            changes["contact_tolerance"] = min(fidelity.contact_tolerance, _TIGHT)
        changed = replace(fidelity, **changes)
        return None if changed == fidelity else replace(scene, fidelity=changed)
