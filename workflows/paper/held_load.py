"""Fig. 5: the highest contact temperature through a ramp and a hold, with and without wear."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np
from matplotlib.figure import Figure

from pipeline.answers.scene_wording import heating_words
from pipeline.figures.style import BLACK, BLUE, GREY, VERMILION, house_style
from tribo import InputError, Ramp
from tribo.types import Array

from .labels import label_ends
from .recomputed import Recomputation, line, texts
from .study import Study
from .transitions import HIGHEST, Wear, history, worn

_LOOKS: dict[str, tuple[Wear, str, str]] = {
    "no wear": ("unworn", BLACK, "--"),
    "swept wear": ("swept", BLUE, "-"),
    "local wear": ("local", VERMILION, "-"),
}
_Curves = Mapping[str, tuple[Array, Array]]
"""Times [s] and highest temperatures [°C], by the kind of wear."""


def fig5(study: Study) -> Recomputation:
    """Report on the highest contact temperature against time at 600 N, 1.25 m/s, with a hold."""
    sweep = study.scene("fig5")
    if not isinstance(sweep.scene.loading, Ramp):
        raise InputError(f"the scene {sweep.name} must have a ramp, `rate` under [loading]")
    load, velocity = sweep.loads[-1], sweep.velocities[-1]
    curves = {
        name: history(worn(sweep, _LOOKS[name][0]), load, velocity, HIGHEST)[:2]
        for name in study.stages(_LOOKS)
    }
    full = load / sweep.scene.loading.rate
    times = (full / 2, full, float(curves["no wear"][0][-1]))
    marks = {
        name: [float(np.interp(time, *curve)) for time in times] for name, curve in curves.items()
    }
    hold = {name: at_end - at_full for name, (_, at_full, at_end) in marks.items()}
    pace = {name: 2 * (at_full - at_half) / full for name, (at_half, at_full, _) in marks.items()}
    cooler = {name: marks["no wear"][1] - at_full for name, (_, at_full, _) in marks.items()}
    values = {
        "load": load,
        "velocity": velocity,
        "heating": heating_words(sweep.conditions),
        "cooler": cooler,
        "hold": hold,
        "pace": pace,
    }
    return Recomputation.from_values(
        "fig5",
        values,
        verdicts={
            "level": min(cooler["swept wear"], cooler["local wear"]) > 0,
            "hold": max(hold["swept wear"], hold["local wear"]) < 0,
            "pace": max(pace["swept wear"], pace["local wear"]) < pace["no wear"],
        },
        table=texts(
            ("highest temperature [°C]", *(f"{time:g} s" for time in times), "in the hold"),
            [line(name, [*marks[name], f"{hold[name]:+.1f}"], ".1f") for name in curves],
        ),
        data={
            name: {"time": time, "max_celsius": celsius} for name, (time, celsius) in curves.items()
        },
        figure=_draw(
            curves, full, f"{load:g} N, {velocity:g} m/s, {heating_words(sweep.conditions)}"
        ),
    )


@house_style
def _draw(curves: _Curves, full: float, title: str) -> Figure:
    figure = Figure(figsize=(7.4, 4.6))
    axes = figure.subplots()
    for name, (time, temperature) in curves.items():
        _, colour, style = _LOOKS[name]
        axes.plot(time, temperature, color=colour, ls=style, label=name)
    axes.axvline(full, color=GREY, lw=0.9)
    bottom, top = axes.get_ylim()
    axes.set_ylim(bottom, top + 0.06 * (top - bottom))
    for side, text in (("right", "ramp "), ("left", " load held")):
        axes.text(full, bottom + 2, text, ha=side, va="bottom", color=GREY)
    end = max(time[-1] for time, _ in curves.values())
    axes.set(xlim=(0, end), xlabel="time [s]", ylabel="highest contact temperature [°C]")
    axes.set_title(title, loc="left")
    label_ends(axes)
    return figure
