"""Fig. 10: the transition diagram, computed, with the measured transitions."""

from __future__ import annotations

import math

import numpy as np
import xarray as xr
from matplotlib.figure import Figure

from pipeline import boundary
from pipeline.figures.diagram import COMPUTED, diagram
from pipeline.figures.style import GREEN, HALO, fitted

from .recomputed import Recomputation, texts
from .study import Study
from .transitions import worn

ACCURACY = 0.03  # of the velocities, as of `make diagram`
_GOOD = 0.1  # relative deviation that agrees, as in report.agree


def fig10(study: Study) -> Recomputation:
    """Report on the transition diagram of the paper's system, which is computed if needed.

    It is that of a specimen of several surface realizations, as `make diagram` computes it.
    """
    sweep = study.scene("irg_transition", {"sweep.realizations": 1, "without": ["friction.band"]})
    name = sweep.name if study.preset is None else f"{sweep.name}_{study.preset}"
    plane, _ = study.sweep(sweep, name)
    outcome, ds = study.sweep(sweep, name, ACCURACY)
    # Without the oil, whose film would carry too much of the load between such smooth contacts.
    dry = worn(sweep, "local").changed("oil", None)
    _, ds_local = study.sweep(dry, f"{name}_local")
    by_local_wear = boundary(ds_local)

    def critical(load: float, friction: float | None = None) -> float:
        return float(boundary(ds, friction=friction)["critical_velocity"].sel(load=load))

    rows, transitions, off, local = [], [], [], []
    for entry in sweep.tests:
        load, measured = entry.normal_load, entry.velocity
        friction = entry.case.conditions.friction
        pair = critical(load), critical(load, friction)
        errors = [velocity / measured - 1 for velocity in pair]
        off.append(errors[0])
        local.append(float(by_local_wear["critical_velocity"].sel(load=load)) / measured - 1)
        cells = [
            text
            for velocity, error in zip(pair, errors, strict=True)
            for text in (f"{velocity:.2f}", f"{100 * error:+.0f} %")
        ]
        rows.append((f"{load:g}", f"{measured:g}", *cells))
        transitions.append(
            {
                "load": load,
                "measured_velocity": measured,
                "critical_velocity": pair[0],
                "measured_friction": friction,
                "critical_velocity_at_measured_friction": pair[1],
                "off_by_local_wear": local[-1] if math.isfinite(local[-1]) else None,
            }
        )
    failed = len(outcome.failed)
    values = {
        "friction": sweep.conditions.friction,
        "off": off,
        "local": ", ".join(
            f"{100 * error:+.0f} % off at {load} N"
            if math.isfinite(error)
            else f"no transition up to {ds_local['velocity'].values[-1]:g} m/s at {load} N"
            for error, (load, *_) in zip(local, rows, strict=True)
        ),
        "realizations": ds.sizes["realization"],
        "failed": f"{failed} points failed and are left out." if failed else "",
    }
    columns = ("load [N]", "measured [m/s]", f"friction {sweep.conditions.friction:g}", "off")
    return Recomputation.from_values(
        "fig10",
        values,
        verdicts={
            name: all(abs(error) < _GOOD for error in errors)  # False for nan
            for name, errors in (("velocities", off), ("local", local))
        },
        table=texts((*columns, "measured friction", "off"), rows),
        data={
            "transitions": transitions,
            "computed": plane.computed + outcome.computed,
            "points": outcome.done,
            "realizations": ds.sizes["realization"],
        },
        figure=_draw(ds, by_local_wear),
    )


def _draw(ds: xr.Dataset, crossings: xr.Dataset) -> Figure:
    """Diagram without its title, caption and dots; with the boundary by local wear, Eq. (26)."""
    with fitted(plain=True):
        figure = diagram(ds, {})
    for mark in [line for line in figure.axes[0].lines if line.get_gid() == "simulated"]:
        mark.remove()
    (line,) = (text for text in figure.legends[0].get_texts() if text.get_text() == COMPUTED)
    line.set_text("computed boundary, swept wear")
    axes, loads = figure.axes[0], crossings["load"].values
    velocities = crossings["critical_velocity"].values
    known = np.isfinite(velocities)
    for text in axes.texts:  # away from the line of local wear
        if text.get_gid() == "region" and text.get_text().startswith("severe"):
            (x, y), right, top = text.get_position(), axes.get_xlim()[1], axes.get_ylim()[1]
            text.set_position(((x + right) / 2, (y + top) / 2))
    axes.plot(velocities[known], loads[known], color=GREEN, ls="-.", lw=1.8, gid="local wear")
    axes.annotate(
        "local wear" if known.any() else "local wear: mild throughout",
        (velocities[known].max(), loads[known].min()) if known.any() else (0.98, 0.9),
        xytext=(0, -5), textcoords="offset points", ha="right", va="top", fontsize=9, color=GREEN,
        xycoords="data" if known.any() else "axes fraction", linespacing=1.0, path_effects=HALO,
    )  # fmt: skip
    return figure
