"""The figure of a trace: friction, load and velocity over time, with stages and rises."""

from __future__ import annotations

from matplotlib.figure import Figure

from pipeline.figures.style import BLUE, GREEN, GREY, VERMILION, Picture, as_text, house_style
from pipeline.laboratory.trace import Trace


@house_style
def draw_trace(trace: Trace, title: str) -> Figure:
    """Draw friction, load and velocity over time, with numbered stages and rises of friction.

    Parameters
    ----------
    trace : Trace
        Record of friction over time.
    title : str
        Title, such as the name of the file.
    """
    figure = Picture(figsize=(7.2, 5.0))
    friction, commands = figure.subplots(2, sharex=True, height_ratios=(2, 1))
    figure.suptitle(as_text(title))
    friction.plot(trace.time, trace.friction, color=BLUE, linewidth=0.6)
    friction.set_ylabel("friction")
    friction.set_ylim(bottom=0)
    speeds = commands.twinx()
    for axes, values, label, colour in (
        (commands, trace.load, "load [N]", GREEN),
        (speeds, trace.velocity, "velocity [m/s]", GREY),
    ):
        if values is not None:
            axes.plot(trace.time, values, color=colour, linewidth=0.8)
        axes.set_ylabel(label, color=colour)
        axes.set_ylim(bottom=0)
        axes.grid(visible=False)
    commands.set_xlabel("time [s]")
    where = friction.get_xaxis_transform()
    for number, stage in enumerate(trace.stages, 1):
        begin, end = trace.time[stage.rows.start], trace.time[stage.rows.stop - 1]
        for axes in (friction, commands):
            axes.axvspan(begin, end, color=GREY, alpha=0.06 + 0.06 * (number % 2), linewidth=0)
        friction.text((begin + end) / 2, 1.01, str(number), transform=where, ha="center")
    for rise in trace.rises:
        at = trace.time[rise.row]
        friction.plot([at, at], [rise.low, rise.high], color=VERMILION, marker="o", markersize=4)
        friction.annotate(
            f"{at:.4g} s", (at, rise.high), textcoords="offset points", xytext=(-6, -4), ha="right",
            va="top", color=VERMILION,
        )  # fmt: skip
    return figure
