"""Figures of studies: computing time against error, and a scan beside its random surface.

`pipeline.plot` finds the figure of a study by its attribute ``drawn_by``.
"""

from __future__ import annotations

from pathlib import Path

import numpy as np
from matplotlib.figure import Figure

from pipeline.figures import style
from pipeline.figures.style import BLUE, VERMILION
from pipeline.quantities import display_sides, in_unit
from pipeline.run.trade import Trade
from pipeline.surface.statistics import SurfaceStatistics
from tribo.types import Array


@style.house_style
def draw_trade(trade: Trade) -> Figure:
    """Draw the whole error of the boundary over processor time, of runs and of whole planes."""
    figure, axes = style.canvas((8.0, 5.6))
    axes.set(xscale="log", yscale="log")
    for costs, label, marker, colour in (
        (trade.runs, "runs with a goal, measured", "D", VERMILION),
        (trade.planes, "whole plane, time estimated from some points", "s", BLUE),
    ):
        times, errors = [cost.seconds for cost in costs], [cost.error for cost in costs]
        axes.plot(times, errors, marker=marker, color=colour, lw=style.THIN, label=label, gid=label)
        for cost in costs:
            name, offset = str(cost.preset), (8, 4)
            if cost.accuracy is not None:
                name, offset = f"{100 * cost.accuracy:g} %: {cost.points} points", (12, -12)
            axes.annotate(
                name, (cost.seconds, cost.error), offset, textcoords="offset points",
                path_effects=style.HALO,
            )  # fmt: skip
    axes.margins(0.15)
    style.plain_numbers(axes)
    axes.set_xlabel("processor time [s]")
    axes.set_ylabel("error of the boundary velocity (95 %)")
    axes.yaxis.set_major_formatter(lambda value, _: f"{100 * value:g} %")
    style.write_title(axes, style.as_text(f"Speed against accuracy: {trade.title}"))
    style.legend_below(figure)
    return figure


@style.house_style
def draw_surface(statistics: SurfaceStatistics) -> Figure:
    """Draw the heights and the spectra of a scan and of its random surface.

    The spectrum along an axis is the mean over all lines along it, each with a Hann window. Its
    integral over the spatial frequency, of both signs, is Sq².
    """
    figure = style.Picture((11.0, 4.4))
    *maps, axes = figure.subplots(1, 3)
    max_height = in_unit(3 * statistics.roughness.sq, "µm")
    x, y = (
        in_unit(count * side, "µm")
        for count, side in zip(statistics.shape, statistics.pixel_size, strict=True)
    )
    surfaces = {
        "scan": (statistics.heights, "-"),
        "random surface": (statistics.fitted_heights, "--"),
    }
    for panel, (name, (heights, line)) in zip(maps, surfaces.items(), strict=True):
        # More than 800 pixels along a side cannot be seen.
        every_nth = tuple(slice(None, None, -(-count // 800)) for count in heights.shape)
        image = panel.imshow(
            in_unit(heights[every_nth].T, "µm"), cmap="cividis", vmin=-max_height, vmax=max_height,
            extent=(0, x, 0, y), origin="lower", interpolation="nearest",
        )  # fmt: skip
        panel.grid(visible=False)
        panel.set(title=name, xlabel="x, along sliding [µm]", ylabel="y [µm]")
        for axis, colour in enumerate((BLUE, VERMILION)):
            frequency, density = _spectrum(heights, statistics.pixel_size[axis], axis)
            axes.plot(
                in_unit(1 / frequency, "µm"), 1e18 * density, line, color=colour,
                label=f"{name} along {'xy'[axis]}",
            )  # fmt: skip
    figure.colorbar(image, ax=maps, label="height [µm]", extend="both", location="bottom")
    axes.set(xscale="log", yscale="log", xlabel="wavelength [µm]")
    axes.set_title("power spectral density [µm³]")
    sides = display_sides(
        count * side for count, side in zip(statistics.shape, statistics.pixel_size, strict=True)
    )
    style.write_title(figure, style.as_text(f"{Path(statistics.file).name}: {sides}"))
    style.legend_below(figure, 4, caption=statistics.words_on_fit)
    return figure


def _spectrum(heights: Array, step: float, axis: int) -> tuple[Array, Array]:
    """Frequencies [1/m], and the mean power spectral density of lines along an axis [m³]."""
    lines = heights if axis == 1 else heights.T
    window = np.hanning(lines.shape[1] + 1)[:-1]
    power = np.abs(np.fft.rfft((lines - lines.mean()) * window)) ** 2
    density = power.mean(axis=0) * step / np.square(window).sum()
    # The first two frequencies have the mean and its leakage.
    begins = np.unique(np.geomspace(2, len(density), 30).astype(int))[:-1]
    counts = np.diff([*begins, len(density)])
    frequencies = np.fft.rfftfreq(lines.shape[1], step)
    return np.add.reduceat(frequencies, begins) / counts, np.add.reduceat(density, begins) / counts
