"""A scan and the random surface that fits it best: heights, spectra along x and y, numbers."""

from __future__ import annotations

from pathlib import Path

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.gridspec import SubplotSpec

from pipeline.figures import style
from pipeline.quantities import display_sides, shown_in
from pipeline.surface.statistics import SurfaceStatistics
from tribo.types import Array

_HEIGHT_RANGE = 3.0  # heights shown on each side of the mean, over Sq
_MAX_PIXELS = 800  # most pixels along a side of a map; more cannot be seen
_MAX_ASPECT = 2.0  # length over width of a scan above which the maps are stacked
_STACKING_WIDTH = 6.0  # width of a figure below which its panels are stacked [in]
_BINS = 30  # of the spectrum, in which frequencies are equally wide on the logarithmic axis


@style.house_style
def draw_surface(statistics: SurfaceStatistics) -> Figure:
    """Draw heights, spectra and numbers of a scan and of its random surface.

    The spectrum along an axis is the mean over all lines along it, each with a Hann window. Its
    integral over the spatial frequency, of both signs, is Sq².
    """
    is_stacked = style.wanted_width(_STACKING_WIDTH) < _STACKING_WIDTH
    figure = style.Picture((4.6, 10.0) if is_stacked else (11.0, 5.2))
    if is_stacked:
        grid = figure.add_gridspec(3, 1, height_ratios=(4, 4, 2))
    else:
        grid = figure.add_gridspec(2, 2, height_ratios=(4, 1), width_ratios=(2, 1))
    _draw_maps(figure, grid[0], statistics)
    _draw_spectra(figure.add_subplot(grid[1]), statistics)
    _write_numbers(figure.add_subplot(grid[-1, :]), statistics, is_stacked)
    sides = display_sides(
        n * side for n, side in zip(statistics.shape, statistics.pixel_size, strict=True)
    )
    style.write_title(figure, style.as_text(f"{Path(statistics.file).name}: {sides}"))
    style.legend_below(figure, 4, caption=statistics.words_on_fit)
    return figure


def _draw_maps(figure: Figure, subplot: SubplotSpec, statistics: SurfaceStatistics) -> None:
    """Draw the heights of scan and random surface, in one scale of colours."""
    limit = shown_in(_HEIGHT_RANGE * statistics.roughness.sq, "µm")
    x, y = (
        shown_in(n * d, "µm") for n, d in zip(statistics.shape, statistics.pixel_size, strict=True)
    )
    rows, columns = (2, 1) if x > _MAX_ASPECT * y else (1, 2)
    inner = subplot.subgridspec(rows, columns)
    panels = [figure.add_subplot(inner[k]) for k in range(2)]
    surfaces = {"scan": statistics.heights, "random surface": statistics.fitted_heights}
    for axes, (name, heights) in zip(panels, surfaces.items(), strict=True):
        every_nth = tuple(slice(None, None, -(-n // _MAX_PIXELS)) for n in heights.shape)
        image = axes.imshow(
            shown_in(heights[every_nth].T, "µm"), cmap="cividis", vmin=-limit, vmax=limit,
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
        for axis, colour in enumerate((style.BLUE, style.VERMILION)):
            frequency, density = _spectrum(heights, statistics.pixel_size[axis], axis)
            axes.plot(
                shown_in(1 / frequency, "µm"), 1e18 * density, line, color=colour,
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
    begins = np.unique(np.geomspace(2, len(density), _BINS).astype(int))[:-1]
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
