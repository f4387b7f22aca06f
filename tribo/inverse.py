"""Specific wear rate of a system from the measured width of its contact."""

from __future__ import annotations

import functools
import math
from collections.abc import Callable
from dataclasses import dataclass, replace

from tribo.errors import InputError, require_instance, require_positive
from tribo.simulation import Scene, advance, measures, start
from tribo.wear import Wear, WearPattern

_WEAR_RATES = 1e-20, 1e-8  # range of the search [m²/N]; boundary lubrication has about 1e-15
_PRECISION = 0.01  # relative precision of the wear rate


@dataclass(frozen=True, slots=True)
class WearRate:
    """Specific wear rate that explains a measured contact width [m²/N].

    Attributes
    ----------
    value : float
        Specific wear rate, the geometric mean of its bounds [m²/N].
    lowest, highest : float
        Wear rates at which the width is half an element (one element if both bodies are smooth)
        smaller or larger than the measured width. The search is precise to 1 %: `lowest` may be too
        low by this, and `highest` too high.

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
    """Find the specific wear rate of a pin from the width of its contact after a loading.

    The more the pin has worn, the wider is its contact. Computed widths are whole numbers of
    elements, and grow by two elements at a time if both bodies are smooth. So a range of wear rates
    gives the measured width.

    Parameters
    ----------
    scene : Scene
        System in which the pin wore. Its wear rate is not used, but its wear pattern is. Without
        wear the pattern is "swept" on a window that is periodic along y, else "local".
    contact_width : float
        Width of the contact along x at the end of the loading [m]. If the pin slid on at full
        load, the scene's loading must have this as its hold.
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
    '1.6e-17 to 3.8e-17 m²/N'
    """
    require_instance(Scene, scene=scene)
    require_positive(contact_width=contact_width, normal_load=normal_load, velocity=velocity)
    grid = scene.grid
    if scene.velocities_at(velocity).pin:
        raise InputError(
            "the pin rolls and wears all around its track, which makes its contact no wider; a "
            "wear rate from a width needs a pin at rest"
        )
    # Contacts of smooth bodies are symmetric, and grow by two elements at a time.
    margin = grid.spacing[0] * (0.5 if scene.roughness else 1.0)
    pattern: WearPattern = "swept" if grid.periodic[1] else "local"

    @functools.cache
    def width(rate: float) -> float:
        wear = Wear(rate, scene.wear.pattern if scene.wear else pattern)
        worn_scene = replace(scene, wear=wear)
        state = start(worn_scene)
        for load_step in worn_scene.load_steps(normal_load):
            state = advance(worn_scene, state, load_step, velocity)
        return measures(worn_scene, state)["contact_width"]

    if not width(0.0) + margin < contact_width <= grid.size[0] - margin:
        raise InputError(
            f"contact_width is {contact_width:.4g} m; it must lie between {width(0.0):.4g} m, "
            f"which the contact has without wear, and the {grid.size[0]:.4g} m of the window: "
            "compare the unit, load and velocity with what was measured, or use a wider window"
        )
    lowest, _ = _crossing(lambda rate: width(rate) >= contact_width - margin)
    _, highest = _crossing(lambda rate: width(rate) >= contact_width + margin)
    return WearRate(math.sqrt(lowest * highest), lowest, highest)


def _crossing(exceeds: Callable[[float], bool]) -> tuple[float, float]:
    """Two wear rates [m²/N], at most 1 % apart, between which `exceeds` changes to True."""
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
                "check the unit of contact_width"
            )
    while high > (1 + _PRECISION) * low:
        middle = math.sqrt(low * high)
        low, high = (low, middle) if exceeds(middle) else (middle, high)
    return low, high
