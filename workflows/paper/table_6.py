"""Table 6: temperatures at the transitions of oil A, over an ensemble of surfaces."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
from matplotlib.figure import Figure

from pipeline.figures.style import celsius, in_house_style
from workflows.paper.ensemble import (
    Ensemble,
    Values,
    beside,
    ensemble,
    matching,
    name_of,
    worn,
)
from workflows.paper.publication import ROOM_CELSIUS, TABLE_4, TABLE_6, Row4, Row6
from workflows.paper.report import Report, Table, line, means, statistics
from workflows.paper.study import End, Study

_PRINTED = [row.max_celsius for row in TABLE_6]  # [°C]
_GOOD = 0.15  # relative, of a rise
_DECISIVE = 3.0  # times as large a misfit, from which one reading is taken for the other
_SCENES = {"oil_a": 25.0, "oil_a_hot": 100.0}  # bulk temperature by scene [°C]


def table6(study: Study) -> Report:
    """Temperatures at the measured transitions of oil A, at two bulk temperatures."""
    cold, hot = (_of_scene(study, name, bulk) for name, bulk in _SCENES.items())
    transitions = cold + hot
    bulks = [float(celsius(its.bulk_temperature)) for its in transitions.conditions]
    data: dict[str, Any] = {
        "load": [entry.normal_load for entry in transitions.measured],
        "velocity": [entry.velocity for entry in transitions.measured],
        "bulk_temperature": [its.bulk_temperature for its in transitions.conditions],
        "max_celsius": transitions.of_all(End.highest),
        "exceeded_celsius": transitions.of_all(End.exceeded),
        "misfit_by_bulk_celsius": {"25": _misfit(25.0), "100": _misfit(100.0)},
        "width_um": transitions.widths("swept"),
    }
    at_room = _at_room(data["max_celsius"]["swept"], bulks)
    data["max_celsius_at_room_temperature"] = at_room
    share = transitions.conditions[0].failing_share
    values = {
        "surfaces": len(data["width_um"][0]),
        "share": share,
        "room": ROOM_CELSIUS,
        **_bulk_of_hot_rows(),
        **_levels(means(at_room), bulks),
        **_intervals(data),
    }
    misfit = data["misfit_by_bulk_celsius"]
    return Report.of(
        "table6",
        values,
        verdicts={
            "bulk": misfit["100"] < _DECISIVE * misfit["25"],
            "highest": max(abs(ratio - 1) for ratio in values["ratios"]) < _GOOD,
            "interval": values["interval"] <= values["printed_interval"],
        },
        table=_table(data, transitions, bulks, f"{100 * share:g} %"),
        data=data,
        figure=_draw(data, transitions, bulks, f"{100 * share:g} %"),
    )


def _of_scene(study: Study, name: str, bulk_celsius: float) -> Ensemble:
    """The transitions of a scene with oil A, at its bulk temperature."""
    sweep = study.scene(name)
    loads = [row.normal_load for row in TABLE_6 if row.bulk_celsius == bulk_celsius]
    return ensemble(study, worn(sweep), matching(sweep, loads), name + ", {}")


def _at_room(values: Values, bulks: list[float]) -> Values:
    """Temperatures as they would be with the bulk at room temperature [°C]."""
    return [
        [value - bulk + ROOM_CELSIUS for value in column]
        for bulk, column in zip(bulks, values, strict=True)
    ]


def _bulk_of_hot_rows() -> dict[str, Any]:
    """The bulk temperature that the printed temperatures of the hot rows are those of."""
    # The two tables at one velocity and nearly one load: the rise is proportional to friction, and
    # between loads so near it lies between unchanged and in proportion to them.
    white, oil_a = TABLE_4[0], TABLE_6[2]
    rise = (white.max_celsius - ROOM_CELSIUS) / white.friction * oil_a.friction
    ends = rise * oil_a.normal_load / white.normal_load, rise
    return {
        "hot_bulk": oil_a.bulk_celsius,
        "misfit_hot": _misfit(TABLE_6[-1].bulk_celsius),
        "misfit_room": _misfit(ROOM_CELSIUS),
        "white": white,
        "oil_a": oil_a,
        "from_room": [end + ROOM_CELSIUS for end in ends],
        "from_hot": [end + oil_a.bulk_celsius for end in ends],
    }


def _misfit(bulk_celsius: float) -> float:
    """Misfit of a law C Fᵃ Vⁿ for rise/friction to the paper's highest temperatures, relative.

    Standard deviation of the logarithms, with the bulk of the hot rows as given [°C].
    """
    rows: list[tuple[Row4 | Row6, float]] = [(row, ROOM_CELSIUS) for row in TABLE_4]
    rows += [(row, min(row.bulk_celsius, bulk_celsius)) for row in TABLE_6]
    logarithms = [math.log((row.max_celsius - bulk) / row.friction) for row, bulk in rows]
    terms = [(1.0, math.log(row.normal_load), math.log(row.velocity)) for row, _ in rows]
    law, *_ = np.linalg.lstsq(np.array(terms), np.array(logarithms), rcond=None)
    off = np.array(logarithms) - np.array(terms) @ law
    return float(np.sqrt(off @ off / (len(rows) - len(law))))


def _levels(temperatures: list[float], bulks: list[float]) -> dict[str, Any]:
    """Printed rises over ours with the bulk at room temperature."""
    rises = [value - ROOM_CELSIUS for value in temperatures]
    printed = [value - ROOM_CELSIUS for value in _PRINTED]
    ratios = [theirs / ours for theirs, ours in zip(printed, rises, strict=True)]
    is_hot = [bulk > ROOM_CELSIUS for bulk in bulks]
    hot = [ratio for ratio, hot in zip(ratios, is_hot, strict=True) if hot]
    cold = [ratio for ratio, hot in zip(ratios, is_hot, strict=True) if not hot]
    return {
        "at_room": [rise + ROOM_CELSIUS for rise in rises],
        "ratios": ratios,
        "cold": cold,
        "hot": hot,
        "why": "why_all"
        if all(abs(ratio - 1) < _GOOD for ratio in ratios)
        else "why_hot"
        if all(abs(ratio - 1) < _GOOD for ratio in hot)
        else "why",
    }


def _intervals(data: dict[str, Any]) -> dict[str, Any]:
    """Intervals of the temperatures, printed and ours [K]."""
    maxima, tenths = means(data["max_celsius"]["swept"]), means(data["exceeded_celsius"]["swept"])
    mean, deviation = statistics(tenths)
    return {
        "printed_interval": max(_PRINTED) - min(_PRINTED),
        "interval": max(tenths) - min(tenths),
        "interval_of_maxima": max(maxima) - min(maxima),
        "mean": mean,
        "deviation": deviation,
    }


def _table(data: dict[str, Any], transitions: Ensemble, bulks: list[float], share: str) -> Table:
    heads = zip(transitions.measured, bulks, strict=True)
    return Table(
        ("", *(f"{name_of(entry)}, {bulk:g} °C" for entry, bulk in heads)),
        (
            ("highest temperature [°C]",),
            line("  printed", _PRINTED),
            *(line(f"  {name}", values) for name, values in data["max_celsius"].items()),
            line("  swept, with the bulk at 25 °C", data["max_celsius_at_room_temperature"]),
            (f"temperature exceeded on {share} of the contact [°C]",),
            *(line(f"  {name}", values) for name, values in data["exceeded_celsius"].items()),
            ("contact width at the end of the ramp [µm]",),
            line("  printed, measured later", [1e6 * row.measured_width for row in TABLE_6]),
            line("  swept", data["width_um"]),
        ),
    )


@in_house_style
def _draw(data: dict[str, Any], transitions: Ensemble, bulks: list[float], share: str) -> Figure:
    heads = zip(transitions.measured, bulks, strict=True)
    ticks = [f"{name_of(entry)}\n{bulk:g} °C" for entry, bulk in heads]
    figure = Figure(figsize=(9.6, 4.6))
    left, right = figure.subplots(1, 2, sharey=True)
    at_room = {"swept, bulk 25 °C": data["max_celsius_at_room_temperature"]}
    beside(left, ticks, _PRINTED, data["max_celsius"] | at_room, "highest temperature [°C]")
    title = f"temperature exceeded on {share} [°C]"
    beside(right, ticks, None, data["exceeded_celsius"], title)
    for axes in (left, right):
        axes.tick_params(axis="x", labelsize=8)
    handles, labels = left.get_legend_handles_labels()
    figure.legend(handles, labels, loc="outside lower center", ncols=3)
    return figure
