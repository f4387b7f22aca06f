"""Table 4: the contact at the measured transitions, over an ensemble of surfaces."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np
import pandas as pd
from matplotlib.figure import Figure

from pipeline import Conditions, Sweep
from pipeline.answers.scene_wording import governing_words
from pipeline.figures.style import GREY, house_style
from pipeline.quantities import in_unit
from pipeline.sweep.case import allowable_rise, known_critical_temperature
from tribo.thermal import rise_exceeded

from .publication import ROOM_CELSIUS, TABLE_4
from .recomputed import Recomputation, agree, line, mean, spread, texts
from .study import Study
from .transitions import (
    HIGHEST,
    SPREAD,
    SURFACES,
    celsius_of,
    draw_beside,
    ensemble,
    failed_percent,
    label_of,
    on_surfaces,
    worn,
)

_STEP = 0.05  # relative change of friction, to find how fast a share changes
_LONGER = 4  # factor on the length of the window, to see its effect
_FEW = 4  # number of surfaces with the longer window
_RA = "0.2 um"  # to which the printed unworn widths fit
_SMOOTHER = {"disk.roughness.ra": _RA, "disk.roughness.correlation_length": "12 um"}
_NEAR_FRICTION = 0.02  # relative, of a measured friction
_WIDTHS = 1e6 * TABLE_4.unworn_width  # [µm]
_SHARES = 100 * TABLE_4.failed_share  # [%]


def table4(study: Study) -> Recomputation:
    """Report on contact width, failed share and temperatures at the four measured transitions."""
    sweep = study.scene("table4")
    data = _simulated(study, sweep)
    values = _compared(data, sweep.conditions)
    return Recomputation.from_values(
        "table4",
        values,
        verdicts={
            "width": agree(data["unworn_width_um"], _WIDTHS),
            "share": agree(data["failed_percent"]["swept"], _SHARES),
            "highest": agree(data["max_celsius"]["swept"], TABLE_4.max_celsius, ROOM_CELSIUS),
            "friction": np.allclose(values["needed"], TABLE_4.friction, rtol=_NEAR_FRICTION),
            "roughness": abs(values["width_off_mean"]) < abs(values["width_off_at_ra"]),
            "local": agree(data["failed_percent"]["local"], _SHARES),
        },
        table=_table(data, sweep.conditions),
        data=data,
        figure=_draw(data, values["critical"]),
    )


def _simulated(study: Study, sweep: Sweep) -> dict[str, Any]:
    """Computed widths, shares and temperatures, by name, with each wear and a longer window."""
    conditions = sweep.conditions
    ends = ensemble(study, ("unworn", "swept", "local"), [(sweep, row) for row in TABLE_4])
    swept, unworn = ends["swept"], ends["unworn"]
    nx, ny = sweep.scene.pixels.shape
    longer = sweep.changed("window.pixels", [nx, _LONGER * ny])
    few = study.stages(study.seeds(_FEW)[:_FEW], "swept, longer window, surface {}".format)
    on_longer = on_surfaces([(longer, TABLE_4[-1])], few)
    critical = known_critical_temperature(conditions)
    limit = allowable_rise(replace(conditions, friction=1.0))
    flatter = worn(sweep.changed("disk.roughness.ra", _RA), "unworn")
    smoother = sweep
    for path, entry in _SMOOTHER.items():
        smoother = smoother.changed(path, entry)
    variations = {"unworn, Ra 0.20 µm": flatter, "swept, Ra 0.20 µm, 12 µm": smoother}
    of_others = {
        name: on_surfaces(
            [(other, row) for row in TABLE_4],
            study.stages(study.seeds(SURFACES), (name + ", surface {}").format),
        )
        for name, other in variations.items()
    }
    flat, smooth = of_others.values()
    return {
        "load": TABLE_4.normal_load,
        "unworn_width_um": 1e6 * unworn["contact_width"],
        "bearing_width_um": 1e6 * unworn["bearing_width"],
        "failed_percent": {wear: failed_percent(its, critical) for wear, its in ends.items()},
        "failed_percent_at_scene_friction": failed_percent(swept, critical, conditions.friction),
        "friction_for_printed_share": np.stack(
            [
                limit / rise_exceeded(swept["rise_quantile"], row.failed_share)[number]
                for number, row in enumerate(TABLE_4)
            ]
        ),
        "max_celsius_with_longer_window": celsius_of(on_longer, HIGHEST)[0],
        "max_celsius": {wear: celsius_of(its, HIGHEST) for wear, its in ends.items()},
        "exceeded_celsius": {
            wear: celsius_of(its, conditions.critical_area_fraction) for wear, its in ends.items()
        },
        "worn_width_um": 1e6 * swept["contact_width"],
        "unworn_width_um_at_ra": 1e6 * flat["contact_width"],
        "failed_percent_smoother": failed_percent(smooth, critical, conditions.friction),
        "max_celsius_smoother": celsius_of(smooth, HIGHEST),
        "exceeded_celsius_smoother": celsius_of(smooth, conditions.critical_area_fraction),
    }


def _compared(data: dict[str, Any], conditions: Conditions) -> dict[str, Any]:
    """Means over surfaces, and their deviations from printed values, by name."""
    friction, bulk = conditions.friction, float(in_unit(conditions.bulk_temperature, "°C"))
    critical = float(in_unit(known_critical_temperature(conditions), "°C"))
    outer, bearing = (
        100 * (mean(data[key]) / _WIDTHS - 1) for key in ("unworn_width_um", "bearing_width_um")
    )
    shares = mean(data["failed_percent"]["swept"])
    at_scene_friction = mean(data["failed_percent_at_scene_friction"])
    other = friction != TABLE_4.friction
    maxima, tenths = mean(data["max_celsius"]["swept"]), mean(data["exceeded_celsius"]["swept"])
    return {
        "surfaces": data["worn_width_um"].shape[1],
        "critical": critical,
        "width_off": outer,
        "bearing_off": bearing,
        "why": "why_between" if bearing.max() <= 0 <= outer.min() else "why",
        "good": _STEP,
        "shares": shares,
        "steep": _STEP
        * friction
        * (shares - at_scene_friction)[other]
        / (TABLE_4.friction - friction)[other],
        "maxima": maxima,
        "apart": maxima - TABLE_4.max_celsius,
        "ratios": (tenths - bulk) / (maxima - bulk),
        "ratios_smoother": (mean(data["exceeded_celsius_smoother"]) - bulk)
        / (mean(data["max_celsius_smoother"]) - bulk),
        "shares_alike": at_scene_friction,
        "shares_smoother": mean(data["failed_percent_smoother"]),
        "spreads_smoother": spread(data["failed_percent_smoother"]),
        "needed": mean(data["friction_for_printed_share"]),
        "friction": friction,
        "width_off_mean": outer.mean(),
        "width_off_at_ra": 100 * (mean(data["unworn_width_um_at_ra"]) / _WIDTHS - 1).mean(),
        "longer": _LONGER,
        "highest_longer": mean(data["max_celsius_with_longer_window"])
        - mean(data["max_celsius"]["swept"])[-1],
        "printed_ratios": (critical - bulk) / (TABLE_4.max_celsius - bulk),
        "local_share": mean(data["failed_percent"]["local"]).max(),
    }


def _table(data: dict[str, Any], conditions: Conditions) -> pd.DataFrame:
    critical = in_unit(known_critical_temperature(conditions), "°C")
    needed = data["friction_for_printed_share"]
    label = f"  swept, friction {conditions.friction:g} at each"

    def by_wear(key: str, form: str = ".0f") -> list[tuple[str, ...]]:
        return [line(f"  {wear}", data[key][wear], form) for wear in ("swept", "local", "unworn")]

    return texts(
        ("", *map(label_of, TABLE_4)),
        (
            ("unworn contact width [µm]",),
            line("  printed", _WIDTHS),
            line("  outermost elements in contact", data["unworn_width_um"]),
            line("  rows that bear 5 % of the most loaded", data["bearing_width_um"]),
            (f"contact area above {critical:g} °C [%]",),
            line("  printed", _SHARES, ".1f"),
            *by_wear("failed_percent", ".1f"),
            line(label, data["failed_percent_at_scene_friction"], ".1f"),
            ("friction coefficient",),
            line("  measured", TABLE_4.friction, ".3f"),
            line("  that gives the printed area fraction, swept", needed, ".4f"),
            ("highest temperature [°C]",),
            line("  printed", TABLE_4.max_celsius),
            *by_wear("max_celsius"),
            (f"temperature {governing_words(conditions.critical_area_fraction)} [°C]",),
            *by_wear("exceeded_celsius"),
            ("contact width at the end of the ramp [µm]",),
            line("  printed, measured later", 1e6 * TABLE_4.measured_width),
            line("  swept", data["worn_width_um"]),
        ),
    )


@house_style
def _draw(data: dict[str, Any], critical: float) -> Figure:
    figure = Figure(figsize=(9.6, 7.0))
    (first, second), (third, fourth) = figure.subplots(2, 2)
    ticks = [label_of(row).replace(", ", "\n") for row in TABLE_4]
    unworn = {"unworn": data["unworn_width_um"]}
    share = f"contact area above {critical:g} °C [%]"
    exceeded = "temperature exceeded on 10 % [°C]"
    draw_beside(first, ticks, _WIDTHS, unworn, "unworn contact width [µm]")
    draw_beside(second, ticks, _SHARES, data["failed_percent"], share)
    draw_beside(third, ticks, TABLE_4.max_celsius, data["max_celsius"], "highest temperature [°C]")
    draw_beside(fourth, ticks, None, data["exceeded_celsius"], exceeded)
    first.set_ylim(0, None)
    for axes in (third, fourth):
        axes.axhline(critical, color=GREY, ls=":", lw=1.2, label=f"critical, {critical:g} °C")
    lows, highs = zip(third.get_ylim(), fourth.get_ylim(), strict=True)
    for axes in (third, fourth):
        axes.set_ylim(min(lows), max(highs))
    figure.legend(
        *third.get_legend_handles_labels(), loc="outside lower center", ncols=5, title=SPREAD
    )
    return figure
