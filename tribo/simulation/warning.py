"""Warnings that a point may carry: their kinds, and when a state deserves them."""

from __future__ import annotations

from enum import IntFlag
from typing import NamedTuple

import numpy as np

from tribo.simulation.kernels import elastic_bodies
from tribo.simulation.passes import parts
from tribo.simulation.past import excess_of_present_heat, stations_so_far
from tribo.simulation.scene import Scene
from tribo.simulation.state import State
from tribo.wear import EXPLICIT_LIMIT, WEAR_SCHEMES

FEW_NODES = 400  # below which `draft` errs by over 8 % and `standard` by over 3 % in most scenes,
# and a coarse history of heavy wear, which does not know the summits that wear, by up to 80 %
# Wear in standard deviations of the roughness, beyond which the pin fits the disk. From 13 on, with
# 18 to 38 rows in contact, `draft` was off by up to 12.5 % and `standard` by 4.4 %.
_FITS = 10.0
_TOO_WARM, _ON_PIXELS = 0.01, 0.005  # error of the rise from which the present heat warns
_FEWEST_STEPS = 3  # or stages of steps, in which heavy wear knows the rise to about 10 %


class WarningKind(IntFlag):
    """Kinds of warnings; each is a bit, so that a number holds those of a point.

    Examples
    --------
    >>> [kind.label for kind in WarningKind(3)]
    ['unstable wear', 'contact at edge']
    """

    UNSTABLE_WEAR = 1
    CONTACT_AT_EDGE = 2
    FEW_NODES = 4
    FEW_STEPS = 8
    PRESENT_HEAT = 16

    @property
    def label(self) -> str:
        """The kind in words."""
        return (self.name or "").lower().replace("_", " ")


class PointWarning(NamedTuple):
    """What a user should know about a point before relying on it.

    Attributes
    ----------
    kind : WarningKind
        What it is about.
    text : str
        What is wrong, by how much, and what to do.

    Examples
    --------
    >>> import tribo
    >>> PointWarning(tribo.WarningKind.CONTACT_AT_EDGE, "give a wider window").kind.label
    'contact at edge'
    """

    kind: WarningKind
    text: str

    def __str__(self) -> str:
        return self.text


def warnings(scene: Scene, state: State) -> list[PointWarning]:
    """What a user should know about a state before relying on it.

    Examples
    --------
    >>> import tribo
    >>> scene = tribo.critical_temperature_rig()
    >>> *_, state = tribo.simulate(scene, normal_load=10.0, velocity=0.065)
    >>> [warning.kind.label for warning in tribo.warnings(scene, state)]
    []
    """
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
    return [*found, *_few_nodes(scene, state), *_present_heat(scene, state)]


def _few_nodes(scene: Scene, state: State) -> list[PointWarning]:
    """Warn where so few elements touch that ones larger than the pixels err by many percent."""
    known = ordered_nodes(scene, state)
    if not 0 < known < FEW_NODES or len(state.pressure) == scene.pixels.shape[0]:
        return []
    nodes, rows = int(np.count_nonzero(state.pressure)), _rows(state)
    count, errors = f"{nodes} elements touch", "0.4 to 100 %, by 10 % in the median"
    if known < nodes:
        count, errors = f"{rows} rows of elements touch a pin that wear has fitted", "up to 12 %"
    text = (
        f"only {count} at {state.normal_load:g} N; so few had the boundary of random scenes off by "
        f"{errors}; take smaller elements (fewest_elements = {FEW_NODES}, or "
        "pixels_per_element = 1), or ask for an accuracy"
    )
    return [PointWarning(WarningKind.FEW_NODES, text)]


def ordered_nodes(scene: Scene, state: State) -> int:
    """Elements that touch, as many as count where they are in order of their heat.

    In a plane that is their square. Where the pin has worn by far more than the roughness it fits
    the disk, and whole rows come into contact at a time: then it is the square of half the rows.
    """
    nodes, rows = int(np.count_nonzero(state.pressure)), _rows(state)
    if scene.is_plane:
        nodes = nodes**2
    in_rows = (rows // 2) ** 2
    return in_rows if in_rows < nodes and _fits(scene, state) else nodes


def _rows(state: State) -> int:
    """Rows along y in which any element touches."""
    return int(np.count_nonzero(state.pressure.any(axis=1)))


def _fits(scene: Scene, state: State) -> bool:
    """Whether wear has shaped the pin by far more than the roughness is high."""
    if scene.wear is None:
        return False
    heights = elastic_bodies(scene).separation - scene.pin.profile(scene.grid)
    return bool(np.ptp(state.wear_depth) > _FITS * heights.std())


def _few_steps(scene: Scene, state: State) -> list[PointWarning]:
    """Warn where a pin that wears has come here in too few steps for its shape to be known."""
    stages = len(WEAR_SCHEMES[scene.fidelity.wear_scheme].weights)
    if not scene.wears or not 0 < stages * state.index < _FEWEST_STEPS:
        return []
    count = f"{state.index} steps" if state.index > 1 else "a single step"
    text = (
        f"{state.normal_load:g} N is reached in {count}, in which the shape of the "
        f"wear is known poorly; take increments that lead there in {_FEWEST_STEPS} or more"
    )
    return [PointWarning(WarningKind.FEW_STEPS, text)]


def _present_heat(scene: Scene, state: State) -> list[PointWarning]:
    """Warn where the heat of the past is known to be less than the present, by more than counts."""
    if scene.remembers_heat:
        return []
    excess = excess_of_present_heat(scene, state)
    if excess < (_ON_PIXELS if scene.fidelity.pixels_per_element == 1 else _TOO_WARM):
        return []
    text = (
        "the present friction heat, taken to have acted since the start, makes this contact about "
        f"{100 * excess:.1f} % too warm, and so places the boundary at too low a velocity, mostly "
        "by once to twice as much; take heat_model = 'history' and history_coarsening = 1, or ask "
        "for an accuracy"
    )
    return [PointWarning(WarningKind.PRESENT_HEAT, text)]


def _step_lengths(scene: Scene, state: State, holding: bool) -> list[float]:
    """Durations of the steps so far, those of the hold or those before it [s]."""
    if state.on_trunk:
        return [] if holding else [state.time / state.index] * state.index
    stations = stations_so_far(scene, state)
    times = [0.0, *(station.time for station in stations)]
    return [
        station.time - before
        for before, station in zip(times, stations, strict=False)
        if station.holding == holding
    ]


def _unstable_wear(scene: Scene, state: State) -> list[PointWarning]:
    """Warn where steps have been too long for explicit wear, and say how many would do."""
    fidelity = scene.fidelity
    if not scene.wear or fidelity.wear_scheme != "explicit" or not state.normal_load:
        return []
    solid = elastic_bodies(scene).solid
    velocity = state.sliding_distance / state.time
    wear = scene.wear_at(velocity) or scene.wear
    found = []
    for holding, name in ((False, "increments"), (True, "steps of the hold")):
        lengths = _step_lengths(scene, state, holding)
        distance = velocity * max(lengths, default=0.0)
        stiffness = wear.stiffness(solid, distance / parts(scene, wear, distance))
        if stiffness >= EXPLICIT_LIMIT:
            count = len(lengths) if holding else fidelity.increments
            text = (
                f"explicit wear is unstable: k·dS is {stiffness:.1f} times the smallest compliance "
                f"of the grid, the limit is {EXPLICIT_LIMIT:g}; take at least "
                f"{int(count * stiffness / EXPLICIT_LIMIT) + 1} {name}, or another wear scheme"
            )
            found.append(PointWarning(WarningKind.UNSTABLE_WEAR, text))
    return found
