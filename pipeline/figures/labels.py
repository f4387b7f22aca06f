"""Names beside the points of a figure, where there is room for them."""

from __future__ import annotations

import itertools
import math
from collections.abc import Sequence
from typing import Any, NamedTuple

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.patheffects import withStroke

__all__ = ["Label", "name_points"]

_DISTANCES = (9.0, 15.0, 24.0, 34.0, 46.0, 60.0, 76.0, 94.0, 115.0)  # of a name from its point [pt]
_DIRECTIONS = (
    45,
    135,
    -45,
    -135,
    15,
    165,
    -15,
    -165,
    30,
    150,
    60,
    120,
    75,
    105,
    -75,
    -105,
)  # [degree]
_LEADS = 12.0  # [pt] from which a line leads to the name
_MARKER = 5.0  # half the size of what stands for a point [pt]
_MARGIN = 1.5  # about each name [pt]


class Label(NamedTuple):
    """A name for the point at x and y, and how to write it."""

    text: str
    x: float
    y: float
    look: dict[str, Any]


class _Box(NamedTuple):
    left: float
    bottom: float
    right: float
    top: float

    def meets(self, other: _Box) -> bool:
        apart = self.right <= other.left or other.right <= self.left
        return not (apart or self.top <= other.bottom or other.top <= self.bottom)

    def lies_in(self, other: _Box) -> bool:
        inside = self.left >= other.left and self.right <= other.right
        return inside and self.bottom >= other.bottom and self.top <= other.top


def name_points(
    figure: Figure,
    axes: Axes,
    labels: Sequence[Label],
    line: Sequence[tuple[float, float]] = (),
) -> tuple[str, ...]:
    """Write names beside their points such that none covers another, a point, or a line.

    Those that come first have the first choice. To be called when the axes have their limits.

    Parameters
    ----------
    figure : Figure
    axes : Axes
        Of the figure.
    labels : sequence of Label
    line : sequence of (float, float)
        Corners of a line that is drawn through some of the points.

    Returns
    -------
    tuple of str
        Names for which there was no room.
    """
    figure.draw_without_rendering()
    point = figure.dpi / 72
    window = axes.get_window_extent()
    room = _Box(window.x0, window.y0, window.x1, window.y1)
    places = [tuple(axes.transData.transform((label.x, label.y))) for label in labels]
    size = _MARKER * point
    taken = [_Box(x - size, y - size, x + size, y + size) for x, y in places]
    corners = [tuple(axes.transData.transform(corner)) for corner in line]
    drawn = [
        box
        for ends in itertools.pairwise(corners)
        for box in _along(*ends, spacing=_MARKER * point)
    ]
    left_out = []
    for number, (label, (x, y)) in enumerate(zip(labels, places, strict=True)):
        note = axes.annotate(
            label.text,
            (label.x, label.y),
            xytext=(0, 0),
            textcoords="offset points",
            va="center",
            path_effects=[withStroke(linewidth=2.5, foreground="white")],
            zorder=5,
            **label.look,
        )
        extent = note.get_window_extent()
        width, height = extent.width + 2 * _MARGIN * point, extent.height + 2 * _MARGIN * point
        others = [*taken[:number], *taken[number + 1 :]]
        in_the_way = [box for box in others if not box.meets(taken[number])]
        for distance, angle in ((d, a) for d in _DISTANCES for a in _DIRECTIONS):
            dx, dy = (distance * f(math.radians(angle)) for f in (math.cos, math.sin))
            start = x + dx * point - (width if dx < 0 else 0.0)
            box = _Box(
                start, y + dy * point - height / 2, start + width, y + dy * point + height / 2
            )
            lead = _along((x, y), (x + dx * point, y + dy * point), point)
            if (
                box.lies_in(room)
                and not any(map(box.meets, [*others, *drawn]))
                and not any(step.meets(other) for step in lead for other in in_the_way)
            ):
                taken.append(box)
                note.set(x=dx, y=dy, ha="right" if dx < 0 else "left")
                if distance > _LEADS:
                    drawn += lead
                    axes.annotate(
                        "",
                        (label.x, label.y),
                        xytext=(dx, dy),
                        textcoords="offset points",
                        arrowprops={"arrowstyle": "-", "lw": 0.5, "color": "#AAAAAA"},
                        zorder=2.5,
                    )
                break
        else:
            note.remove()
            left_out.append(label.text)
    return tuple(left_out)


def _along(start: tuple[float, ...], end: tuple[float, ...], spacing: float) -> list[_Box]:
    """Small boxes along a line, so far apart."""
    steps = np.linspace(start, end, 2 + int(math.dist(start, end) / spacing))
    return [_Box(x - 0.5, y - 0.5, x + 0.5, y + 0.5) for x, y in steps.tolist()]
