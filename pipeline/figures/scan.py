"""A scan beside the random surface that fits it best: heights, spectra along x and y, numbers."""

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

_SPAN = 3.0  # heights shown on each side of the mean, over Sq
_BAR = 0.04  # height of the colour bar over that of a map
_MOST = 800  # pixels of a map along a side: more are not seen
_COLUMN = 6.0  # width of a figure below which its panels are stacked [in]


@style.house_style
def draw_surface(found: SurfaceStatistics) -> Figure:
    """Draw heights, spectra and numbers of a scan beside those of its random surface.

    The spectrum along an axis is the mean over all lines along it, each with a Hann window. Its
    integral over the spatial frequency, of both signs, is Sq².
    """
    is_stacked = style.wanted_width(_COLUMN) < _COLUMN
    figure = style.Picture((4.6, 12.0) if is_stacked else (11.0, 5.2))
    grid = figure.add_gridspec(*((4, 1) if is_stacked else (2, 3)), **(
        {"height_ratios": (4, 4, 4, 2)} if is_stacked else {"height_ratios": (4, 1)}
    ))  # fmt: skip
    places = [grid[k, 0] if is_stacked else grid[0, k] for k in range(3)]
    _draw_maps(figure, places[:2], found)
    _draw_spectra(figure.add_subplot(places[2]), found)
    _write_numbers(figure.add_subplot(grid[-1, :]), found, is_stacked)
    sides = display_sides(n * side for n, side in zip(found.shape, found.pixel_size, strict=True))
    style.write_title(figure, style.as_text(f"{Path(found.file).name}: {sides}"))
    style.legend_below(figure, 4, caption=found.words_on_fit)
    return figure


def _draw_maps(figure: Figure, places: list[SubplotSpec], found: SurfaceStatistics) -> None:
    """Draw the heights of scan and random surface, in one scale of colours."""
    limit = shown_in(_SPAN * found.roughness.sq, "µm")
    ends = [shown_in(n * d, "µm") for n, d in zip(found.shape, found.pixel_size, strict=True)]
    for place, heights, name in zip(
        places, (found.heights, found.fitted_heights), ("scan", "random surface"), strict=True
    ):
        axes = figure.add_subplot(place)
        thin = tuple(slice(None, None, -(-n // _MOST)) for n in heights.shape)
        image = axes.imshow(
            shown_in(heights[thin].T, "µm"), cmap="cividis", vmin=-limit, vmax=limit,
            extent=(0, ends[0], 0, ends[1]), origin="lower", interpolation="nearest",
        )  # fmt: skip
        axes.grid(visible=False)
        axes.set(xlabel="x, along sliding [µm]", ylabel="y [µm]")
        bar = axes.inset_axes((0, 1 + _BAR, 1, _BAR))
        label = f"height of the {name} [µm]"
        figure.colorbar(image, cax=bar, label=label, location="top", extend="both")


def _draw_spectra(axes: Axes, found: SurfaceStatistics) -> None:
    surfaces = (("scan", found.heights, "-"), ("random surface", found.fitted_heights, "--"))
    for name, heights, line in surfaces:
        for axis, colour in enumerate((style.BLUE, style.VERMILION)):
            wavelength, density = _spectrum(heights, found.pixel_size[axis], axis)
            axes.plot(
                shown_in(wavelength, "µm"), 1e18 * density, line, color=colour,
                label=f"{name} along {'xy'[axis]}",
            )  # fmt: skip
    axes.set(xscale="log", xlabel="wavelength [µm]")
    axes.set_title("power spectral density [µm³]")
    style.plain_numbers(axes)
    axes.set(yscale="log")  # spans too many decades for plain numbers


def _spectrum(heights: Array, step: float, axis: int) -> tuple[Array, Array]:
    """Wavelengths [m], and the mean power spectral density of lines along an axis [m³]."""
    lines = heights if axis == 1 else heights.T
    window = np.hanning(lines.shape[1] + 1)[:-1]
    power = np.abs(np.fft.rfft((lines - lines.mean()) * window)) ** 2
    density = power.mean(axis=0) * step / np.square(window).sum()
    frequencies = np.fft.rfftfreq(lines.shape[1], step)
    return 1 / frequencies[2:], density[2:]  # the first two are the mean and what it leaks


def _write_numbers(axes: Axes, found: SurfaceStatistics, is_stacked: bool) -> None:
    """Write the numbers of scan and random surface as a table."""
    axes.axis("off")
    named = [row for row in found.rows() if row[1]]
    columns, (scan, random) = (
        [row[0] for row in named],
        zip(*(row[1:] for row in named), strict=True),
    )
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
