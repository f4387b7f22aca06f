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

from .recomputed import Recomputation, texts
from .study import Study

_POINTS = ((200.0, 3.5), (400.0, 2.25))  # N, m/s: near the boundary of `first_try`
_SURFACES, _PINS = 8, 2  # surfaces of a window, and one pin for so many of them
_RATES = ("1.2e-6 mm^3/(N m)", "1.2e-7 mm^3/(N m)")
_RELIEF = {"pin.relief.depth": "2 um", "pin.relief.length": "0.3 mm"}
_ENDS: Mapping[str, Mapping[str, Any]] = {
    "sharp": {},
    "relieved": _RELIEF,
}
_END = 0.456e-3  # length of an end [m]: that of the window of `first_try`
_STEP = 0.1  # of ln(velocity), for the exponent of the rise
_ALLOWED = 0.1  # relative change of a velocity that is no difference, as in report.agree


def ends(study: Study) -> Recomputation:
    """Report on critical velocities of the whole pin and of its ends, by wear rate and relief."""
    seeds = study.seeds(_SURFACES)
    pins = seeds[: math.ceil(len(seeds) / _PINS)]
    names, changes, window_errors = list[tuple[str, ...]](), list[list[list[float]]](), []
    cases = [(*point, rate) for point in _POINTS for rate in _RATES]
    for load, velocity, rate in study.stages(cases, lambda case: f"{case[0]:g} N, {case[2]}"):
        rise, exponent, error = _window(study, seeds, load, velocity, rate)
        window_errors.append(error)
        for name, relief in _ENDS.items():
            pin = study.scene("whole_pin", {"wear.specific_wear_rate": rate, **relief})
            ratios = np.array([_rises(pin, seed, load, velocity) for seed in pins]) / rise
            names.append((f"{load:g} N", rate.replace("^3", "³"), name))
            changes.append((ratios ** (-1 / exponent) - 1).T.tolist())
    return _report(names, changes, max(window_errors), len(pins), len(seeds))


def _window(
    study: Study, seeds: Sequence[int], load: float, velocity: float, rate: str
) -> tuple[float, float, float]:
    """Rise [K] of the window that repeats, its exponent, and the standard error of its velocity.

    The rise is a mean over surfaces. The exponent is d ln(rise)/d ln(velocity).
    """
    window = study.scene("first_try", {"without": ["tests"], "wear.specific_wear_rate": rate})
    logs, faster = (
        np.log([_rises(window, seed, load, v)[0] for seed in seeds])
        for v in (velocity, velocity * math.exp(_STEP))
    )
    exponent = float(np.mean(faster - logs)) / _STEP
    scatter = float(logs.std(ddof=1)) if len(seeds) > 1 else math.nan
    return math.exp(float(logs.mean())), exponent, scatter / math.sqrt(len(seeds)) / exponent


def _report(
    names: Sequence[tuple[str, ...]],
    changes: Sequence[Sequence[Sequence[float]]],
    window_error: float,
    pin_count: int,
    surface_count: int,
) -> Recomputation:
    """Report on relative changes of critical velocities (case, part of the pin, surface)."""
    velocities = np.array(changes)
    means = velocities.mean(axis=-1)
    worn = np.array([name[1] == names[0][1] for name in names])
    return Recomputation.from_values(
        "ends",
        {
            "side": 1e3 * _END,
            "pins": pin_count,
            "relief": [*_RELIEF.values()],
            "surfaces": surface_count,
            "window_error": window_error,
            "worn_whole": means[worn, 0],
            "worn_end": means[worn, 1],
            "hardly_worn_end": means[~worn, 1],
        },
        verdicts={"window": bool(np.abs(means[worn, 0]).max() < _ALLOWED)},
        table=texts(
            ("load", "wear rate", "ends", "whole pin", f"last {1e3 * _END:.2f} mm"),
            [(*name, *map(_percent, parts)) for name, parts in zip(names, changes, strict=True)],
        ),
        data={"case": names, "change_of_critical_velocity": changes},
        figure=_draw(names, velocities),
    )


def _percent(changes: Sequence[float]) -> str:
    """Mean of relative changes in percent, with their standard deviation if there are several."""
    deviation = f" ± {100 * np.std(changes, ddof=1):.1f}" if len(changes) > 1 else ""
    return f"{100 * np.mean(changes):+.1f}{deviation} %".replace("-", "−")


def _rises(sweep: Sweep, seed: int, load: float, velocity: float) -> tuple[float, float]:
    """Rises at friction 1 [K] that govern: of the whole contact, and of both its ends along y."""
    surface = sweep.take_surface(seed)
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
