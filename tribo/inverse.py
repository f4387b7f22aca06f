"""Critical temperature and wear rate of a system, found from measurements.

The simulation takes what was measured, and is solved for what was not.
"""

from __future__ import annotations

import functools
import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from typing import NamedTuple

import numpy as np

from tribo.errors import InputError, require_positive
from tribo.simulation import (
    Corrections,
    Friction,
    Scene,
    advance,
    measures,
    moment_of,
    simulate,
    start,
)
from tribo.thermal import Criterion, add_bulk_ratio
from tribo.wear import Wear, WearPattern

_WEAR_RATES = 1e-20, 1e-8  # where one is looked for [m²/N]; boundary lubrication has about 1e-15
_PRECISION = 0.01  # relative precision of the wear rate


class Transition(NamedTuple):
    """A measured transition from mild to severe wear: load [N], velocity [m/s], friction.

    Examples
    --------
    >>> Transition(normal_load=600.0, velocity=1.5, friction=0.1).velocity
    1.5
    """

    normal_load: float
    velocity: float
    friction: float


@dataclass(frozen=True, slots=True)
class CriticalTemperature:
    """Temperature at which a lubricant fails, from measured transitions.

    Attributes
    ----------
    temperatures : tuple of float
        Critical temperature found from each transition, on the scale of the bulk temperature.
    mean : float
        Mean of these temperatures, on the same scale.
    spread : float
        Standard deviation of the single ones; NaN if there is but one.

    Examples
    --------
    >>> CriticalTemperature(temperatures=(418.0, 412.0), mean=415.0, spread=4.2).mean
    415.0
    """

    temperatures: tuple[float, ...]
    mean: float
    spread: float


def critical_temperature(
    scene: Scene,
    transitions: Sequence[tuple[float, float, float]],
    bulk_temperature: float,
    criterion: Criterion | float = 0.1,
    bulk_difference: float = 0.0,
    corrections: Corrections | None = None,
) -> CriticalTemperature:
    """Critical temperature from measured transitions: the deciding temperature there.

    Bosman & de Rooij propose this for oils whose critical temperature no rig can measure
    (Table 6). A good model gives the same temperature at all transitions.

    Parameters
    ----------
    scene : Scene
        System in which the transitions were measured.
    transitions : sequence of Transition
        Loads, velocities and frictions at which mild wear became severe.
    bulk_temperature : float
        Bulk temperature of both bodies, or of the pin where they differ [K] or [°C].
    criterion : Criterion or float
        Criterion of severe wear, or the share of the contact area above the critical temperature.
    bulk_difference : float
        Bulk temperature of the disk less that of the pin [K]; the scene must have `unequal_bulks`
        if it is not 0.
    corrections : Corrections, optional
        Physics beside the half-spaces; of its friction nothing is used, since each
        transition has its friction.

    Examples
    --------
    >>> import tribo.inverse
    >>> tests = [(10.0, 0.065, 0.1)]
    >>> oil = tribo.inverse.critical_temperature(scene, tests, bulk_temperature=298.15)
    >>> f"{oil.mean:.0f} K"
    '305 K'
    """
    if not transitions:
        raise InputError("there is no transition; at least one is needed")
    if not math.isfinite(bulk_temperature + bulk_difference):
        raise InputError(
            f"bulk_temperature is {bulk_temperature!r} and bulk_difference {bulk_difference!r}; "
            "both must be finite"
        )
    decisive = Criterion.of(criterion)
    apart = replace(corrections, friction=Friction()) if corrections else None
    for _, _, friction in transitions:
        require_positive(friction=friction)
    temperatures = []
    for normal_load, velocity, friction in transitions:
        ratio = bulk_difference / friction
        rise = max(
            float(decisive.rise(add_bulk_ratio(moment_of(scene, state, apart), ratio)))
            for state in simulate(scene, normal_load, velocity)
            if state.heat and state.normal_load >= normal_load
        )
        temperatures.append(bulk_temperature + friction * rise)
    spread = float(np.std(temperatures, ddof=1)) if len(temperatures) > 1 else math.nan
    return CriticalTemperature(tuple(temperatures), float(np.mean(temperatures)), spread)


@dataclass(frozen=True, slots=True)
class WearRate:
    """Specific wear rate that explains a measured contact width [m²/N].

    Attributes
    ----------
    value : float
        Specific wear rate, the geometric mean of its bounds [m²/N].
    lowest, highest : float
        Specific wear rates at which the width is half a step of the grid less or more than
        measured, widened by the 1 % to which rates are found.

    Examples
    --------
    >>> WearRate(value=1.2e-15, lowest=1.1e-15, highest=1.3e-15).value
    1.2e-15
    """

    value: float
    lowest: float
    highest: float


def specific_wear_rate(
    scene: Scene, contact_width: float, normal_load: float, velocity: float
) -> WearRate:
    """Specific wear rate of the pin from the width of its contact after a loading.

    Wear flattens the pin, and so the contact is the wider the more it has worn. Widths are whole
    numbers of elements, and grow by two at a time where both bodies are smooth, so that a measured
    one belongs to a range of wear rates.

    Parameters
    ----------
    scene : Scene
        System in which the pin wore. Its wear rate is not used. The pattern of its wear is: swept
        if the scene has no wear and its patch is periodic along y, else local.
    contact_width : float
        Width of the contact along x at the end of the loading [m]. Further sliding at full
        load is part of the loading, as a hold.
    normal_load, velocity : float
        Load on the whole pin at the end [N], and sliding velocity [m/s].

    Raises
    ------
    InputError
        If no wear rate makes the contact that wide within the scene's window, or the pin rolls.

    Examples
    --------
    >>> import tribo.inverse
    >>> rate = tribo.inverse.specific_wear_rate(scene, 185e-6, normal_load=10.0, velocity=0.065)
    >>> f"{rate.lowest:.1e} to {rate.highest:.1e} m²/N"
    '1.4e-17 to 3.2e-17 m²/N'
    """
    grid = scene.grid
    if scene.velocities_at(velocity).pin:
        raise InputError(
            "the scene's motion makes the pin roll: it wears all around its track, which makes its "
            "contact no wider, so that a width does not tell a wear rate"
        )
    half = grid.spacing[0] * (0.5 if scene.roughness else 1.0)  # a smooth contact is symmetric
    pattern: WearPattern = "swept" if grid.periodic[1] else "local"
    fidelity = replace(scene.fidelity, heat_model="elapsed", history_coarsening=1)

    @functools.cache
    def width(rate: float) -> float:
        wear = Wear(rate, scene.wear.pattern if scene.wear else pattern)
        worn = replace(scene, wear=wear, fidelity=fidelity)
        state = start(worn)
        for station in worn.stations(normal_load):
            state = advance(worn, state, station, velocity)
        return measures(worn, state)["contact_width"]

    if not width(0.0) + half < contact_width <= grid.size[0] - half:
        raise InputError(
            f"contact_width is {contact_width:.4g} m; it must lie between {width(0.0):.4g} m, "
            f"which the contact has without wear, and the {grid.size[0]:.4g} m of the window: "
            "compare the unit, load and velocity with what was measured, or take a wider window"
        )
    lowest, _ = _crossing(lambda rate: width(rate) >= contact_width - half)
    _, highest = _crossing(lambda rate: width(rate) >= contact_width + half)
    return WearRate(math.sqrt(lowest * highest), lowest, highest)


def _crossing(exceeds: Callable[[float], bool]) -> tuple[float, float]:
    """Wear rates, hardly apart, between which the contact gets wider than asked."""
    low = high = 1e-15
    while exceeds(low):
        high, low = low, low / 10
        if low < _WEAR_RATES[0]:
            return low, high
    while not exceeds(high):
        low, high = high, high * 10
        if high > _WEAR_RATES[1]:
            raise InputError(
                f"no specific wear rate up to {low:g} m²/N makes the contact so wide; "
                "compare its unit"
            )
    while high > (1 + _PRECISION) * low:
        middle = math.sqrt(low * high)
        low, high = (low, middle) if exceeds(middle) else (middle, high)
    return low, high
