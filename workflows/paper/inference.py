"""Inverse problems: quantities that were not measured, from those that were."""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from typing import Any

import numpy as np
from matplotlib.figure import Figure

from pipeline import Sweep
from pipeline.figures.style import BLUE, GREY, VERMILION, house_style
from pipeline.quantities import in_unit
from pipeline.sweep.case import known_critical_temperature
from tribo import InputError, Ramp, Wear
from tribo.inverse import specific_wear_rate
from tribo.types import Array

from .labels import label_ends
from .publication import RIG_HEATING, ROOM_CELSIUS, SPECIFIC_WEAR_RATE, TABLE_4, TABLE_6
from .recomputed import Recomputation, agree, line, mean, spread, texts
from .rig import rig_heating
from .study import Study
from .transitions import Tested, celsius_of, end_of, ensemble, label_of, oil_a, white_oil

_DURATIONS = (6.0, 7.0, 8.0, 9.0, 10.0)  # duration of the whole test [s], which is not published
_CHOSEN = 2  # index of the duration that is shown
_FRICTIONS = (0.1, 0.2, 0.4)  # before and after the friction of the rig jumps
_UNIT = 1e15  # 1e-6 mm³/(N m) in one m²/N


def inverse(study: Study) -> Recomputation:
    """Report on critical temperature, wear rate and rig heating inferred from measurements."""
    tests = {"white oil": white_oil(study), "oil A": oil_a(study)}
    critical = {oil: _critical(study, transitions) for oil, transitions in tests.items()}
    study.tell("specific wear rate")
    rates = {
        float(row.normal_load): [_wear_rate(scene, row, duration) for duration in _DURATIONS]
        for scene, row in tests["white oil"]
    }
    rates_of_a = [_wear_rate(scene, row, _DURATIONS[_CHOSEN]) for scene, row in tests["oil A"]]
    white = tests["white oil"][0][0]
    widening = _widening(white)
    study.tell("friction heating of the rig")
    heating = {friction: rig_heating(friction) for friction in _FRICTIONS}
    durations = {load: _duration_for_printed(row) for load, row in rates.items()}
    printed = float(in_unit(known_critical_temperature(white.conditions), "°C"))
    chosen = np.array([row[_CHOSEN] for row in rates.values()])
    values = {
        "printed_critical": printed,
        **_of_temperatures(critical),
        "rates": _UNIT * chosen,
        "durations": list(durations.values()),
        "lower_rates": -((1 + widening) ** -3 - 1),
        **_of_oil_a(rates_of_a, tests["oil A"]),
        "printed_heating": RIG_HEATING,
        "heating": ", ".join(f"{value:.1f} K at friction {mu:g}" for mu, value in heating.items()),
        "most_friction": _FRICTIONS[0] * RIG_HEATING / heating[_FRICTIONS[0]],
    }
    of_a = values["cold_rates"], values["hot_rates"]
    return Recomputation.from_values(
        "inverse",
        values,
        verdicts={
            "white_oil": agree(critical["white oil"], 4 * [printed], ROOM_CELSIUS),
            "oil_a": values["oil_a_spread"] < 15,
            "wear_rate": agree(np.reshape(chosen, (-1, 1)), SPECIFIC_WEAR_RATE),
            "wear_rates_of_oil_a": all(max(pair) < 1.4 * min(pair) for pair in of_a)
            and max(values["pair_means"]) < _UNIT * min(SPECIFIC_WEAR_RATE, *chosen),
            "heating": heating[_FRICTIONS[1]] < RIG_HEATING * 1.01,
        },
        table=texts(
            ("", "printed", "computed"),
            (
                ("critical temperature [°C], from each transition",),
                *_temperatures(tests, critical, printed),
                *_rates(chosen, rates_of_a),
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


def _critical(study: Study, transitions: Sequence[Tested]) -> Array:
    """Critical temperature [°C] from each transition on each surface, (transition, surface)."""
    ends = ensemble(study, ("swept",), transitions)["swept"]
    return celsius_of(ends, transitions[0][0].conditions.critical_area_fraction)


def _ramp_and_hold(sweep: Sweep, row: Any, duration: float) -> Sweep:
    """Scene whose load is held after its ramp, so that the test lasts `duration` [s]."""
    if not isinstance(sweep.scene.loading, Ramp):
        raise InputError("the wear rate of a width needs a scene with a ramp")
    hold = duration - row.normal_load / sweep.scene.loading.rate
    return sweep.changed("loading.hold", f"{float(hold)!r} s")


def _wear_rate(sweep: Sweep, row: Any, duration: float) -> float:
    """Specific wear rate [m²/N] by which a contact wears to its measured width in a test."""
    scene = _ramp_and_hold(sweep.changed("disk.roughness", None), row, duration)
    return specific_wear_rate(scene.scene, row.measured_width, row.normal_load, row.velocity).value


def _widening(sweep: Sweep) -> float:
    """Relative widening of the contact by roughness at the end of a test."""
    row = TABLE_4[0]
    held_sweep = _ramp_and_hold(sweep, row, _DURATIONS[len(_DURATIONS) // 2])
    rough, smooth = (
        end_of(scene, row) for scene in (held_sweep, held_sweep.changed("disk.roughness", None))
    )
    return float(rough["contact_width"] / smooth["contact_width"] - 1)


def _duration_for_printed(rates: Sequence[float]) -> float:
    """Duration of a test [s] for which the inferred wear rate is the printed one."""
    slope, offset = np.polyfit(np.log(_DURATIONS), np.log(rates), 1)
    return math.exp((math.log(SPECIFIC_WEAR_RATE) - offset) / slope)


def _of_temperatures(critical: dict[str, Array]) -> dict[str, Any]:
    """Statistics, by name, of critical temperatures [°C]: over surfaces, and over transitions."""
    on_surfaces, of_oil_a = critical["white oil"].mean(axis=0), mean(critical["oil A"])
    of_transition = mean(critical["white oil"])
    return {
        "surfaces": len(on_surfaces),
        "mean": mean(on_surfaces),
        "spread": spread(on_surfaces),
        "of_transition": of_transition,
        "of_oil_a": of_oil_a,
        "oil_a_mean": mean(of_oil_a),
        "oil_a_spread": spread(of_oil_a),
    }


def _of_oil_a(rates: Sequence[float], transitions: Sequence[Tested]) -> dict[str, Any]:
    """Wear rates of oil A [1e-6 mm³/(N m)] by name: from contact widths, and as scenes state."""
    cold, hot = _UNIT * np.reshape(rates, (2, 2))
    pair_means = np.array([math.sqrt(np.prod(pair)) for pair in (cold, hot)])
    wears = [scene.scene.wear for scene, _ in transitions[::2]]
    in_scenes = np.array(
        [_UNIT * wear.specific_wear_rate for wear in wears if isinstance(wear, Wear)]
    )
    return {
        "printed_rate": _UNIT * SPECIFIC_WEAR_RATE,
        "duration": _DURATIONS[_CHOSEN],
        "room": ROOM_CELSIUS,
        "hot_bulk": TABLE_6[-1].bulk_celsius,
        "cold_rates": cold,
        "hot_rates": hot,
        "pair_means": pair_means,
        "scene_rates": [f"{rate:.2f}" for rate in in_scenes],
    }


def _temperatures(
    tests: dict[str, list[Tested]], critical: dict[str, Array], printed: float
) -> Iterator[tuple[str, ...]]:
    """Yield table rows with the critical temperature from each transition."""
    for oil, transitions in tests.items():
        of_rig = f"{printed:g}" if oil == "white oil" else ""
        for (scene, row), values in zip(transitions, critical[oil], strict=True):
            bulk = in_unit(scene.conditions.bulk_temperature, "°C")
            yield line(f"  {oil}, {label_of(row)}, {bulk:g} °C", [of_rig, values], ".1f")


def _rates(rates: Array, rates_of_a: Sequence[float]) -> Iterator[tuple[str, ...]]:
    """Yield table rows with the specific wear rates of both oils."""
    printed = f"{_UNIT * SPECIFIC_WEAR_RATE:g}"
    yield (f"specific wear rate [1e-6 mm³/(N m)], if the test lasts {_DURATIONS[_CHOSEN]:g} s",)
    for white, rate in zip(TABLE_4, rates, strict=True):
        yield line(f"  white oil, {white.normal_load:g} N", [printed, _UNIT * rate], ".2f")
    for of_a, rate in zip(TABLE_6, rates_of_a, strict=True):
        label = f"  oil A, {of_a.normal_load:g} N, {of_a.bulk_celsius:g} °C"
        yield line(label, ["", _UNIT * rate], ".2f")


@house_style
def _draw(critical: dict[str, Array], printed: float, rates: dict[float, list[float]]) -> Figure:
    figure = Figure(figsize=(9.6, 4.4))
    left, right = figure.subplots(1, 2)
    start = 0
    for (name, values), colour in zip(critical.items(), (BLUE, VERMILION), strict=True):
        abscissas = np.arange(start, start + len(values))
        left.errorbar(
            abscissas, mean(values), spread(values),
            color=colour, marker="o", ls="none", capsize=3,
        )  # fmt: skip
        left.hlines(values.mean(), abscissas[0] - 0.3, abscissas[-1] + 0.3, color=colour, lw=0.9)
        left.annotate(
            f"{name}, mean {values.mean():.0f} °C", (abscissas.mean(), values.max()), (0, 9),
            textcoords="offset points", ha="center", color=colour,
        )  # fmt: skip
        start += len(values)
    left.axhline(printed, color=GREY, ls=":", lw=1.4)
    left.annotate(
        f"white oil on the rig: {printed:g} °C", (start - 0.5, printed), (0, 3),
        textcoords="offset points", ha="right", va="bottom", color=GREY,
    )  # fmt: skip
    ticks = [f"{row.normal_load:g} N\n{ROOM_CELSIUS:g} °C" for row in TABLE_4]
    ticks += [f"{row.normal_load:g} N\n{row.bulk_celsius:g} °C" for row in TABLE_6]
    left.set_xticks(range(start), ticks[:start], fontsize=8)
    bottom, top = left.get_ylim()
    left.set(ylim=(bottom, top + 0.1 * (top - bottom)), ylabel="critical temperature [°C]")
    left.set_title("from each measured transition", loc="left")
    for (load, row), marker in zip(rates.items(), "os^D", strict=True):
        rate = _UNIT * np.array(row)
        right.plot(_DURATIONS, rate, marker=marker, color=BLUE, label=f"{load:g} N")
    right.axhline(_UNIT * SPECIFIC_WEAR_RATE, color=GREY, ls=":", lw=1.4, label="printed")
    right.set(xlabel="duration of the test [s]", ylim=(0, None), xlim=(None, _DURATIONS[-1]))
    right.set_ylabel("specific wear rate [10$^{-6}$ mm³/(N m)]")
    right.set_title("white oil, from each measured contact width", loc="left")
    label_ends(right)
    return figure
