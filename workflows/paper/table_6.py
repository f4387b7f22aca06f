"""Table 6: temperatures at the transitions of oil A, over an ensemble of surfaces."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Any

import numpy as np
import pandas as pd
from matplotlib.figure import Figure

from pipeline.figures.style import house_style
from pipeline.quantities import in_unit
from tribo.types import Array

from .publication import ROOM_CELSIUS, TABLE_4, TABLE_6
from .recomputed import Recomputation, agree, line, mean, texts
from .study import Study
from .transitions import (
    HIGHEST,
    SPREAD,
    celsius_of,
    draw_beside,
    ensemble,
    label_of,
    oil_a,
    on_surfaces,
)

_SURFACES = 8
_LIKE = 0.15  # relative difference of rises that are called alike
_CONSTANTS = 3  # of the law rise/friction = C Fᵃ Vⁿ
_DECISIVE = 3.0  # ratio of misfits above which the worse reading is rejected


def table6(study: Study) -> Recomputation:
    """Report on temperatures at the transitions of oil A, at two bulk temperatures."""
    transitions = oil_a(study)
    ends = ensemble(study, ("swept", "local"), transitions)
    white_rate = study.scene("table4").source.entries["wear"]["specific_wear_rate"]
    seeds = study.stages(study.seeds(_SURFACES), "the white oil's wear rate, surface {}".format)
    as_white = on_surfaces(
        [(scene.changed("wear.specific_wear_rate", white_rate), row) for scene, row in transitions],
        seeds,
    )
    fraction, swept = transitions[0][0].conditions.critical_area_fraction, ends["swept"]
    highest = {wear: celsius_of(its, HIGHEST) for wear, its in ends.items()}
    exceeded = {wear: celsius_of(its, fraction) for wear, its in ends.items()}
    at_room = highest["swept"] - in_unit(swept["bulk"], "°C") + ROOM_CELSIUS
    white_at_room = celsius_of(as_white, HIGHEST) - in_unit(as_white["bulk"], "°C") + ROOM_CELSIUS
    misfit = {"25": _misfit(25.0), "100": _misfit(100.0)}
    data: dict[str, Any] = {
        "load": TABLE_6.normal_load,
        "velocity": TABLE_6.velocity,
        "bulk_temperature": swept["bulk"][:, 0],
        "max_celsius": highest,
        "exceeded_celsius": exceeded,
        "misfit_by_bulk_celsius": misfit,
        "width_um": 1e6 * swept["contact_width"],
        "max_celsius_at_room_temperature": at_room,
        "max_celsius_at_room_temperature_and_white_wear_rate": white_at_room,
        "velocity_exponent": {
            "printed": _law(TABLE_6.max_celsius)[2],
            "computed": _law(mean(at_room))[2],
            "computed, the white oil's wear rate": _law(mean(white_at_room))[2],
        },
    }
    tenths = mean(exceeded["swept"])
    values = {
        "surfaces": at_room.shape[1],
        "room": ROOM_CELSIUS,
        "hot_bulk": TABLE_6[-1].bulk_celsius,
        "misfit_hot": misfit["100"],
        "misfit_room": misfit["25"],
        "degrees": len(TABLE_4) + len(TABLE_6) - _CONSTANTS,
        **_levels(mean(at_room)),
        "ratios_white": (TABLE_6.max_celsius - ROOM_CELSIUS) / (mean(white_at_room) - ROOM_CELSIUS),
        "exponents": list(data["velocity_exponent"].values()),
        "printed_interval": np.ptp(TABLE_6.max_celsius),
        "maxima": mean(highest["swept"]),
        "interval": np.ptp(tenths),
        "interval_of_maxima": np.ptp(mean(highest["swept"])),
        "mean": mean(tenths),
    }
    names = [f"{label_of(row)}, {row.bulk_celsius:g} °C" for row in TABLE_6]
    share = f"{100 * fraction:g} %"
    return Recomputation.from_values(
        "table6",
        values,
        verdicts={
            "bulk": misfit["100"] < _DECISIVE * misfit["25"],
            "highest": agree(highest["swept"], TABLE_6.max_celsius, TABLE_6.bulk_celsius),
            "interval": values["interval_of_maxima"] <= values["printed_interval"],
        },
        table=_table(data, names, share),
        data=data,
        figure=_draw(data, names, share),
    )


def _misfit(bulk_celsius: float) -> float:
    """Standard deviation of ln(rise) of the paper's temperatures from rise/friction = C Fᵃ Vⁿ."""
    rows = [(row, ROOM_CELSIUS) for row in TABLE_4]
    rows += [(row, min(row.bulk_celsius, bulk_celsius)) for row in TABLE_6]
    logarithms = [math.log((row.max_celsius - bulk) / row.friction) for row, bulk in rows]
    terms = [(1.0, math.log(row.normal_load), math.log(row.velocity)) for row, _ in rows]
    law, *_ = np.linalg.lstsq(np.array(terms), np.array(logarithms), rcond=None)
    off = np.array(logarithms) - np.array(terms) @ law
    return float(np.sqrt(off @ off / (len(rows) - _CONSTANTS)))


def _law(celsius: Array) -> Array:
    """Values of ln C, a, n in rise/friction = C Fᵃ Vⁿ of temperatures [°C] at a bulk of 25 °C."""
    F, V = TABLE_6.normal_load, TABLE_6.velocity
    terms = np.column_stack([np.ones(len(F)), np.log(F), np.log(V)])
    law, *_ = np.linalg.lstsq(terms, np.log((celsius - ROOM_CELSIUS) / TABLE_6.friction))
    return np.asarray(law)


def _levels(at_room: Array) -> dict[str, Any]:
    """Ratios of printed to computed rises with bodies at room temperature, by name."""
    ratios = (TABLE_6.max_celsius - ROOM_CELSIUS) / (at_room - ROOM_CELSIUS)
    good, is_hot = abs(ratios - 1) < _LIKE, TABLE_6.bulk_celsius > ROOM_CELSIUS
    return {
        "at_room": at_room,
        "ratios": ratios,
        "cold": ratios[~is_hot],
        "hot": ratios[is_hot],
        "why": "why_all" if good.all() else "why_hot" if good[is_hot].all() else "why",
    }


def _table(data: dict[str, Any], names: Sequence[str], share: str) -> pd.DataFrame:
    return texts(
        ("", *names),
        (
            ("highest temperature [°C]",),
            line("  printed", TABLE_6.max_celsius),
            *(line(f"  {wear}", values) for wear, values in data["max_celsius"].items()),
            line("  swept, with the bulk at 25 °C", data["max_celsius_at_room_temperature"]),
            (f"temperature exceeded on {share} of the contact [°C]",),
            *(line(f"  {wear}", values) for wear, values in data["exceeded_celsius"].items()),
            ("contact width at the end of the ramp [µm]",),
            line("  printed, measured later", 1e6 * TABLE_6.measured_width),
            line("  swept", data["width_um"]),
        ),
    )


@house_style
def _draw(data: dict[str, Any], names: Sequence[str], share: str) -> Figure:
    ticks = ["\n".join(name.rsplit(", ", 1)) for name in names]
    figure = Figure(figsize=(9.6, 4.6))
    left, right = figure.subplots(1, 2, sharey=True)
    at_room = {"swept, bulk 25 °C": data["max_celsius_at_room_temperature"]}
    highest = data["max_celsius"] | at_room
    draw_beside(left, ticks, TABLE_6.max_celsius, highest, "highest temperature [°C]")
    title = f"temperature exceeded on {share} [°C]"
    draw_beside(right, ticks, None, data["exceeded_celsius"], title)
    for axes in (left, right):
        axes.tick_params(axis="x", labelsize=8)
    shared = left.get_legend_handles_labels()
    figure.legend(*shared, loc="outside lower center", ncols=4, title=SPREAD)
    return figure
