"""The names of the regions of a diagram, written where there is room for them."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np
import xarray as xr
from matplotlib.axes import Axes
from scipy.ndimage import distance_transform_edt

from pipeline.figures.style import BLUE, TINTS, VERMILION
from tribo import Criterion
from tribo.types import Array, Mask

_LABEL_SIZE = (0.42, 0.07)  # of the axes: about what the names of the regions take
MILD, SEVERE = "mild wear (I and II)", "severe adhesive wear (III* and III)"
_LEAST_ROOM = 0.4  # of a label's size, around its middle


def name_regions(
    axes: Axes,
    plane: xr.DataArray,
    limit: float,
    loads: Array,
    measured: Sequence[Mapping[str, Any]],
) -> None:
    """Name mild and severe wear where each has most room, between two rows of points."""
    scale = np.log if axes.get_xscale() == "log" else np.asarray
    (left, right), (bottom, top) = scale(axes.get_xlim()), scale(axes.get_ylim())

    def across(velocity: Any) -> Any:
        return (scale(velocity) - left) / (right - left)

    def up(load: Any) -> Any:
        return (scale(load) - bottom) / (top - bottom)

    x, y = across(plane["velocity"].values), up(plane["load"].values)
    rows = up(np.convolve(loads, [0.5, 0.5], "valid"))
    taken = [(across(point["velocity"]), up(point["normal_load"])) for point in measured]
    severe, mild = (of(plane.values, limit) for of in (Criterion.is_severe, Criterion.is_mild))
    for inside, name, colour, tint in (
        (mild, MILD, BLUE, TINTS["mild"]),
        (severe, SEVERE, VERMILION, TINTS["severe"]),
    ):
        place = _roomiest(inside, x, y, rows, taken)
        if place is not None:
            axes.text(
                *place, name, transform=axes.transAxes, ha="center", va="center", fontsize=10.5,
                fontweight="bold", color=colour, zorder=5,
                bbox={"fc": tint, "ec": "none", "pad": 0.5},
            )  # fmt: skip


def _roomiest(
    inside: Mask, x: Array, y: Array, rows: Array, taken: Sequence[tuple[float, float]]
) -> tuple[float, float] | None:
    """Roomiest place of a label in a row, counted in sizes of labels; None if none fits."""
    inside = inside.copy()
    for point in taken:
        if x[0] <= point[0] <= x[-1] and y[0] <= point[1] <= y[-1]:
            inside[np.abs(y - point[1]).argmin(), np.abs(x - point[0]).argmin()] = False
    width, height = _LABEL_SIZE
    steps = (np.ptp(y) / (len(y) - 1) / height, np.ptp(x) / (len(x) - 1) / width)
    # Padded, since the edges of the diagram count as edges of the region.
    room = distance_transform_edt(np.pad(inside, 1), sampling=steps)[1:-1, 1:-1]
    free = np.abs(y - rows[:, None]).argmin(axis=1)
    if room[free].max() < _LEAST_ROOM:
        return None
    row, column = np.unravel_index(int(room[free].argmax()), room[free].shape)
    return float(x[column]), float(y[free[row]])
