"""Ends of the pin: critical velocities of the whole pin, beside those of a window that repeats."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np
from matplotlib.figure import Figure

from pipeline import Sweep
from pipeline.figures.style import BLACK, BLUE, VERMILION, house_style
from tribo import simulate
from tribo.simulation.temperature import refined_scene
from tribo.types import Array

from .recomputed import Report, cells, texts
from .study import Study

_POINTS = ((200.0, 3.5), (400.0, 2.25))  # N, m/s: near the boundary of `first_try`
_SURFACES, _PINS = 8, 4  # surfaces of a window, and one pin for so many of them
_RATES = ("1.2e-6 mm^3/(N m)", "1.2e-7 mm^3/(N m)")
_RELIEF = {"depth": "2 um", "length": "0.3 mm"}
_ENDS: Mapping[str, Mapping[str, Any]] = {
    "sharp": {},
    "relieved": {"pin.relief": _RELIEF},
}
_END = 0.456e-3  # length of an end [m]: that of the window of `first_try`
_STEP = 0.1  # of ln(velocity), for the exponent of the rise
_ALLOWED = 0.1  # relative change of a velocity that is no difference, as in report.agree


def ends(study: Study) -> Report:
    """Report on critical velocities of the whole pin and of its ends, by wear rate and relief."""
    seeds = study.seeds(_SURFACES)
    pins = seeds[: math.ceil(len(seeds) / _PINS)]
    names, changes = list[tuple[str, ...]](), list[list[list[float]]]()
    rows = [(point, rate) for point in _POINTS for rate in _RATES]
    for (load, velocity), rate in study.stages(rows, lambda row: f"{row[0][0]:g} N, {row[1]}"):
        entries = {"without": ["tests"], "wear.specific_wear_rate": rate}
        window = study.scene("first_try", entries)
        rise, faster = (
            math.exp(np.mean([math.log(_rises(window, seed, load, v)[0]) for seed in seeds]))
            for v in (velocity, velocity * math.exp(_STEP))
        )
        exponent = math.log(faster / rise) / _STEP
        for name, relief in _ENDS.items():
            pin = study.scene("whole_pin", {"wear.specific_wear_rate": rate, **relief})
            ratios = np.array([_rises(pin, seed, load, velocity) for seed in pins]) / rise
            names.append((f"{load:g} N", rate.replace("^3", "³"), name))
            changes.append((ratios ** (-1 / exponent) - 1).T.tolist())
    velocities = np.array(changes)  # (case, part, surface)
    worn = [name[1] == names[0][1] for name in names]
    return Report.from_values(
        "ends",
        {
            "side": 1e3 * _END,
            "pins": len(pins),
            **_RELIEF,
            "surfaces": len(seeds),
            "worn_whole": velocities[worn, 0].mean(axis=-1),
            "worn_end": velocities[worn, 1].mean(axis=-1),
            "hardly_worn_end": velocities[np.invert(worn), 1].mean(axis=-1),
        },
        verdicts={"window": bool(np.abs(velocities[worn, 0].mean(axis=-1)).max() < _ALLOWED)},
        table=texts(
            ("load", "wear rate", "ends", "whole pin", f"last {1e3 * _END:.2f} mm of both ends"),
            [(*name, *cells(row, "+.0f%")) for name, row in zip(names, changes, strict=True)],
        ),
        data={"case": names, "change_of_critical_velocity": changes},
        figure=_draw(names, velocities),
    )


def _rises(sweep: Sweep, seed: int, load: float, velocity: float) -> tuple[float, float]:
    """Rises at friction 1 [K] that govern: of the whole contact, and of both its ends along y."""
    surface = sweep._take_surface(seed)
    *_, state = simulate(surface.scene, load, velocity)
    assert state.heat
    y = np.abs(refined_scene(surface.scene, state).grid.coordinates(1))
    at_end = y > y.max() - _END
    level = 1 - surface.conditions.critical_area_fraction
    rise, touches = state.heat.rise, state.pressure > 0
    return (
        float(np.quantile(rise[touches], level)),
        float(np.quantile(rise[:, at_end][touches[:, at_end]], level)),
    )


@house_style
def _draw(names: Sequence[tuple[str, ...]], changes: Array) -> Figure:
    figure = Figure(figsize=(7.4, 4.0))
    axes = figure.subplots()
    for part, (label, colour) in enumerate((("whole pin", BLUE), ("both ends", VERMILION))):
        for row, velocities in enumerate(changes[::-1, part]):
            x, y = 100 * velocities, np.full(len(velocities), row + 0.15 * (0.5 - part))
            axes.plot(x, y, "o", color=colour, ms=6, label=label if row == 0 else None)
    axes.axvline(0, color=BLACK, lw=0.8)
    axes.set_yticks(range(len(names)), [", ".join(name) for name in names[::-1]])
    axes.set(xlabel="critical velocity, change from a window that repeats [%]")
    axes.set_title("whole pins; dots: surfaces", loc="left")
    axes.legend()
    return figure
