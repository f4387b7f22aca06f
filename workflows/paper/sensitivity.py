"""Sensitivity to the lateral structure of the roughness, which is not published."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace
from typing import Any

import numpy as np
import pandas as pd
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from pipeline import Sweep
from pipeline.figures.style import BLACK, BLUE, GREEN, GREY, VERMILION, house_style
from pipeline.quantities import shown_in
from pipeline.sweep.conditions import known_critical_temperature
from tribo import InputError, SelfAffineRoughness
from tribo.types import Array

from .labels import label_ends
from .publication import TABLE_4
from .report import Report, agree, cells, mean, spread, texts
from .study import Study
from .transitions import HIGHEST, around_transition, celsius_of, on_surfaces, worn

_LENGTHS = (2.0, 3.0, 4.0, 5.0, 6.0, 8.0)  # µm
_LAYS = ((1.0, 1.0), (1.0, 4.0), (4.0, 1.0))  # factors on the length along x and along y
_HURST = (0.5, 0.65, 0.8, 1.0)
_RAS = (0.15, 0.2)  # µm, beside the scene's own
_SMOOTH_RA, _SMOOTH_LENGTH = 0.2, 12.0  # [µm], fitted to the unworn widths and the shares
_SMOOTHER = f"{_SMOOTH_RA:g} µm, length {_SMOOTH_LENGTH:g} µm"
_SURFACES = 4
_OFF = "critical_velocity_off"
_GOOD = 0.1  # relative error of velocity that agrees, as in report.agree


_Outcome = dict[str, Array]
"""Temperatures at the measured friction [°C], and errors of the critical velocity at the scene's
friction, relative; by transition and surface."""
_Outcomes = Mapping[str, Mapping[str, _Outcome]]
"""Outcomes by the kind of change, and by the change."""


def _on(sweep: Sweep, surface: SelfAffineRoughness) -> Sweep:
    table = {
        "ra": f"{surface.ra!r} m",
        "hurst_exponent": surface.hurst_exponent,
        "correlation_length": [f"{length!r} m" for length in surface.correlation_length],
        "seed": surface.seed,
    }
    return sweep.changed("disk.roughness", table)


def sensitivity(study: Study) -> Report:
    """Report on temperatures and critical velocities with other rough surfaces."""
    sweep = study.scene("table4")
    rough = sweep.scene.roughness
    if not isinstance(rough, SelfAffineRoughness):
        raise InputError(f"the scene {sweep.name} must have a random surface, as in Table 4")
    kinds = _kinds(rough)
    names = {
        surface: f"{kind} {name}"
        for kind, variants in kinds.items()
        for name, surface in variants.items()
    }
    by_surface = {
        surface: _outcome(study, _on(sweep, surface))
        for surface in study.stages(names, names.__getitem__)
    }
    outcomes = {
        kind: {name: by_surface[surface] for name, surface in variants.items()}
        for kind, variants in kinds.items()
    }
    widths = {
        name: _unworn_widths(study, _on(sweep, surface))
        for name, surface in study.stages(kinds["Ra"].items(), lambda item: f"unworn, Ra {item[0]}")
    }
    values = {
        "surfaces": len(study.seeds(_SURFACES)),
        "ra": rough.ra * 1e6,
        "length": rough.correlation_length[0] * 1e6,
        "hurst": rough.hurst_exponent,
        "good": _GOOD,
        **_of_velocities(outcomes, by_surface[rough]),
        **_of_widths(widths),
    }
    return Report.of(
        "sensitivity",
        values,
        verdicts={
            "velocities": _worst(by_surface[rough]) < _GOOD,
            "widths": agree(widths[f"{rough.ra * 1e6:g} µm"], 1e6 * TABLE_4.unworn_width),
        },
        table=_table(sweep, outcomes, widths),
        data={**outcomes, "unworn_width_um": widths},
        figure=_draw(sweep, outcomes),
    )


def _kinds(rough: SelfAffineRoughness) -> dict[str, dict[str, SelfAffineRoughness]]:
    """Roughness with one parameter changed, by kind of parameter and by its value as text."""
    base = rough.correlation_length[0] * 1e6

    def of_lengths(along: float, across: float) -> SelfAffineRoughness:
        return replace(rough, correlation_length=(along * 1e-6, across * 1e-6))

    smoother = replace(of_lengths(_SMOOTH_LENGTH, _SMOOTH_LENGTH), ra=1e-6 * _SMOOTH_RA)
    ras = (*(1e-6 * ra for ra in _RAS), rough.ra)
    return {
        "correlation length": {f"{length:g} µm": of_lengths(length, length) for length in _LENGTHS},
        "lay": {
            f"{base * along:g} × {base * across:g} µm": of_lengths(base * along, base * across)
            for along, across in _LAYS
        },
        "Hurst exponent": {f"{value:g}": replace(rough, hurst_exponent=value) for value in _HURST},
        "Ra": {f"{1e6 * ra:g} µm": replace(rough, ra=ra) for ra in ras} | {_SMOOTHER: smoother},
    }


def _outcome(study: Study, sweep: Sweep) -> _Outcome:
    transitions = [(sweep, row) for row in TABLE_4]
    ends = on_surfaces(transitions, study.seeds(_SURFACES), around_transition)
    return {
        "exceeded_celsius": celsius_of(ends, sweep.conditions.criterion),
        "max_celsius": celsius_of(ends, HIGHEST),
        _OFF: ends["velocity_off"],
    }


def _worst(outcome: _Outcome) -> float:
    """Largest relative error of a critical velocity, after averaging over surfaces."""
    return float(abs(mean(outcome[_OFF])).max())


def _unworn_widths(study: Study, sweep: Sweep) -> Array:
    """Width of the unworn contact at each transition on each surface [µm]."""
    transitions = [(worn(sweep, "unworn"), row) for row in TABLE_4]
    widths: Array = 1e6 * on_surfaces(transitions, study.seeds(_SURFACES))["contact_width"]
    return widths


def _of_velocities(outcomes: _Outcomes, usual: _Outcome) -> dict[str, Any]:
    """Values for the report on errors of critical velocities, by name."""
    off = {
        kind: [float(np.mean(outcome[_OFF])) for outcome in variants.values()]
        for kind, variants in outcomes.items()
    }
    lengths = outcomes["correlation length"]
    good = [name for name, outcome in lengths.items() if _worst(outcome) < _GOOD]
    return {
        "shortest": off["correlation length"][0],
        "longest": off["correlation length"][-1],
        "lengths": ", ".join(good) or "none",
        "lays": off["lay"],
        "hursts": off["Hurst exponent"],
        "seeds": 100 * spread(usual[_OFF]).max(),
    }


def _of_widths(widths: Mapping[str, Array]) -> dict[str, Any]:
    """Errors of unworn contact widths by Ra, in words, and the Ra with the smallest error."""
    of_ra = {name: _width_off(row) for name, row in widths.items() if name != _SMOOTHER}
    return {
        "widths": ", ".join(f"{100 * value:+.0f} % with {name}" for name, value in of_ra.items()),
        "nearest": min(of_ra, key=lambda name: abs(of_ra[name])),
    }


def _width_off(widths: Array) -> float:
    """Mean relative error of the unworn widths [µm] over transitions."""
    return float(np.mean(mean(widths) / (1e6 * TABLE_4.unworn_width) - 1))


def _table(sweep: Sweep, outcomes: _Outcomes, widths: Mapping[str, Array]) -> pd.DataFrame:
    rows: list[tuple[str, ...]] = []
    for kind, variants in outcomes.items():
        rows.append((kind,))
        rows += [
            (
                f"  {name}",
                *cells([outcome[key].mean() for key in ("exceeded_celsius", "max_celsius")], ".0f"),
                *(f"{round(off) + 0:+d} %" for off in (100 * mean(outcome[_OFF])).tolist()),
                f"{100 * _width_off(widths[name]):+.0f} %" if kind == "Ra" else "",
            )
            for name, outcome in variants.items()
        ]
    velocities = (f"velocity at {load:g} N" for load in TABLE_4.normal_load)
    share = f"on {100 * sweep.conditions.criterion.share:g} % [°C]"
    return texts(("", share, "highest [°C]", *velocities, "unworn width"), rows)


@house_style
def _draw(sweep: Sweep, outcomes: _Outcomes) -> Figure:
    figure = Figure(figsize=(12.4, 6.4))
    rows = figure.subplots(2, len(outcomes), sharex="col", sharey="row")
    printed = TABLE_4.max_celsius.mean()
    critical = shown_in(known_critical_temperature(sweep.conditions), "°C")
    for number, (kind, variants) in enumerate(outcomes.items()):
        upper, lower = rows[0][number], rows[1][number]
        highest, exceeded, off = (
            np.array([mean(outcome[name]) for outcome in variants.values()])
            for name in ("max_celsius", "exceeded_celsius", _OFF)
        )
        joined = sum(", length" not in name for name in variants)
        _line(upper, highest, BLUE, "highest", joined)
        _line(upper, exceeded, GREEN, "exceeded on 10 %", joined)
        upper.axhline(printed, color=BLACK, ls="--", lw=1.2, label="printed, highest")
        upper.axhline(critical, color=GREY, ls=":", lw=1.2, label=f"critical, {critical:g} °C")
        upper.set_title({"lay": "lay, along × across sliding"}.get(kind, kind), loc="left")
        _line(lower, 100 * off, VERMILION, "critical velocity", joined)
        lower.axhline(0, color=BLACK, lw=1.0)
        lower.axhspan(-100 * _GOOD, 100 * _GOOD, color="#EEEEEE", zorder=0)
        lower.tick_params(axis="x", labelsize=9)
        names = [name.replace(", length ", ",\nlength ") for name in variants]
        lower.set_xticks(range(len(variants)), names)
        lower.set_xlim(-0.4, len(variants) - 0.6)
    rows[0][0].set_ylabel("at the measured\ntransitions [°C]")
    rows[1][0].set_ylabel("critical velocity against\nthe measured one [%]")
    rows[1][0].annotate(
        f" within {100 * _GOOD:g} %", (0.0, -100 * _GOOD), (0, 3), color=GREY, fontsize=9,
        xycoords=("axes fraction", "data"), textcoords="offset points", va="bottom",
    )  # fmt: skip
    label_ends(rows[0][-1])
    figure.supxlabel(
        "mean over transitions and surfaces; bars from the lowest transition to the highest",
        fontsize=10,
    )
    return figure


def _line(axes: Axes, values: Array, colour: str, label: str, joined: int) -> None:
    """Draw means and ranges of values (variant, transition), the first `joined` by a line."""
    middle, low, high = values.mean(axis=1), values.min(axis=1), values.max(axis=1)
    axes.errorbar(
        range(len(values)), middle, (middle - low, high - middle),
        color=colour, marker="o", ls="none", capsize=3, label=label,
    )  # fmt: skip
    axes.plot(range(joined), middle[:joined], color=colour)
