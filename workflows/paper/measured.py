"""Inverse problems: what the paper's measurements say about what was not measured."""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace

import numpy as np
from matplotlib.figure import Figure

from pipeline.analysis.inference import critical_temperatures
from pipeline.figures.style import BLACK, BLUE, GREEN, GREY, VERMILION, celsius, in_house_style
from pipeline.sweep.model import Sweep
from tribo import (
    InputError,
    Ramp,
    rig_heating,
    specific_wear_rate,
)
from workflows.paper.printed import (
    RIG_HEATING,
    ROOM_CELSIUS,
    SPECIFIC_WEAR_RATE,
    TABLE_4,
    TABLE_6,
    Row4,
    Row6,
)
from workflows.paper.report import Finding, Report, Table, mean_and_spread, statistics
from workflows.paper.study import Study, end_of

_SURFACES = 8
_DURATIONS = (6.0, 7.0, 8.0, 9.0, 10.0)  # s, of the whole test: not published
_CHOSEN = 2  # of the durations: the one shown
_FRICTIONS = (0.1, 0.2, 0.4)  # before the friction of the rig jumps, and after it


@dataclass(frozen=True, slots=True)
class _Inferred:
    """What each kind of measurement gives."""

    oils: dict[str, tuple[Sweep, ...]]
    critical: dict[str, list[list[float]]]  # by oil, transition and surface [°C]
    rates: dict[float, list[float]]  # by load and duration of the test [m²/N]
    rates_of_a: list[float]  # of oil A, by transition, for the duration shown [m²/N]
    widening: float  # of a worn contact by the roughness, relative
    heating: dict[float, float]  # of the rig, by friction [K]

    @property
    def known(self) -> float:
        """Critical temperature of the white oil as printed [°C]."""
        (white,) = self.oils["white oil"]
        return float(celsius(white.conditions.known_critical_temperature()))

    @property
    def of_surfaces(self) -> list[float]:
        """Critical temperature of the white oil on each surface [°C]."""
        return [float(np.mean(column)) for column in zip(*self.critical["white oil"], strict=True)]

    @property
    def durations(self) -> dict[float, float]:
        """Duration of the test at each load that gives the printed wear rate [s]."""
        return {load: _duration_for(row, SPECIFIC_WEAR_RATE) for load, row in self.rates.items()}


def inverse(study: Study) -> Report:
    """Critical temperature, specific wear rate and heating of the rig."""
    found = _inferred(study)
    return Report(
        name="inverse",
        title="what the measurements say about what was not measured",
        table=Table(("", "printed", "computed"), tuple(_rows(found))),
        findings=(
            *_on_critical(found),
            _on_wear_rate(found),
            _on_rates_of_a(found),
            _on_heating(found),
        ),
        notes=(
            f"Critical temperatures over {len(found.of_surfaces)} surfaces (mean ± spread), by the "
            "temperature exceeded on 10 % of the contact. They rest on the correlation length "
            "of the roughness, our choice (see sensitivity).",
            "The wear rate is found on a smooth disk; with the roughness a contact worn by the "
            f"printed rate is {100 * found.widening:+.0f} % wider, and the rates would be "
            f"{-100 * ((1 + found.widening) ** -3 - 1):.0f} % lower.",
        ),
        data={
            "critical_celsius": found.critical,
            "wear_rate": {f"{load:g}": row for load, row in found.rates.items()},
            "wear_rate_of_oil_a": found.rates_of_a,
            "durations": list(_DURATIONS),
            "duration_for_printed_rate": {f"{load:g}": s for load, s in found.durations.items()},
            "widening_by_roughness": found.widening,
            "rig_heating": {f"{mu:g}": value for mu, value in found.heating.items()},
        },
        figure=_draw(found.critical, found.known, found.rates),
    )


def _inferred(study: Study) -> _Inferred:
    white = study.scene("irg_transition")
    oils = {
        "white oil": (white,),
        "oil A": tuple(study.scene(name) for name in ("oil_a", "oil_a_hot")),
    }
    critical = {name: _critical(study, scenes) for name, scenes in oils.items()}
    study.tell("specific wear rate")
    rates = _wear_rates(white, TABLE_4, _DURATIONS)
    rates_of_a = [
        rate
        for scene in oils["oil A"]
        for row in _wear_rates(scene, _rows_of(scene), (_DURATIONS[_CHOSEN],)).values()
        for rate in row
    ]
    widening = _widening(white)
    study.tell("friction heating of the rig")
    heating = {friction: rig_heating(friction) for friction in _FRICTIONS}
    return _Inferred(oils, critical, rates, rates_of_a, widening, heating)


def _rows(found: _Inferred) -> Iterator[tuple[str, ...]]:
    yield ("critical temperature [°C], from each transition",)
    for name, scenes in found.oils.items():
        entries = [(entry, scene) for scene in scenes for entry in scene.measured]
        for (entry, scene), column in zip(entries, found.critical[name], strict=True):
            bulk = celsius(scene.conditions.bulk_temperature)
            yield (
                f"  {name}, {entry.normal_load:g} N, {entry.velocity:g} m/s, {bulk:g} °C",
                f"{found.known:g}" if name == "white oil" else "",
                mean_and_spread(column, 1),
            )
    yield (f"specific wear rate [1e-6 mm³/(N m)], if the test lasts {_DURATIONS[_CHOSEN]:g} s",)
    for load, row in found.rates.items():
        printed = f"{SPECIFIC_WEAR_RATE * 1e15:g}"
        yield f"  white oil, {load:g} N", printed, f"{row[_CHOSEN] * 1e15:.2f}"
    for at, rate in zip(TABLE_6, found.rates_of_a, strict=True):
        yield f"  oil A, {at.normal_load:g} N, {at.bulk_celsius:g} °C", "", f"{rate * 1e15:.2f}"
    yield ("duration of the test that gives the printed wear rate [s]",)
    for load, seconds in found.durations.items():
        yield f"  {load:g} N", "", f"{seconds:.1f}"
    yield ("friction heating of the critical-temperature rig [K]",)
    for friction, value in found.heating.items():
        yield f"  at friction {friction:g}", f"up to {RIG_HEATING:g}", f"{value:.1f}"


def _on_critical(found: _Inferred) -> tuple[Finding, Finding]:
    mean, spread = statistics(found.of_surfaces)
    of_transition = [statistics(column)[0] for column in found.critical["white oil"]]
    oil_a = [statistics(column)[0] for column in found.critical["oil A"]]
    return (
        Finding(
            f"a critical temperature of {found.known:g} °C for the white oil",
            f"{mean:.0f} °C ± {spread:.1f} K over surfaces, {min(of_transition):.0f} to "
            f"{max(of_transition):.0f} °C from single transitions",
            abs(mean - found.known) < 5,
            "So a single measured transition would have been enough to within "
            f"{max(abs(value - mean) for value in of_transition):.0f} K of all four.",
        ),
        Finding(
            "one critical temperature explains the transitions of oil A at both bulk temperatures",
            f"{', '.join(f'{value:.0f}' for value in oil_a)} °C",
            statistics(oil_a)[1] < 15,
            f"Their mean is {statistics(oil_a)[0]:.0f} °C and their spread "
            f"{statistics(oil_a)[1]:.0f} K, where the printed highest temperatures have "
            f"{statistics([row.max_celsius for row in TABLE_6])[1]:.0f} K (see table6).",
        ),
    )


def _on_wear_rate(found: _Inferred) -> Finding:
    rates, durations = [row[_CHOSEN] for row in found.rates.values()], found.durations.values()
    return Finding(
        f"a specific wear rate of {SPECIFIC_WEAR_RATE * 1e15:g}e-6 mm³/(N m) from the measured "
        "contact widths",
        f"{min(rates) * 1e15:.2f} to {max(rates) * 1e15:.2f}e-6 mm³/(N m) if the tests "
        f"last {_DURATIONS[_CHOSEN]:g} s",
        0.7 < statistics(rates)[0] / SPECIFIC_WEAR_RATE < 1.4,
        "How long the tests lasted is not printed; "
        f"{min(durations):.0f} to {max(durations):.0f} s give the printed rate.",
    )


def _on_rates_of_a(found: _Inferred) -> Finding:
    cold, hot = (
        [
            rate
            for at, rate in zip(TABLE_6, found.rates_of_a, strict=True)
            if (at.bulk_celsius == ROOM_CELSIUS) is is_cold
        ]
        for is_cold in (True, False)
    )
    means = [math.sqrt(math.prod(pair)) for pair in (cold, hot)]
    scenes = [scene.wear.specific_wear_rate for scene in found.oils["oil A"] if scene.wear]
    return Finding(
        "the specific wear rate belongs to the system",
        f"oil A has {', '.join(f'{rate * 1e15:.2f}' for rate in cold)} at {ROOM_CELSIUS:g} °C and "
        f"{', '.join(f'{rate * 1e15:.2f}' for rate in hot)}e-6 mm³/(N m) at "
        f"{TABLE_6[-1].bulk_celsius:g} °C, by its widths and the same duration",
        all(max(pair) < 1.4 * min(pair) for pair in (cold, hot))
        and max(means) < min(SPECIFIC_WEAR_RATE, *(row[_CHOSEN] for row in found.rates.values())),
        f"Its scenes have {' and '.join(f'{rate * 1e15:.2f}' for rate in scenes)}, within "
        f"{100 * max(abs(s / m - 1) for s, m in zip(scenes, means, strict=True)):.1f} % of the "
        "mean of each pair.",
    )


def _on_heating(found: _Inferred) -> Finding:
    return Finding(
        f"friction heats the rig by at most {RIG_HEATING:g} °C",
        ", ".join(f"{value:.1f} K at friction {mu:g}" for mu, value in found.heating.items()),
        found.heating[_FRICTIONS[1]] < RIG_HEATING * 1.01,
        "Up to a friction of "
        f"{_FRICTIONS[0] * RIG_HEATING / found.heating[_FRICTIONS[0]]:.2f} it is so; the friction "
        "that jumps, 0.4, heats more, but then the film has failed already.",
    )


def _critical(study: Study, scenes: Sequence[Sweep]) -> list[list[float]]:
    """Critical temperature [°C] by transition and surface."""
    found: list[list[float]] = []
    for scene in scenes:
        on_surfaces = replace(scene, realizations=tuple(study.seeds(_SURFACES)))
        result = critical_temperatures(on_surfaces, study.tell)
        found += [[float(celsius(value)) for value in row] for row in result.temperatures]
    return found


def _rows_of(scene: Sweep) -> list[Row6]:
    """The columns of Table 6 at the bulk temperature of a scene."""
    bulk = float(celsius(scene.conditions.bulk_temperature))
    return [row for row in TABLE_6 if math.isclose(row.bulk_celsius, bulk)]


def _wear_rates(
    sweep: Sweep, rows: Sequence[Row4 | Row6], durations: Sequence[float]
) -> dict[float, list[float]]:
    """Wear rate [m²/N] that gives each measured width, by load and duration of the test."""
    loading = sweep.loading
    if not isinstance(loading, Ramp):
        raise InputError("the wear rate of a width needs a scene with a ramp")
    smooth = replace(
        sweep,
        roughness=None,
        fidelity=replace(sweep.fidelity, averaging="mean", temperature_interval=0),
    )

    def rate(row: Row4 | Row6, duration: float) -> float:
        hold = duration - row.normal_load / loading.rate
        held = replace(smooth, loading=replace(loading, hold=hold, hold_steps=50))
        found = specific_wear_rate(held, row.measured_width, row.normal_load, row.velocity)
        return found.value

    return {row.normal_load: [rate(row, duration) for duration in durations] for row in rows}


def _widening(sweep: Sweep) -> float:
    """By how much the roughness widens the contact after a test, relative."""
    if not isinstance(sweep.loading, Ramp):
        raise InputError("the wear rate of Table 4 needs a scene with a ramp")
    row = TABLE_4[0]
    hold = _DURATIONS[len(_DURATIONS) // 2] - row.normal_load / sweep.loading.rate
    held = replace(sweep, loading=replace(sweep.loading, hold=hold, hold_steps=20))
    rough, smooth = (
        end_of(scene, row.normal_load, row.velocity).contact_width
        for scene in (held, replace(held, roughness=None))
    )
    return rough / smooth - 1


def _duration_for(rates: Sequence[float], wanted: float) -> float:
    """Duration at which the wear rate takes a value, linear in the logarithms."""
    slope, offset = np.polyfit(np.log(_DURATIONS), np.log(rates), 1)
    return math.exp((math.log(wanted) - offset) / slope)


@in_house_style
def _draw(
    critical: dict[str, list[list[float]]], known: float, rates: dict[float, list[float]]
) -> Figure:
    figure = Figure(figsize=(9.6, 4.4))
    left, right = figure.subplots(1, 2)
    start = 0
    for (name, columns), colour in zip(critical.items(), (BLUE, VERMILION), strict=True):
        mean, spread = np.array([statistics(column) for column in columns]).T
        at = np.arange(start, start + len(columns))
        left.errorbar(at, mean, spread, color=colour, marker="o", ls="none", capsize=3, label=name)
        left.hlines(mean.mean(), at[0] - 0.3, at[-1] + 0.3, color=colour, lw=0.9)
        start += len(columns)
    left.axhline(known, color=GREY, ls=":", lw=1.4, label=f"white oil on the rig, {known:g} °C")
    loads = [f"{row.normal_load:g} N" for row in TABLE_4]
    left.set_xticks(
        range(start),
        [*loads, *["700 N\n25 °C", "550 N\n25 °C", "700 N\n100 °C", "400 N\n100 °C"]][:start],
    )
    left.tick_params(axis="x", labelsize=8)
    bottom, top = left.get_ylim()
    left.set_ylim(bottom, top + 0.25 * (top - bottom))
    left.set_ylabel("critical temperature [°C]")
    left.set_title("from each measured transition", loc="left")
    left.legend(loc="upper left")

    for (load, row), colour in zip(rates.items(), (BLACK, BLUE, VERMILION, GREEN), strict=True):
        right.plot(_DURATIONS, 1e15 * np.array(row), "o-", color=colour, label=f"{load:g} N")
    right.axhline(1e15 * SPECIFIC_WEAR_RATE, color=GREY, ls=":", lw=1.4, label="printed")
    right.set_xlabel("duration of the test [s]")
    right.set_ylabel("specific wear rate [10$^{-6}$ mm³/(N m)]")
    right.set_ylim(0, None)
    right.set_title("from each measured contact width", loc="left")
    right.legend(loc="lower left", ncols=2)
    return figure
