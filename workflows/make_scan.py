"""Write scan.npy, a synthetic scan of a ground disk, as an instrument might export it.

    python workflows/make_scan.py

Heights are whole numbers of nm, a row for each y, in pixels of 1.6 µm. The specimen lies oblique on
the stage, its peaks are worn, and the instrument has lost the steepest places: −32768.
"""

from __future__ import annotations

from pathlib import Path

import numpy as np

from tribo import Grid
from tribo.surface import self_affine
from tribo.types import Array

_PIXEL = 1.6e-6  # [m]
_SHAPE = 840, 64  # along x, the sliding direction, and y, the direction of grinding
_TILT = 1.5e-6, -0.6e-6  # height of an edge above the opposite one [m]
_WORN = 0.6  # share of its height that a peak has kept
_LOST = 0.004  # share of heights that are missing
_MISSING = -32768


def make_scan() -> Array:
    """Heights of the scan in nm, of 16 bits, a row for each y."""
    grid = Grid(_SHAPE, (_PIXEL, _PIXEL))
    heights = self_affine(grid, 0.3e-6, 0.8, (6e-6, 30e-6), seed=7)
    heights = np.where(heights > 0, _WORN * heights, heights)
    steep = np.hypot(*np.gradient(heights))
    lost = steep > np.quantile(steep, 1 - _LOST)
    x, y = (np.linspace(-0.5, 0.5, n) for n in _SHAPE)
    heights += _TILT[0] * x[:, None] + _TILT[1] * y
    counts = np.where(lost, _MISSING, np.rint(1e9 * heights))
    return np.ascontiguousarray(counts.T.astype("<i2"))


if __name__ == "__main__":
    np.save(Path(__file__).with_name("scan.npy"), make_scan())
