"""Figures of studies: computing time against error, and a scan beside its random surface.

`pipeline.plot` finds the figure of a study by its attribute ``drawn_by``.
"""

from __future__ import annotations

from pathlib import Path

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.gridspec import SubplotSpec

from pipeline.figures import style
from pipeline.figures.style import BLUE, VERMILION
from pipeline.quantities import display_sides, in_unit
from pipeline.run.trade import Trade
from pipeline.surface.statistics import SurfaceStatistics
from tribo.types import Array

_STACKING_WIDTH = 6.0  # width of a figure below which its panels are stacked [in]


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
    """Draw heights, spectra and numbers of a scan and of its random surface.

    The spectrum along an axis is the mean over all lines along it, each with a Hann window. Its
    integral over the spatial frequency, of both signs, is Sq².
    """
    is_stacked = style.width_or(_STACKING_WIDTH) < _STACKING_WIDTH
    figure = style.Picture((4.6, 10.0) if is_stacked else (11.0, 5.2))
    if is_stacked:
        grid = figure.add_gridspec(3, 1, height_ratios=(4, 4, 2))
    else:
        grid = figure.add_gridspec(2, 2, height_ratios=(4, 1), width_ratios=(2, 1))
    _draw_maps(figure, grid[0], statistics)
    _draw_spectra(figure.add_subplot(grid[1]), statistics)
    _write_numbers(figure.add_subplot(grid[-1, :]), statistics, is_stacked)
    sides = display_sides(
        count * side for count, side in zip(statistics.shape, statistics.pixel_size, strict=True)
    )
    style.write_title(figure, style.as_text(f"{Path(statistics.file).name}: {sides}"))
    style.legend_below(figure, 4, caption=statistics.words_on_fit)
    return figure


def _draw_maps(figure: Figure, subplot: SubplotSpec, statistics: SurfaceStatistics) -> None:
    """Draw the heights of scan and random surface, in one scale of colours."""
    max_height = in_unit(3 * statistics.roughness.sq, "µm")
    x, y = (
        in_unit(count * side, "µm")
        for count, side in zip(statistics.shape, statistics.pixel_size, strict=True)
    )
    grid = subplot.subgridspec(2, 1) if x > 2 * y else subplot.subgridspec(1, 2)
    panels = [figure.add_subplot(grid[k]) for k in range(2)]
    surfaces = {"scan": statistics.heights, "random surface": statistics.fitted_heights}
    for axes, (name, heights) in zip(panels, surfaces.items(), strict=True):
        # More than 800 pixels along a side cannot be seen.
        every_nth = tuple(slice(None, None, -(-count // 800)) for count in heights.shape)
        image = axes.imshow(
            in_unit(heights[every_nth].T, "µm"), cmap="cividis", vmin=-max_height, vmax=max_height,
            extent=(0, x, 0, y), origin="lower", interpolation="nearest",
        )  # fmt: skip
        axes.grid(visible=False)
        axes.set(title=name, xlabel="x, along sliding [µm]", ylabel="y [µm]")
        axes.label_outer()
    figure.colorbar(image, ax=panels, label="height [µm]", extend="both", shrink=0.8)


def _draw_spectra(axes: Axes, statistics: SurfaceStatistics) -> None:
    surfaces = (
        ("scan", statistics.heights, "-"),
        ("random surface", statistics.fitted_heights, "--"),
    )
    for name, heights, line in surfaces:
        for axis, colour in enumerate((BLUE, VERMILION)):
            frequency, density = _spectrum(heights, statistics.pixel_size[axis], axis)
            axes.plot(
                in_unit(1 / frequency, "µm"), 1e18 * density, line, color=colour,
                label=f"{name} along {'xy'[axis]}",
            )  # fmt: skip
    axes.set(xscale="log", xlabel="wavelength [µm]")
    axes.set_title("power spectral density [µm³]")
    style.plain_numbers(axes)
    axes.set(yscale="log")  # spans too many decades for plain numbers


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


def _write_numbers(axes: Axes, statistics: SurfaceStatistics, is_stacked: bool) -> None:
    """Write the numbers of scan and random surface as a table."""
    axes.axis("off")
    columns, scan, random = zip(*(row for row in statistics.rows() if row[1]), strict=True)
    if is_stacked:
        table = axes.table(
            [*map(list, zip(scan, random, strict=True))], rowLabels=columns,
            colLabels=["scan", "random surface"], loc="center",
        )  # fmt: skip
    else:
        table = axes.table(
            [scan, random], rowLabels=["scan", "random surface"], colLabels=columns, loc="center"
        )
    for cell in table.get_celld().values():
        cell.set(edgecolor="#E4E4E4", linewidth=style.THIN)
