"""Inverse problems: what the paper's measurements say about what was not measured."""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from dataclasses import replace
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from pipeline.analysis.inference import critical_temperatures
from pipeline.figures.style import BLACK, BLUE, GREEN, GREY, VERMILION, celsius, in_house_style
from pipeline.sweep.model import Sweep
from tribo import InputError, Ramp, rig_heating, specific_wear_rate
from workflows.paper.ensemble import Values
from workflows.paper.publication import (
    RIG_HEATING,
    ROOM_CELSIUS,
    SPECIFIC_WEAR_RATE,
    TABLE_4,
    TABLE_6,
    Row4,
    Row6,
)
from workflows.paper.report import Report, Table, line, means, statistics
from workflows.paper.study import Study, end_of

_SURFACES = 8
_DURATIONS = (6.0, 7.0, 8.0, 9.0, 10.0)  # s, of the whole test: not published
_CHOSEN = 2  # of the durations: the one shown
_FRICTIONS = (0.1, 0.2, 0.4)  # before the friction of the rig jumps, and after it
_UNIT = 1e15  # of 1e-6 mm³/(N m) in a m²/N


def inverse(study: Study) -> Report:
    """Critical temperature, specific wear rate and heating of the rig."""
    white = study.scene("irg_transition")
    oils_a = tuple(study.scene(name) for name in ("oil_a", "oil_a_hot"))
    critical = {"white oil": _critical(study, (white,)), "oil A": _critical(study, oils_a)}
    study.tell("specific wear rate")
    rates = _wear_rates(white, TABLE_4, _DURATIONS)
    rates_of_a = [
        rate
        for scene in oils_a
        for row in _wear_rates(scene, _rows_of(scene), (_DURATIONS[_CHOSEN],)).values()
        for rate in row
    ]
    widening = _widening(white)
    study.tell("friction heating of the rig")
    heating = {friction: rig_heating(friction) for friction in _FRICTIONS}
    durations = {load: _duration_for(row, SPECIFIC_WEAR_RATE) for load, row in rates.items()}
    printed = float(celsius(white.conditions.known_critical_temperature()))
    shown = [row[_CHOSEN] for row in rates.values()]
    values = {
        "printed_critical": printed,
        **_of_temperatures(critical),
        "rates": [_UNIT * rate for rate in shown],
        "durations": list(durations.values()),
        "widening": widening,
        "lower_rates": -((1 + widening) ** -3 - 1),
        **_of_oil_a(rates_of_a, oils_a),
        "printed_heating": RIG_HEATING,
        "heating": ", ".join(f"{value:.1f} K at friction {mu:g}" for mu, value in heating.items()),
        "most_friction": _FRICTIONS[0] * RIG_HEATING / heating[_FRICTIONS[0]],
    }
    pairs = values["cold_rates"], values["hot_rates"]
    return Report.of(
        "inverse",
        values,
        verdicts={
            "white_oil": abs(values["mean"] - printed) < 5,
            "oil_a": values["oil_a_spread"] < 15,
            "wear_rate": 0.7 < statistics(shown)[0] / SPECIFIC_WEAR_RATE < 1.4,
            "wear_rates_of_oil_a": all(max(pair) < 1.4 * min(pair) for pair in pairs)
            and max(values["pair_means"]) < _UNIT * min(SPECIFIC_WEAR_RATE, *shown),
            "heating": heating[_FRICTIONS[1]] < RIG_HEATING * 1.01,
        },
        table=Table(
            ("", "printed", "computed"),
            (
                ("critical temperature [°C], from each transition",),
                *_temperatures("white oil", (white,), critical, f"{printed:g}"),
                *_temperatures("oil A", oils_a, critical, ""),
                *_rates(rates, rates_of_a),
                ("duration of the test that gives the printed wear rate [s]",),
                *(line(f"  {load:g} N", ["", time], ".1f") for load, time in durations.items()),
                ("friction heating of the critical-temperature rig [K]",),
                *(
                    line(f"  at friction {friction:g}", [f"up to {RIG_HEATING:g}", value], ".1f")
                    for friction, value in heating.items()
                ),
            ),
        ),
        data={
            "critical_celsius": critical,
            "wear_rate": {f"{load:g}": row for load, row in rates.items()},
            "wear_rate_of_oil_a": rates_of_a,
            "durations": list(_DURATIONS),
            "duration_for_printed_rate": {f"{load:g}": time for load, time in durations.items()},
            "widening_by_roughness": widening,
            "rig_heating": {f"{mu:g}": value for mu, value in heating.items()},
        },
        figure=_draw(critical, printed, rates),
    )


def _critical(study: Study, scenes: Sequence[Sweep]) -> Values:
    """Critical temperature [°C] by transition and surface."""
    temperatures: Values = []
    for scene in scenes:
        on_surfaces = replace(scene, realizations=tuple(study.seeds(_SURFACES)))
        result = critical_temperatures(on_surfaces, study.tell)
        temperatures += [[float(celsius(value)) for value in row] for row in result.temperatures]
    return temperatures


def _rows_of(scene: Sweep) -> list[Row6]:
    """The columns of Table 6 at the bulk temperature of a scene."""
    bulk = float(celsius(scene.conditions.bulk_temperature))
    return [row for row in TABLE_6 if math.isclose(row.bulk_celsius, bulk)]


def _held(sweep: Sweep, row: Row4 | Row6, duration: float, steps: int) -> Sweep:
    """The scene with its load held to the end of a test of some duration [s]."""
    if not isinstance(sweep.loading, Ramp):
        raise InputError("the wear rate of a width needs a scene with a ramp")
    hold = duration - row.normal_load / sweep.loading.rate
    return replace(sweep, loading=replace(sweep.loading, hold=hold, hold_steps=steps))


def _wear_rates(
    sweep: Sweep, rows: Sequence[Row4 | Row6], durations: Sequence[float]
) -> dict[float, list[float]]:
    """Wear rate [m²/N] that gives each measured width, by load and duration of the test."""
    fidelity = replace(sweep.fidelity, averaging="mean", temperature_interval=0)
    smooth = replace(sweep, roughness=None, fidelity=fidelity)

    def rate(row: Row4 | Row6, duration: float) -> float:
        scene = _held(smooth, row, duration, steps=50)
        return specific_wear_rate(scene, row.measured_width, row.normal_load, row.velocity).value

    return {row.normal_load: [rate(row, duration) for duration in durations] for row in rows}


def _widening(sweep: Sweep) -> float:
    """Widening of the contact by the roughness after a test, relative."""
    row = TABLE_4[0]
    held = _held(sweep, row, _DURATIONS[len(_DURATIONS) // 2], steps=20)
    rough, smooth = (
        end_of(scene, row.normal_load, row.velocity).contact_width
        for scene in (held, replace(held, roughness=None))
    )
    return rough / smooth - 1


def _duration_for(rates: Sequence[float], wanted: float) -> float:
    """Duration at which the wear rate takes a value, linear in the logarithms."""
    slope, offset = np.polyfit(np.log(_DURATIONS), np.log(rates), 1)
    return math.exp((math.log(wanted) - offset) / slope)


def _of_temperatures(critical: dict[str, Values]) -> dict[str, Any]:
    """Critical temperatures of both oils, over surfaces and from single transitions [°C]."""
    by_surface = zip(*critical["white oil"], strict=True)
    on_surfaces = [float(np.mean(column)) for column in by_surface]
    mean, spread = statistics(on_surfaces)
    of_transition = means(critical["white oil"])
    oil_a_mean, oil_a_spread = statistics(means(critical["oil A"]))
    return {
        "surfaces": len(on_surfaces),
        "mean": mean,
        "spread": spread,
        "of_transition": of_transition,
        "farthest": max(abs(value - mean) for value in of_transition),
        "of_oil_a": means(critical["oil A"]),
        "oil_a_mean": oil_a_mean,
        "oil_a_spread": oil_a_spread,
        "printed_spread": statistics([row.max_celsius for row in TABLE_6])[1],
    }


def _of_oil_a(rates: list[float], scenes: Sequence[Sweep]) -> dict[str, Any]:
    """Specific wear rates of oil A [1e-6 mm³/(N m)], from its widths and in its scenes."""
    pairs = list(zip(TABLE_6, rates, strict=True))
    cold = [_UNIT * rate for row, rate in pairs if row.bulk_celsius == ROOM_CELSIUS]
    hot = [_UNIT * rate for row, rate in pairs if row.bulk_celsius != ROOM_CELSIUS]
    pair_means = [math.sqrt(math.prod(pair)) for pair in (cold, hot)]
    in_scenes = [_UNIT * scene.wear.specific_wear_rate for scene in scenes if scene.wear]
    ratios = (rate / mean for rate, mean in zip(in_scenes, pair_means, strict=True))
    return {
        "printed_rate": _UNIT * SPECIFIC_WEAR_RATE,
        "duration": _DURATIONS[_CHOSEN],
        "room": ROOM_CELSIUS,
        "hot_bulk": TABLE_6[-1].bulk_celsius,
        "cold_rates": cold,
        "hot_rates": hot,
        "pair_means": pair_means,
        "scene_rates": [f"{rate:.2f}" for rate in in_scenes],
        "scenes_off": max(abs(ratio - 1) for ratio in ratios),
    }


def _temperatures(
    name: str, scenes: Sequence[Sweep], critical: dict[str, Values], printed: str
) -> Iterator[tuple[str, ...]]:
    """Rows with the critical temperature from each transition of an oil."""
    entries = [(entry, scene.conditions) for scene in scenes for entry in scene.measured]
    for (entry, conditions), column in zip(entries, critical[name], strict=True):
        bulk = celsius(conditions.bulk_temperature)
        label = f"  {name}, {entry.normal_load:g} N, {entry.velocity:g} m/s, {bulk:g} °C"
        yield line(label, [printed, column], ".1f")


def _rates(
    rates: dict[float, list[float]], rates_of_a: Sequence[float]
) -> Iterator[tuple[str, ...]]:
    """Rows with the specific wear rates of both oils."""
    yield (f"specific wear rate [1e-6 mm³/(N m)], if the test lasts {_DURATIONS[_CHOSEN]:g} s",)
    for load, row in rates.items():
        printed = f"{_UNIT * SPECIFIC_WEAR_RATE:g}"
        yield line(f"  white oil, {load:g} N", [printed, _UNIT * row[_CHOSEN]], ".2f")
    for of_a, rate in zip(TABLE_6, rates_of_a, strict=True):
        label = f"  oil A, {of_a.normal_load:g} N, {of_a.bulk_celsius:g} °C"
        yield line(label, ["", _UNIT * rate], ".2f")


@in_house_style
def _draw(critical: dict[str, Values], printed: float, rates: dict[float, list[float]]) -> Figure:
    figure = Figure(figsize=(9.6, 4.4))
    left, right = figure.subplots(1, 2)
    _draw_temperatures(left, critical, printed)
    _draw_rates(right, rates)
    return figure


def _draw_temperatures(axes: Axes, critical: dict[str, Values], printed: float) -> None:
    start = 0
    for (name, columns), colour in zip(critical.items(), (BLUE, VERMILION), strict=True):
        mean, spread = np.array([statistics(column) for column in columns]).T
        places = np.arange(start, start + len(columns))
        axes.errorbar(
            places, mean, spread, color=colour, marker="o", ls="none", capsize=3, label=name
        )
        axes.hlines(mean.mean(), places[0] - 0.3, places[-1] + 0.3, color=colour, lw=0.9)
        start += len(columns)
    label = f"white oil on the rig, {printed:g} °C"
    axes.axhline(printed, color=GREY, ls=":", lw=1.4, label=label)
    ticks = [f"{row.normal_load:g} N" for row in TABLE_4]
    ticks += [f"{row.normal_load:g} N\n{row.bulk_celsius:g} °C" for row in TABLE_6]
    axes.set_xticks(range(start), ticks[:start])
    axes.tick_params(axis="x", labelsize=8)
    bottom, top = axes.get_ylim()
    axes.set_ylim(bottom, top + 0.25 * (top - bottom))
    axes.set_ylabel("critical temperature [°C]")
    axes.set_title("from each measured transition", loc="left")
    axes.legend(loc="upper left")


def _draw_rates(axes: Axes, rates: dict[float, list[float]]) -> None:
    colours = (BLACK, BLUE, VERMILION, GREEN)
    for (load, row), colour in zip(rates.items(), colours, strict=True):
        axes.plot(_DURATIONS, _UNIT * np.array(row), "o-", color=colour, label=f"{load:g} N")
    axes.axhline(_UNIT * SPECIFIC_WEAR_RATE, color=GREY, ls=":", lw=1.4, label="printed")
    axes.set_xlabel("duration of the test [s]")
    axes.set_ylabel("specific wear rate [10$^{-6}$ mm³/(N m)]")
    axes.set_ylim(0, None)
    axes.set_title("from each measured contact width", loc="left")
    axes.legend(loc="lower left", ncols=2)
