"""Figures of studies: computing time against error, sensitivities to inputs.

`pipeline.plot` finds the figure of a study by its attribute ``drawn_by``.
"""

from __future__ import annotations

from matplotlib.figure import Figure

from pipeline.answers.input_errors import input_name
from pipeline.figures import style
from pipeline.figures.style import BLUE, VERMILION
from pipeline.run.sensitivity import Sensitivity
from pipeline.run.trade import Trade
from pipeline.sweep.case import TEMPERATURES


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
def draw_sensitivity(sensitivity: Sensitivity) -> Figure:
    """Draw the change of the critical velocity for +10 % of each input, the strongest on top."""
    ds = sensitivity.dataset.isel(input=slice(None, None, -1))
    figure, axes = style.canvas((8.0, 0.9 + 0.42 * ds.sizes["input"]))
    changes = 100 * ds["velocity_change"].values
    steps = ["+10 K" if path in TEMPERATURES else "+10 %" for path in ds["input"].values]
    names = [f"{input_name(p)}, {s}" for p, s in zip(ds["input"].values, steps, strict=True)]
    colours = [VERMILION if change < 0 else BLUE for change in changes]
    axes.barh(range(len(names)), changes, color=colours, gid="changes")
    axes.set_yticks(range(len(names)), names)
    axes.axvline(0, color="black", lw=style.THIN)
    axes.set_xlabel("change of the critical velocity [%]")
    style.write_title(axes, style.as_text(f"Inputs: {sensitivity.title}"))
    return figure
