"""Fig. 5: the highest contact temperature through a ramp and a hold, with and without wear."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace

import numpy as np
from matplotlib.figure import Figure

from pipeline.figures.style import BLACK, BLUE, GREY, VERMILION, celsius, heating, in_house_style
from pipeline.sweep.criterion import Conditions, contact_temperature
from pipeline.sweep.model import Sweep
from tribo import InputError, Ramp, simulate
from tribo.types import Array
from workflows.paper.report import Finding, Report, Table
from workflows.paper.study import Study

_LOOKS = {
    "no wear": (BLACK, "--"),
    "swept wear": (BLUE, "-"),
    "local wear": (VERMILION, "-"),
}


@dataclass(frozen=True, slots=True)
class _Computed:
    """Highest temperatures through the ramp and the hold, by the kind of wear."""

    load: float  # [N]
    velocity: float  # [m/s]
    conditions: Conditions
    full: float  # time at which the load is reached [s]
    curves: Mapping[str, tuple[Array, Array]]  # times [s] and temperatures [°C]

    @property
    def times(self) -> tuple[float, float, float]:
        """Times of the table: half the load, full load, end of the hold [s]."""
        time, _ = self.curves["no wear"]
        return self.full / 2, self.full, float(time[-1])

    def at_times(self, name: str) -> list[float]:
        """Temperatures at the times of the table [°C]."""
        return [float(np.interp(time, *self.curves[name])) for time in self.times]

    def change_in_hold(self, name: str) -> float:
        """Change of the temperature while the load is held [K]."""
        _, at_full, at_end = self.at_times(name)
        return at_end - at_full

    def pace(self, name: str) -> float:
        """Pace at which the temperature rises in the second half of the ramp [K/s]."""
        at_half, at_full, _ = self.at_times(name)
        return 2 * (at_full - at_half) / self.full


def fig5(study: Study) -> Report:
    """Highest temperature against time at 600 N and 1.25 m/s."""
    found = _computed(study)
    return Report(
        name="fig5",
        title=f"highest contact temperature at {found.load:g} N, {found.velocity:g} m/s, through "
        "ramp and hold",
        table=_table(found),
        findings=(_on_level(found), _on_hold(found), _on_pace(found)),
        notes=(
            f"{heating(found.conditions)}; one surface, its correlation length our choice.",
            "The paper prints no numbers of the curves; the comparison is with what its text says.",
        ),
        data={
            name: {"time": list(map(float, time)), "max_celsius": list(map(float, value))}
            for name, (time, value) in found.curves.items()
        },
        figure=_draw(found),
    )


def _computed(study: Study) -> _Computed:
    sweep = study.scene_with_history("fig5")
    wear = sweep.wear
    if wear is None or not isinstance(sweep.loading, Ramp):
        raise InputError(
            f"the scene {sweep.name} must have a [wear], and a ramp with `rate` under [loading]"
        )
    load, velocity = sweep.loads[-1], sweep.velocities[-1]
    variants = {
        "no wear": replace(sweep, wear=None),
        "swept wear": replace(sweep, wear=replace(wear, pattern="swept")),
        "local wear": replace(sweep, wear=replace(wear, pattern="local")),
    }
    curves = {name: _highest(variants[name], load, velocity) for name in study.each(variants)}
    return _Computed(load, velocity, sweep.conditions, load / sweep.loading.rate, curves)


def _highest(scene: Sweep, load: float, velocity: float) -> tuple[Array, Array]:
    """Times [s] and highest temperatures [°C]."""
    conditions = scene.conditions
    found = [(0.0, contact_temperature(0.0, conditions))]
    for state in simulate(scene, load, velocity):
        if state.heat is not None:
            found.append((state.time, contact_temperature(state.heat.max_rise, conditions)))
    time, temperature = np.array(found).T
    return time, celsius(temperature)


def _table(found: _Computed) -> Table:
    return Table(
        ("highest temperature [°C]", *(f"{time:g} s" for time in found.times), "in the hold"),
        tuple(
            (
                name,
                *(f"{value:.1f}" for value in found.at_times(name)),
                f"{found.change_in_hold(name):+.1f}",
            )
            for name in found.curves
        ),
    )


def _on_level(found: _Computed) -> Finding:
    _, unworn, _ = found.at_times("no wear")
    swept, local = (unworn - found.at_times(f"{name} wear")[1] for name in ("swept", "local"))
    return Finding(
        "with wear the temperature is lower",
        f"by {swept:.0f} K if swept, {local:.0f} K if local, at full load",
        min(swept, local) > 0,
    )


def _on_hold(found: _Computed) -> Finding:
    unworn, swept, local = map(found.change_in_hold, ("no wear", "swept wear", "local wear"))
    return Finding(
        "with wear it decreases while the load is constant",
        f"{swept:+.1f} K if swept, {local:+.1f} K if local; {unworn:+.1f} K without wear",
        max(swept, local) < 0,
        "Wear goes on widening the contact, which spreads the same heat.",
    )


def _on_pace(found: _Computed) -> Finding:
    unworn, swept, local = map(found.pace, ("no wear", "swept wear", "local wear"))
    return Finding(
        "with wear it rises more gradually",
        f"in the second half of the ramp by {swept:.0f} K/s if swept, "
        f"{local:.0f} K/s if local, {unworn:.0f} K/s without wear",
        max(swept, local) < unworn,
    )


@in_house_style
def _draw(found: _Computed) -> Figure:
    figure = Figure(figsize=(7.4, 4.6))
    axes = figure.subplots()
    for name, (time, temperature) in found.curves.items():
        colour, style = _LOOKS[name]
        axes.plot(time, temperature, color=colour, ls=style, label=name)
    axes.axvline(found.full, color=GREY, lw=0.9)
    bottom, top = axes.get_ylim()
    axes.set_ylim(bottom, top + 0.06 * (top - bottom))
    for side, text in (("right", "ramp "), ("left", " load held")):
        axes.text(found.full, bottom + 2, text, ha=side, va="bottom", color=GREY)
    axes.set_xlim(0, None)
    axes.set_xlabel("time [s]")
    axes.set_ylabel("highest contact temperature [°C]")
    axes.legend(loc="lower right", title=heating(found.conditions))
    return figure
