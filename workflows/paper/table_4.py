"""Table 4: the contact at the measured transitions, over an ensemble of surfaces."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np
from matplotlib.figure import Figure

from pipeline.figures.style import GREY, celsius, in_house_style
from pipeline.sweep.conditions import Conditions
from pipeline.sweep.criterion import rise_limit
from pipeline.sweep.model import Measurement
from tribo.criterion import Criterion
from workflows.paper.publication import TABLE_4
from workflows.paper.report import Report, Table, line, mean
from workflows.paper.study import Study
from workflows.paper.transitions import HIGHEST, PATTERNS, beside, ensemble, matching, name_of

_BAND = 10.0  # K: within which the paper's highest temperatures lie
_GOOD = 0.05  # relative, of a friction coefficient
_LONGER = 4  # patches of the disk in a row, to see what hangs on the length of the patch
_FEW = 4  # surfaces for that
_WIDTHS = np.array([1e6 * row.unworn_width for row in TABLE_4])  # [µm]
_MAXIMA = np.array([row.max_celsius for row in TABLE_4])
_SHARES = np.array([100 * row.failed_share for row in TABLE_4])  # [%]
_FRICTIONS = np.array([row.friction for row in TABLE_4])


def table4(study: Study) -> Report:
    """Contact width, failed share and temperatures at the four measured transitions."""
    sweep = study.scene("irg_transition")
    conditions = sweep.conditions
    measured = matching(sweep, [row.normal_load for row in TABLE_4])
    ends = ensemble(study, ("unworn", *PATTERNS), [(sweep, entry) for entry in measured])

    patch = sweep.pixels
    long_patch = replace(patch, shape=(patch.shape[0], _LONGER * patch.shape[1]))
    few = replace(study, surfaces=min(_FEW, len(study.seeds(_FEW))))
    longer = [(replace(sweep, pixels=long_patch), measured[-1])]
    on_longer = ensemble(few, ("swept",), longer, "{}, longer patch")

    swept, limit = ends["swept"], rise_limit(conditions.changed(friction=1.0))
    printed_shares = [Criterion(share=row.failed_share) for row in TABLE_4]
    critical = conditions.known_critical_temperature()
    data: dict[str, Any] = {
        "load": [entry.normal_load for entry in measured],
        "unworn_width_um": 1e6 * ends["unworn"].contact_width,
        "bearing_width_um": 1e6 * ends["unworn"].bearing_width,
        "failed_percent": {wear: its.failed_percent(critical) for wear, its in ends.items()},
        "failed_percent_at_scene_friction": swept.failed_percent(critical, conditions.friction),
        "friction_for_printed_share": np.stack(
            [limit / swept.rise(share)[row] for row, share in enumerate(printed_shares)]
        ),
        "max_celsius_on_longer_patch": on_longer["swept"].celsius(HIGHEST)[0],
        "max_celsius": {wear: its.celsius(HIGHEST) for wear, its in ends.items()},
        "exceeded_celsius": {wear: its.celsius(conditions.decisive) for wear, its in ends.items()},
        "worn_width_um": 1e6 * swept.contact_width,
    }
    critical = float(celsius(critical))
    local_shares = mean(data["failed_percent"]["local"])
    values = {
        "surfaces": swept.contact_width.shape[1],
        "critical": critical,
        "friction": conditions.friction,
        **_widths(data),
        **_shares(data, conditions.friction),
        **_temperatures(data, critical, float(celsius(conditions.bulk_temperature))),
        "local_highest": mean(data["max_celsius"]["local"]),
        "local_share": local_shares.max(),
    }
    needed = abs(values["needed"] / conditions.friction - 1)
    return Report.of(
        "table4",
        values,
        verdicts={
            "width": abs(values["width_off"]).max() < 15,
            "share": needed.max() < _GOOD,
            "highest": abs(values["apart"]).max() < _BAND and values["interval"] <= _BAND,
            "local": local_shares.min() > 5,
        },
        table=_table(data, measured, conditions),
        data=data,
        figure=_draw(data, measured, critical),
    )


def _widths(data: dict[str, Any]) -> dict[str, Any]:
    """Unworn widths against the printed ones [%], by both ways to take them."""
    off, below = (
        100 * (mean(data[key]) / _WIDTHS - 1) for key in ("unworn_width_um", "bearing_width_um")
    )
    why = "why_between" if below.max() <= 0 <= off.min() else "why"
    return {"width_off": off, "bearing_off": below, "why": why}


def _shares(data: dict[str, Any], friction: float) -> dict[str, Any]:
    """Failed shares with the measured frictions and with one, and the effect of friction."""
    shares = mean(data["failed_percent"]["swept"])
    alike = mean(data["failed_percent_at_scene_friction"])
    other = friction != _FRICTIONS
    steep = _GOOD * friction * (shares - alike)[other] / (_FRICTIONS - friction)[other]
    needed = mean(data["friction_for_printed_share"])
    return {"needed": needed, "good": _GOOD, "shares": shares, "alike": alike, "steep": steep}


def _temperatures(data: dict[str, Any], critical: float, bulk: float) -> dict[str, Any]:
    """Highest temperatures with swept wear beside the printed ones."""
    maxima, tenths = mean(data["max_celsius"]["swept"]), mean(data["exceeded_celsius"]["swept"])
    return {
        "maxima": maxima,
        "apart": maxima - _MAXIMA,
        "interval": np.ptp(maxima),
        "above": maxima.mean() / critical - 1,
        "ratios": (tenths - bulk) / (maxima - bulk),
        "printed_ratios": (critical - bulk) / (_MAXIMA - bulk),
        "times_longer": _LONGER,
        "longer": mean(data["max_celsius_on_longer_patch"]),
        "last": maxima[-1],
        "last_load": data["load"][-1],
    }


def _table(data: dict[str, Any], measured: list[Measurement], conditions: Conditions) -> Table:
    wears = (*PATTERNS, "unworn")
    critical = celsius(conditions.known_critical_temperature())

    def by_wear(key: str, form: str = ".0f") -> list[tuple[str, ...]]:
        return [line(f"  {wear}", data[key][wear], form) for wear in wears]

    return Table(
        ("", *map(name_of, measured)),
        (
            ("unworn contact width [µm]",),
            line("  printed", _WIDTHS),
            line("  outermost elements in contact", data["unworn_width_um"]),
            line("  rows that bear 5 % of the most loaded", data["bearing_width_um"]),
            (f"share of the contact above {critical:g} °C [%]",),
            line("  printed", _SHARES, ".1f"),
            *by_wear("failed_percent", ".1f"),
            line(
                f"  swept, friction {conditions.friction:g} at each",
                data["failed_percent_at_scene_friction"],
                ".1f",
            ),
            ("friction coefficient",),
            line("  measured", _FRICTIONS, ".3f"),
            line(
                "  that gives the printed share, swept", data["friction_for_printed_share"], ".4f"
            ),
            ("highest temperature [°C]",),
            line("  printed", _MAXIMA),
            *by_wear("max_celsius"),
            (f"temperature exceeded on {100 * conditions.failing_share:g} % of the contact [°C]",),
            *by_wear("exceeded_celsius"),
            ("contact width at the end of the ramp [µm]",),
            line("  printed, measured later", [1e6 * row.measured_width for row in TABLE_4]),
            line("  swept", data["worn_width_um"]),
        ),
    )


@in_house_style
def _draw(data: dict[str, Any], measured: list[Measurement], critical: float) -> Figure:
    figure = Figure(figsize=(9.6, 7.0))
    (first, second), (third, fourth) = figure.subplots(2, 2)
    ticks = [f"{entry.normal_load:g} N\n{entry.velocity:g} m/s" for entry in measured]
    unworn = {"unworn": data["unworn_width_um"]}
    share = f"share of the contact above {critical:g} °C [%]"
    beside(first, ticks, _WIDTHS, unworn, "unworn contact width [µm]")
    beside(second, ticks, _SHARES, data["failed_percent"], share)
    beside(third, ticks, _MAXIMA, data["max_celsius"], "highest temperature [°C]")
    exceeded = "temperature exceeded on 10 % [°C]"
    beside(fourth, ticks, None, data["exceeded_celsius"], exceeded)
    first.set_ylim(0, None)
    for axes in (third, fourth):
        axes.axhline(critical, color=GREY, ls=":", lw=1.2)
    lows, highs = zip(third.get_ylim(), fourth.get_ylim(), strict=True)
    for axes in (third, fourth):
        axes.set_ylim(min(lows), max(highs))
    figure.legend(*third.get_legend_handles_labels(), loc="outside lower center", ncols=4)
    return figure
