"""Window that is wide enough for a pin worn in stages.

Stages slide so far that the worn contact is several times as wide as after a ramp: with four stages
of 100 N and 60 s 1.05 mm instead of 0.25 mm. In a window of 0.47 mm the fourth stage is 14 K too
hot.
"""

from __future__ import annotations

import math
from dataclasses import replace

import scipy

from tribo.constants import WINDOW_OVER_WORN_WIDTH
from tribo.errors import InputError
from tribo.loading import Stages
from tribo.simulation.scene import Scene
from tribo.surface import MeasuredRoughness
from tribo.wear import Wear


def widen_window(scene: Scene, velocity: float) -> Scene:
    """Scene whose window is 1.25 times as wide as the pin is worn at the end of its stages.

    Under a ball or crowned pin it is widened along y, too. The scene is returned unchanged if its
    window is wide enough, if it has no stages or no constant wear rate, and if the pin rolls at the
    sliding `velocity` [m/s], since it then wears all around. The number of elements is even, and
    suits coarser elements and the transforms. A measured surface is not widened: an `InputError`
    names the pixels that are needed.

    Examples
    --------
    >>> import tribo
    >>> stages = tribo.Stages(loads=(5.0, 10.0), hold_times=(600.0, 600.0), rate=10.0)
    >>> worn = replace(scene, loading=stages, wear=tribo.Wear(1e-17))
    >>> scene.pixels.shape, widen_window(worn, velocity=1.0).pixels.shape
    ((64, 64), (120, 120))
    """
    pixels, pin, wear = scene.pixels, scene.pin, scene.wear
    is_rolling = scene.velocities_at(velocity).pin != 0
    if not isinstance(scene.loading, Stages) or not isinstance(wear, Wear) or is_rolling:
        return scene
    volume = wear.specific_wear_rate * scene.loading.worn_impulse(velocity)
    size_x = WINDOW_OVER_WORN_WIDTH * pin.worn(0.0, volume).width
    size_y = size_x * pin.hertz(1.0, 1e11).aspect if pin.length is None else 0.0
    fidelity, (nx, ny), (dx, dy) = scene.fidelity, pixels.shape, pixels.spacing
    block = fidelity.pixels_per_element * max(2, fidelity.history_coarsening)
    shape = _widened_count(nx, size_x / dx, block), _widened_count(ny, size_y / dy, block)
    if shape == pixels.shape:
        return scene
    if isinstance(scene.roughness, MeasuredRoughness):
        raise InputError(
            f"the pin is worn {1e3 * size_x / WINDOW_OVER_WORN_WIDTH:.3g} mm wide at the end of "
            f"its stages; give {shape[0]} × {shape[1]} pixels, and mirror the measured surface if "
            "it has fewer"
        )
    return replace(scene, pixels=replace(pixels, shape=shape))


def _widened_count(count: int, needed: float, block: int) -> int:
    """Number of pixels: `count`, or at least `needed` and a fast multiple of `block`."""
    if needed <= count:
        return count
    return block * int(scipy.fft.next_fast_len(math.ceil(needed / block)))
