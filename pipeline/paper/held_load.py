"""Fig. 5: the highest contact temperature through a ramp and a hold, with and without wear."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace

import numpy as np
from matplotlib.figure import Figure

from pipeline.figures.style import BLACK, BLUE, GREY, VERMILION, celsius, heating, in_house_style
from pipeline.paper.report import Finding, Report, Table
from pipeline.paper.study import Study
from pipeline.sweep.criterion import Conditions, contact_temperature
from pipeline.sweep.model import Sweep
from tribo import Ramp, simulate
from tribo.types import Array

_LOOKS = {
    "no wear": (BLACK, "--"),
    "swept wear": (BLUE, "-"),
    "local wear": (VERMILION, "-"),
}


def fig5(study: Study) -> Report:
    """Highest temperature against time at 600 N and 1.25 m/s."""
    sweep = study.scene("fig5")
    wear = sweep.wear
    if wear is None or not isinstance(sweep.loading, Ramp):
        raise TypeError("Fig. 5 is about wear, through a ramp and a hold")
    load, velocity = sweep.loads[-1], sweep.velocities[-1]
    full = load / sweep.loading.rate
    if study.preset is not None:  # a preset asks for the temperature at the end only
        interval = max(1, sweep.fidelity.increments // 10)
        sweep = replace(sweep, fidelity=replace(sweep.fidelity, temperature_interval=interval))
    curves = {}
    for name, variant in (
        ("no wear", replace(sweep, wear=None)),
        ("swept wear", replace(sweep, wear=replace(wear, pattern="swept"))),
        ("local wear", replace(sweep, wear=replace(wear, pattern="local"))),
    ):
        study.tell(f"{name}, {load:g} N at {velocity:g} m/s")
        curves[name] = _highest(variant, load, velocity)

    at = {
        name: tuple(float(np.interp(t, *curve)) for t in (full / 2, full, curve[0][-1]))
        for name, curve in curves.items()
    }
    end = float(curves["no wear"][0][-1])
    table = Table(
        ("highest temperature [°C]", f"{full / 2:g} s", f"{full:g} s", f"{end:g} s", "in the hold"),
        tuple(
            (name, *(f"{value:.1f}" for value in values), f"{values[2] - values[1]:+.1f}")
            for name, values in at.items()
        ),
    )
    cooler = [at["no wear"][1] - at[name][1] for name in ("swept wear", "local wear")]
    falling = [at[name][2] - at[name][1] for name in ("swept wear", "local wear")]
    rising = {name: 2 * (values[1] - values[0]) / full for name, values in at.items()}
    findings = (
        Finding(
            "with wear the temperature is lower",
            f"by {cooler[0]:.0f} K if swept, {cooler[1]:.0f} K if local, at full load",
            min(cooler) > 0,
        ),
        Finding(
            "with wear it decreases while the load is constant",
            f"{falling[0]:+.1f} K if swept, {falling[1]:+.1f} K if local; "
            f"{at['no wear'][2] - at['no wear'][1]:+.1f} K without wear",
            max(falling) < 0,
            "Wear goes on widening the contact, which spreads the same heat.",
        ),
        Finding(
            "with wear it rises more gradually",
            f"in the second half of the ramp by {rising['swept wear']:.0f} K/s if swept, "
            f"{rising['local wear']:.0f} K/s if local, {rising['no wear']:.0f} K/s without wear",
            max(rising["swept wear"], rising["local wear"]) < rising["no wear"],
        ),
    )
    return Report(
        name="fig5",
        title=f"highest contact temperature at {load:g} N, {velocity:g} m/s, through ramp and hold",
        table=table,
        findings=findings,
        notes=(
            f"{heating(sweep.conditions)}; one surface, its correlation length our choice.",
            "The curves of the figure are not printed as numbers; compared is what the text says.",
        ),
        data={
            name: {"time": list(map(float, time)), "max_celsius": list(map(float, value))}
            for name, (time, value) in curves.items()
        },
        figure=_draw(curves, full, sweep.conditions),
    )


def _highest(scene: Sweep, load: float, velocity: float) -> tuple[Array, Array]:
    """Times [s] and highest temperatures [°C]."""
    conditions = scene.conditions
    found = [(0.0, contact_temperature(0.0, conditions))]
    for state in simulate(scene, load, velocity):
        if state.heat is not None:
            found.append((state.time, contact_temperature(state.heat.max_rise, conditions)))
    time, temperature = np.array(found).T
    return time, celsius(temperature)


@in_house_style
def _draw(curves: Mapping[str, tuple[Array, Array]], full: float, conditions: Conditions) -> Figure:
    figure = Figure(figsize=(7.4, 4.6))
    axes = figure.subplots()
    for name, (time, temperature) in curves.items():
        colour, style = _LOOKS[name]
        axes.plot(time, temperature, color=colour, ls=style, label=name)
    axes.axvline(full, color=GREY, lw=0.9)
    bottom, top = axes.get_ylim()
    axes.set_ylim(bottom, top + 0.06 * (top - bottom))
    for side, text in (("right", "ramp "), ("left", " load held")):
        axes.text(full, bottom + 2, text, ha=side, va="bottom", color=GREY)
    axes.set_xlim(0, None)
    axes.set_xlabel("time [s]")
    axes.set_ylabel("highest contact temperature [°C]")
    axes.legend(loc="lower right", title=heating(conditions))
    return figure
