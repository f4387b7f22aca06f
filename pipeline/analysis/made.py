"""Points of a dataset that xarray has made from the values of several computed points.

`interp` and `coarsen` put points at other loads and velocities. `rolling` leaves them where they
are, but there the mean pressure times the contact area is no longer the load, as the mean of a
product is not the product of the means.
"""

from __future__ import annotations

import numpy as np

from pipeline.analysis.dataset import Layout
from pipeline.analysis.results import Results
from pipeline.store.schema import PLANE
from tribo.types import Mask

_SAME = 1e-6  # relative difference above that of numbers in single precision, 2e-7
_BALANCE = ("mean_pressure", "contact_fraction", "normal_load")


def made_points(data: Results) -> Mask:
    """Mask of the points of one scene that were not computed, by surface, load and velocity."""
    made = np.zeros(data.columns["status"].shape, bool)
    if data.kind is Layout.PLANE:
        for name, values in zip(PLANE, (data.loads, data.velocities), strict=True):
            own = np.array(data.sweep.loads if name == "load" else data.sweep.velocities)
            near = np.abs(values[:, None] - own) <= _SAME * np.abs(own)
            made |= ~near.any(axis=1)[:, None] if name == "load" else ~near.any(axis=1)
    if data.store is None and all(name in data.variables for name in _BALANCE):
        # The pressure at the end of a computed point carries the load on it.
        pressure, fraction, load = (data.values(name)[..., -1] for name in _BALANCE)
        grid, pin = data.sweep.scene.grid, data.sweep.scene.pin
        carried = pressure * fraction * np.prod(grid.size) * pin.patches(grid)
        made |= ~(np.abs(carried - load) <= _SAME * load)
    return made & data.done


def note_on_made(data: Results) -> str:
    """How many points of one scene were not computed, in words; empty if all of them were."""
    count, total = int(made_points(data).sum()), int(data.done.sum())
    if not count:
        return ""
    return f"{count} of {total} points were made by xarray from the values of computed ones"
