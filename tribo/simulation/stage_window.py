"""A window that is wide enough for a pin that stages have worn.

Stages slide so far that the worn chord is several times that of a fresh ramp: with four stages of
100 N and 60 s it is 1.05 mm, for 0.25 mm. In a window of 0.47 mm the fourth stage is 14 K too hot.
"""

from __future__ import annotations

import math
from dataclasses import replace

import scipy

from tribo.constants import ROOM_BESIDE_WEAR
from tribo.errors import InputError
from tribo.loading import Stages
from tribo.simulation.scene import Scene
from tribo.surface import MeasuredRoughness
from tribo.wear import Wear


def widen_window(scene: Scene, velocity: float) -> Scene:
    """Scene whose window is 1.25 times as wide as the pin is worn at the end of its stages.

    Under a ball or crowned pin it is as much wider along y. The scene is returned unchanged if its
    own window is as wide, has no stages, or does not wear by a constant rate, and for a pin that
    rolls at the sliding `velocity` [m/s], which wears all around. The number of elements is even,
    and suits coarser elements and the transforms. A measured surface is not widened, but refused
    by an `InputError` that names the pixels.

    Examples
    --------
    >>> import tribo
    >>> stages = tribo.Stages(loads=(5.0, 10.0), holds=(600.0, 600.0), rate=10.0)
    >>> worn = replace(scene, loading=stages, wear=tribo.Wear(1e-17))
    >>> scene.pixels.shape, widen_window(worn, velocity=1.0).pixels.shape
    ((64, 64), (120, 120))
    """
    pixels, pin, wear = scene.pixels, scene.pin, scene.wear
    is_rolling = scene.velocities_at(velocity).pin != 0
    if not isinstance(scene.loading, Stages) or not isinstance(wear, Wear) or is_rolling:
        return scene
    volume = wear.specific_wear_rate * scene.loading.worn_impulse(velocity)
    wide = ROOM_BESIDE_WEAR * pin.worn(0.0, volume).width
    deep = wide * pin.hertz(1.0, 1e11).aspect if pin.length is None else 0.0
    fidelity, (nx, ny), (dx, dy) = scene.fidelity, pixels.shape, pixels.spacing
    block = fidelity.pixels_per_element * max(2, fidelity.history_coarsening)
    shape = _wider(nx, wide / dx, block), _wider(ny, deep / dy, block)
    if shape == pixels.shape:
        return scene
    if isinstance(scene.roughness, MeasuredRoughness):
        raise InputError(
            f"the pin is worn {1e3 * wide / ROOM_BESIDE_WEAR:.3g} mm wide at the end of its "
            f"stages; give {shape[0]} × {shape[1]} pixels, and mirror the measured surface if it "
            "has fewer"
        )
    return replace(scene, pixels=replace(pixels, shape=shape))


def _wider(count: int, needed: float, block: int) -> int:
    """Number of pixels, `count` or more if more are `needed`: a fast multiple of `block`."""
    if needed <= count:
        return count
    return block * int(scipy.fft.next_fast_len(math.ceil(needed / block)))
