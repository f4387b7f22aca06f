"""Figures of studies: computing time against error, sensitivities to inputs."""

from __future__ import annotations

import numpy as np
import xarray as xr
from matplotlib.figure import Figure

from pipeline.answers.input_errors import input_name
from pipeline.answers.sensitivity_answer import value_text
from pipeline.figures import style
from pipeline.figures.style import BLUE, VERMILION
from pipeline.run.trade import Trade


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
def draw_sensitivities(ds: xr.Dataset) -> Figure:
    """Draw the change of the critical velocity for ± 10 % of each input, the strongest on top."""
    ds = ds.isel(input=slice(None, None, -1))
    paths = ds["input"].values.tolist()
    figure, axes = style.canvas((8.0, 1.4 + 0.36 * len(paths)))
    rises, exponent = ds["log_rise_change"].values, ds["velocity_exponent"].item()
    for sign, colour, text in ((1, VERMILION, "+10 %, +10 K"), (-1, BLUE, "−10 %, −10 K")):
        changes = 100 * np.expm1(-sign * rises / exponent)
        axes.barh(range(len(paths)), changes, color=colour, label=text, gid=f"changes {text[0]}")
    axes.set_yticks(range(len(paths)), [f"{input_name(p)}, {value_text(ds, p)}" for p in paths])
    for label, choice in zip(axes.get_yticklabels(), ds["choice"].values, strict=True):
        label.set_fontweight("bold" if choice else "normal")
    axes.axvline(0, color="black", lw=style.THIN)
    axes.set_xlabel("change of the critical velocity [%]")
    point = f"{ds['load'].item():.4g} N and {ds['velocity'].item():.3g} m/s"
    style.write_title(axes, style.as_text(f"{ds.attrs['title']}: inputs at {point}"))
    style.legend_below(figure, caption="Bold: what a designer chooses.")
    return figure
