"""Figures of studies: computing time against error, sensitivities to inputs."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np
import xarray as xr
from matplotlib.figure import Figure

from pipeline.answers.input_errors import input_name
from pipeline.answers.sensitivity_answer import deviation_text, value_text
from pipeline.figures import style
from pipeline.figures.style import BLUE, VERMILION
from pipeline.run.trade import Trade

_WIDTH = 8.0  # usual width of figures [in]
_NARROW = 5.0  # width up to which labels have two lines [in]


@style.house_style
def draw_trade(trade: Trade) -> Figure:
    """Draw the whole error of the boundary over processor time, of runs and of whole planes."""
    figure, axes = style.canvas((_WIDTH, 5.6))
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
def draw_sensitivities(ds: xr.Dataset) -> Figure:
    """Draw the change of the critical velocity by each input, the strongest on top.

    An input changes by ± its declared standard deviation or, without one, by ± 10 % or 10 K.
    """
    ds = ds.isel(input=slice(None, None, -1))
    is_narrow = style.width_or(_WIDTH) < _NARROW
    row_height, separator = (0.48, "\n") if is_narrow else (0.36, ", ")
    figure, axes = style.canvas((_WIDTH, 1.4 + row_height * ds.sizes["input"]))
    exponent, deviations = ds["velocity_exponent"].item(), ds["uncertainty"].values
    by_deviations = ds["sensitivity"].values * deviations
    rises = np.where(np.isnan(deviations), ds["log_rise_change"].values, by_deviations)
    is_declared = not np.isnan(deviations).all()
    texts = ("higher", "lower") if is_declared else ("+10 %, +10 K", "−10 %, −10 K")
    for sign, colour, text in zip((1, -1), (VERMILION, BLUE), texts, strict=True):
        changes = 100 * np.expm1(-sign * rises / exponent)
        axes.barh(range(len(rises)), changes, color=colour, label=text)
    axes.set_yticks(range(len(rises)), [*_input_labels(ds, separator)])
    for label, choice in zip(axes.get_yticklabels(), ds["choice"].values, strict=True):
        label.set(fontweight="bold" if choice else "normal", linespacing=1.0)
    axes.margins(y=0.02)
    axes.axvline(0, color="black", lw=style.THIN)
    axes.set_xlabel("change of the critical velocity [%]")
    point = f"{ds['load'].item():.4g} N and {ds['velocity'].item():.3g} m/s"
    style.write_title(axes, style.as_text(f"{ds.attrs['title']}: inputs at {point}"))
    caption = "Bold: what a designer chooses."
    if is_declared:
        caption = f"By one standard deviation (±), or by 10 % or 10 K.\n{caption}"
    style.legend_below(figure, caption=caption)
    return figure


def _input_labels(ds: xr.Dataset, separator: str) -> Iterator[str]:
    """Yield names, values and declared deviations; a single material is not named."""
    paths = ds["input"].values.tolist()
    names = {path.rpartition(".")[0] for path in paths if path.startswith("materials.")}
    of_material = f" of {min(names).removeprefix('materials.')}" if len(names) == 1 else ""
    for path, deviation in zip(paths, ds["uncertainty"].values.tolist(), strict=True):
        name, value = input_name(path), value_text(ds, path)
        if path.startswith("materials."):
            name = name.removesuffix(of_material)
        text = deviation_text(path, deviation)
        yield f"{name}{separator}{value} ± {text}" if text else f"{name}{separator}{value}"
