"""Figure of a design: the risk over an entry, or the line that parts two of them."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np
from matplotlib.figure import Figure

from pipeline.figures.style import (
    BLUE,
    GREY,
    VERMILION,
    Picture,
    as_text,
    as_title,
    entry_label,
    in_house_style,
)
from pipeline.sweep.unknown import Unknown
from pipeline.uncertain.design import Limit
from pipeline.uncertain.ensemble import Ensemble

_LEAST = 1e-5  # probability that is drawn


@in_house_style
def draw_design(limits: Sequence[tuple[Mapping[str, float], Limit]], ensemble: Ensemble) -> Figure:
    """Draw the probability over an entry with its limit, or limits over another entry.

    Parameters
    ----------
    limits : sequence of (mapping, Limit)
        Values of another entry by its path, if there is one, and the limit there.
    ensemble : Ensemble
        Samples of the sweep.

    Examples
    --------
    >>> import pipeline
    >>> from dataclasses import replace
    >>> ensemble = pipeline.Ensemble.of(pipeline.open_sweep("results/unknown.zarr"))
    >>> critical = Unknown("temperature.critical", "uniform", (398.15, 438.15), "K")
    >>> ensemble = replace(ensemble, unknown=(ensemble.unknown[0], critical))
    >>> goal = pipeline.Goal((pipeline.Place(400.0, 2.2),), risk=0.05)
    >>> limit = pipeline.design(ensemble, goal, "temperature.critical")
    >>> figure = pipeline.draw_design([({}, limit)], ensemble)
    """
    figure = Picture(figsize=(7.2, 4.8))
    axes = figure.add_subplot()
    limit = limits[0][1]
    goal, shown = limit.goal, limit.entry.shown
    if not limits[0][0]:
        values = shown.of(np.array(limit.values))
        axes.semilogy(values, np.maximum(limit.probabilities, _LEAST), "o-", ms=4, color=BLUE)
        axes.axhline(goal.risk, color=GREY, lw=1.0)
        if limit.value is not None and limit.interval is not None:
            axes.axvline(shown.of(limit.value), color=VERMILION)
            axes.axvspan(*(shown.of(end) for end in limit.interval), color=VERMILION, alpha=0.15)
        axes.set_xlabel(_label(limit.entry))
        less = f"less than {goal.margin:g} K below the critical" if goal.margin else "severe wear"
        axes.set_ylabel(f"probability of {less}")
    else:
        (path,) = limits[0][0]
        (other,) = (one for one in ensemble.unknown if one.path == path)
        found = [(at[path], one.value) for at, one in limits if one.value is not None]
        x, y = np.array(found).reshape(-1, 2).T
        axes.plot(other.shown.of(x), shown.of(y), "o-", color=VERMILION)
        axes.set(xlim=[other.shown.of(end) for end in other.parameters], xlabel=_label(other))
        axes.set(ylim=[shown.of(end) for end in limit.entry.parameters])
        side = next((one.side for _, one in limits if one.value is not None), "no value")
        axes.set_ylabel(f"{_label(limit.entry)}, {side}")
    place = limit.binding
    axes.set_title(
        f"{as_title(ensemble.title, 70)}\n{place.load:g} N at {place.velocity:g} m/s, "
        f"{100 * goal.risk:g} % at most"
    )
    return figure


def _label(entry: Unknown) -> str:
    unit = "" if entry.shown.name == "1" else f" [{as_text(entry.shown.name)}]"
    return f"{entry_label(entry.path)}{unit}"
