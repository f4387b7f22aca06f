"""Mean spacing RSm of the ground disk: what it does to the transitions."""

from __future__ import annotations

import numpy as np
from matplotlib.figure import Figure

from pipeline import boundary
from pipeline.figures.style import BLACK, BLUE, GREEN, GREY, VERMILION, house_style
from pipeline.surface.mean_spacing import correlation_lengths
from tribo.types import Array

from .labels import label_ends
from .recomputed import Recomputation, cells, texts
from .study import Study

_SPACINGS = (20e-6, 30e-6, 40e-6, 60e-6)  # RSm [m], usual for grinding to this Ra
_SURFACES = 8
_LOADS = (200.0, 400.0, 600.0, 750.0)  # N
_VELOCITIES = (0.8, 1.1, 1.5, 2.1, 2.9, 3.9, 5.2)  # m/s, of which the rise is nearly a power
_ALLOWED = 0.1  # relative change of a velocity that is no difference, as in report.agree
_COLOURS = BLUE, GREEN, GREY, VERMILION


def spacing(study: Study) -> Recomputation:
    """Report on critical velocities with the correlation lengths of other mean spacings."""
    scene = study.scene("irg_transition")
    roughness = scene.source.entries["disk"]["roughness"]
    chosen = scene.scene.roughness.correlation_length[0]  # type: ignore[union-attr]
    ra, hurst = scene.scene.roughness.ra, roughness["hurst_exponent"]  # type: ignore[union-attr]
    fitted = [correlation_lengths(rsm, hurst, scene.scene.pixels.spacing)[0] for rsm in _SPACINGS]
    lengths = [chosen, *fitted]
    changes = {
        "without": ["tests", "sweep.fields"],
        "sweep.loads": [f"{load!r} N" for load in _LOADS],
        "sweep.velocities": [f"{velocity!r} m/s" for velocity in _VELOCITIES],
        "sweep.realizations": len(study.seeds(_SURFACES)),
        "sweep.steps": "end",
        "sweep.over": {"disk.roughness.correlation_length": [f"{1e6 * x:.4g} um" for x in lengths]},
    }
    preset = "" if study.preset is None else f"_{study.preset}"
    _, ds = study.sweep(study.scene("irg_transition", changes), f"spacing{preset}")
    axis = "disk_roughness_correlation_length"
    critical = boundary(ds)["critical_velocity"].transpose(axis, "load")
    velocities = critical.sel({axis: np.array(lengths)}, method="nearest").values
    change = velocities[1:] / velocities[0] - 1
    loads = critical["load"].values
    return Recomputation.from_values(
        "spacing",
        {
            "ra": 1e6 * ra,
            "surfaces": len(study.seeds(_SURFACES)),
            "hurst": hurst,
            "rsm": [1e6 * x for x in _SPACINGS],
            "lengths": [1e6 * x for x in fitted],
            "chosen": 1e6 * chosen,
            "lowest_load": loads[0],
            "at_lowest": change[[0, -1], 0],
            "highest_load": loads[-1],
            "at_highest": change[[0, -1], -1],
        },
        verdicts={"finish": bool(np.abs(change).max() < _ALLOWED)},
        table=texts(
            ("RSm [µm]", "correlation length [µm]", *(f"at {load:g} N" for load in loads)),
            [
                (f"{1e6 * rsm:g}", f"{1e6 * length:.1f}", *cells(row, "+.0f%"))
                for rsm, length, row in zip(_SPACINGS, fitted, change, strict=True)
            ],
        ),
        data={
            "load": loads,
            "mean_spacing": _SPACINGS,
            "correlation_length": fitted,
            "critical_velocity": velocities[1:],
            "critical_velocity_as_chosen": velocities[0],
        },
        figure=_draw(np.array(fitted), change, loads, chosen),
    )


@house_style
def _draw(lengths: Array, change: Array, loads: Array, chosen: float) -> Figure:
    figure = Figure(figsize=(7.4, 4.2))
    axes = figure.subplots()
    for load, row, colour in zip(loads, change.T, _COLOURS, strict=True):
        axes.plot(1e6 * lengths, 100 * row, "o-", color=colour, label=f"{load:g} N")
    axes.axhline(0, color=BLACK, lw=0.8)
    axes.plot(1e6 * chosen, 0, "D", color=BLACK, ms=7, gid="as chosen")
    ticks = zip(lengths, _SPACINGS, strict=True)
    axes.set_xscale("log")
    axes.set_xticks(
        1e6 * lengths, [f"{1e6 * x:.1f}\n(RSm {1e6 * rsm:g})" for x, rsm in ticks], minor=False
    )
    axes.set_xticks([], minor=True)
    axes.set(xlabel="correlation length (mean spacing RSm) [µm]", ylabel="critical velocity [%]")
    axes.set_title("change of the critical velocity", loc="left")
    label_ends(axes)
    return figure
