"""Groups of elements, for the sampling error of a contact; see `tribo.thermal.quantiles`.

Each group is a sample of the surface. Under a line contact, strips across the whole contact are
equivalent. Under a ball they are not: the strip in the middle has most of the contact, and eight
strips erred by factors of 2 to 17. There, square cells of four correlation lengths (their geometric
mean along x and y) are assigned to the groups in turn. On a lay such cells are as wide as the
contact of a small ball, and a single one has much of its heat. The cells of a lay have half the
side. If the disk is also at other positions, the groups are the same at each.
"""

from __future__ import annotations

import functools
import math

import numpy as np

from tribo.constants import LAY_RATIO
from tribo.simulation.scene import Scene
from tribo.surface import SelfAffineRoughness, correlation_lengths
from tribo.thermal.quantiles import GROUPS
from tribo.types import Indices

_CELL, _CELL_OF_LAY = 4.0, 2.0  # side of a cell in correlation lengths
_NEXT_COLUMN = 3  # groups from a cell to the next one along x; 1 along y


@functools.lru_cache(maxsize=4)  # called for each point of a sweep
def surface_groups(scene: Scene) -> Indices:
    """Number of the group of each element, from 0 to 7, shape ``grid.shape``."""
    (nx, ny), spacing = scene.grid.shape, scene.grid.spacing
    if scene.grid.periodic[1]:
        return np.broadcast_to(np.arange(ny) * GROUPS // ny, (nx, ny))
    lengths = surface_lengths(scene)
    has_lay = max(lengths) >= LAY_RATIO * min(lengths)
    cell_side = (_CELL_OF_LAY if has_lay else _CELL) * math.sqrt(math.prod(lengths))
    x, y = (
        (np.arange(n) * size / cell_side).astype(int)
        for n, size in zip((nx, ny), spacing, strict=True)
    )
    groups: Indices = (_NEXT_COLUMN * x[:, None] + y[None, :]) % GROUPS
    return groups


@functools.lru_cache(maxsize=4)
def surface_lengths(scene: Scene) -> tuple[float, float]:
    """Correlation lengths of the disk's surface along x and y [m]; infinite for a smooth disk."""
    if isinstance(scene.roughness, SelfAffineRoughness):
        return scene.roughness.correlation_length
    heights = scene.heights()
    if heights is None:
        return math.inf, math.inf
    return correlation_lengths(heights, scene.pixels.spacing)
