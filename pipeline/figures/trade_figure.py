"""The figure of a study: processor time against the error of the boundary."""

from __future__ import annotations

from matplotlib.figure import Figure

from pipeline.figures import style
from pipeline.figures.style import BLUE, VERMILION
from pipeline.run.trade import Trade


@style.house_style
def draw_trade(trade: Trade) -> Figure:
    """Draw the whole error of the boundary over processor time, of runs and of whole planes."""
    figure, axes = style.canvas((8.0, 5.6))
    axes.set(xscale="log", yscale="log")
    for measurements, label, marker, colour in (
        (trade.runs, "runs with a goal, measured", "D", VERMILION),
        (trade.planes, "whole plane, time from some points", "s", BLUE),
    ):
        x, y = (
            [measured.seconds for measured in measurements],
            [measured.error for measured in measurements],
        )
        axes.plot(x, y, marker=marker, color=colour, lw=style.THIN, label=label, gid=label)
        for measured in measurements:
            name = str(measured.preset)
            if measured.has_steps:
                name = f"{measured.preset}, all steps"
            if measured.accuracy is not None:
                name = f"{100 * measured.accuracy:g} %: {measured.points} points"
            offset = (8, -14) if measured.has_steps else (8, 4)  # planes have nearly the same error
            axes.annotate(
                name, (measured.seconds, measured.error), offset, textcoords="offset points",
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
