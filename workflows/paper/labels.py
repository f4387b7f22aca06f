"""Names of curves beside their ends, in place of a legend."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
from matplotlib.axes import Axes

_APART = 1.25  # least distance of two names, in heights of a letter


def label_ends(axes: Axes, fontsize: float = 9.0) -> None:
    """Write the names of curves at their right ends, beside the axes, instead of a legend."""
    handles_and_labels: Any = zip(*axes.get_legend_handles_labels(), strict=True)
    figure: Any = axes.get_figure(root=True)
    figure.draw_without_rendering()  # places the axes
    ends = []
    for handle, name in handles_and_labels:
        curve = getattr(handle, "lines", [handle])[0]
        heights = np.asarray(curve.get_ydata(), float)
        ends.append((float(heights[np.isfinite(heights)][-1]), name, curve.get_color()))
    lowest = -math.inf
    for height, name, colour in sorted(ends):
        at = 72 / figure.dpi * axes.transData.transform((0.0, height))[1]  # [pt]
        lowest = max(at, lowest + _APART * fontsize)
        axes.annotate(
            name, (1.0, height), (6, lowest - at), xycoords=("axes fraction", "data"),
            textcoords="offset points", va="center", fontsize=fontsize, color=colour,
            annotation_clip=False,
        )  # fmt: skip
