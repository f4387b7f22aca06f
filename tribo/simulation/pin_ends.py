"""Temperature at the ends of a pin that is computed with them."""

from __future__ import annotations

import numpy as np

from tribo.constants import END_LENGTH
from tribo.simulation.scene import Scene
from tribo.simulation.state import State
from tribo.thermal.quantiles import QUANTILES, contact_quantiles
from tribo.types import Array


def has_free_ends(scene: Scene) -> bool:
    """True for a pin whose window is as long as the pin, and free along y."""
    return scene.pin.length is not None and not scene.pixels.periodic[1]


def end_length(scene: Scene) -> float:
    """Length of an end of a pin [m]."""
    return min(END_LENGTH, (scene.pin.length or 0.0) / 2)


def end_rise_ratio(scene: Scene, state: State) -> Array:
    """Rise of the hottest end of a pin over that of the whole pin, for each of `QUANTILES`.

    An end is 0.4 mm long, or half of a shorter pin. Each quantile is that of the hotter end over
    its own contact area. All are NaN without free ends, and if no end touches.

    Examples
    --------
    >>> import tribo
    >>> *_, state = tribo.simulate(scene, normal_load=10.0, velocity=0.065)
    >>> bool(np.isnan(end_rise_ratio(scene, state)).all())  # a ball has no ends
    True
    """
    contact, heat = state.pressure > 0, state.heat
    ratio = np.full(len(QUANTILES), np.nan)
    if not has_free_ends(scene) or heat is None or not contact.any():
        return ratio
    count = round(end_length(scene) / scene.pixels.size[1] * contact.shape[1])
    ends = [
        contact_quantiles(heat.rise[:, part], contact[:, part])
        for part in (slice(count), slice(-count, None))
        if contact[:, part].any()
    ]
    if not ends:
        return ratio
    pin_rise = contact_quantiles(heat.rise, contact)
    np.divide(np.max(ends, axis=0), pin_rise, out=ratio, where=pin_rise > 0)
    return ratio
