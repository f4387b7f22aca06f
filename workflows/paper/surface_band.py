"""Certainty of the transition: over an ensemble of surfaces, and within the measured friction."""

from __future__ import annotations

import numpy as np

from pipeline import boundary
from pipeline.figures.diagram import diagram
from tribo import InputError

from .report import Report, cells, texts
from .study import Study

_SURFACES = 8
# Six loads and seven velocities place the boundary on each surface to a few parts in a thousand.
_LOADS = (200.0, 300.0, 400.0, 500.0, 600.0, 750.0)
_VELOCITIES = (0.8, 1.1, 1.5, 2.0, 2.7, 3.6, 4.8)
_SMALL = 0.05  # largest relative spread of critical velocities between surfaces


def band(study: Study) -> Report:
    """Report on the boundary on several surfaces, and at the lowest and highest friction."""
    scene = study.scene("irg_transition")
    if scene.friction_band is None:
        raise InputError(f"the scene {scene.name} must have a friction band")
    least, most = scene.friction_band
    seeds = tuple(study.seeds(_SURFACES))
    sweep = scene.changed("sweep.loads", [f"{load} N" for load in _LOADS])
    sweep = sweep.changed("sweep.velocities", [f"{velocity} m/s" for velocity in _VELOCITIES])
    sweep = sweep.changed("sweep.fields", False)
    sweep = sweep.changed("sweep.realizations", [*seeds])
    _, ds = study.sweep(sweep, f"{sweep.name}_surfaces_{study.preset or sweep.preset}")
    ds = ds.sel(realization=list(seeds))

    measured = sorted(sweep._measured, key=lambda entry: -entry.normal_load)
    loads = [entry.normal_load for entry in measured]
    specimen, *patches = (
        boundary(one)["critical_velocity"].sel(load=loads).values
        for one in (ds, *(ds.sel(realization=[seed]) for seed in seeds))
    )
    velocities = np.transpose(patches)
    spreads = velocities.std(axis=1, ddof=1) / velocities.mean(axis=1)
    at_ends = boundary(ds, friction=[most, least])["critical_velocity"].sel(load=loads)
    ends = at_ends.transpose("load", ...).values
    within = np.quantile(velocities, (0.1, 0.9), axis=1).T
    rows = list(zip(measured, specimen, within, spreads, ends, strict=True))
    inside = sum(slow <= entry.velocity <= fast for entry, *_, (slow, fast) in rows)
    values = {
        "surfaces": len(seeds),
        "friction": sweep.conditions.friction,
        "least": least,
        "most": most,
        "spreads": spreads,
        "shifts": (ends / specimen[:, None] - 1).ravel(),
        "inside": inside,
        "number": len(measured),
    }
    columns = ("load [N]", "measured [m/s]", "all patches", "10 to 90 % of the patches", "spread")
    return Report.of(
        "band",
        values,
        verdicts={
            "surfaces": max(spreads) < _SMALL,
            "friction": inside == len(measured),
        },
        table=texts(
            (*columns, f"at friction {most:g} to {least:g}"),
            [
                (
                    *cells((entry.normal_load, entry.velocity), "g"),
                    f"{middle:.2f}",
                    f"{low:.2f} to {high:.2f}",
                    f"{100 * spread:.1f} %",
                    f"{slow:.2f} to {fast:.2f}",
                )
                for entry, middle, (low, high), spread, (slow, fast) in rows
            ],
        ),
        data={
            "transitions": [
                {
                    "load": entry.normal_load,
                    "measured_velocity": entry.velocity,
                    "critical_velocities": on_surfaces.tolist(),
                    "at_ends_of_friction_band": pair.tolist(),
                }
                for entry, on_surfaces, pair in zip(measured, velocities, ends, strict=True)
            ]
        },
        figure=diagram(ds, {}),
    )
