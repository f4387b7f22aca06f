"""Fig. 10: the transition diagram, computed, with the measured transitions."""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

import xarray as xr

from pipeline.analysis.boundary import boundary
from pipeline.analysis.dataset import open_sweep
from pipeline.figures.diagram import diagram
from pipeline.sweep.model import Measurement, Sweep
from workflows.paper.report import Finding, Report, Table
from workflows.paper.study import Study

_GOOD = 0.15  # relative: what this project holds itself to


class _Crossing(NamedTuple):
    """A measured transition and the boundary velocities computed at its load [m/s]."""

    measured: Measurement
    at_scene_friction: float
    at_own_friction: float

    @property
    def off(self) -> float:
        """Relative error of the velocity at the scene's friction."""
        return self.at_scene_friction / self.measured.velocity - 1

    @property
    def off_at_own_friction(self) -> float:
        """Relative error of the velocity at the measured friction."""
        return self.at_own_friction / self.measured.velocity - 1


def fig10(study: Study) -> Report:
    """The diagram of the paper's system, from its store or computed into it."""
    sweep = study.scene("irg_transition")
    name = sweep.name if study.preset is None else f"{sweep.name}_{study.preset}"
    store = study.results / f"{name}.zarr"
    outcome = study.sweep(sweep, store)
    ds = open_sweep(store)
    crossings = _crossings(ds, sweep)
    failed = [f"{len(outcome.failed)} points failed and are left out."] if outcome.failed else []
    return Report(
        name="fig10",
        title="the transition diagram of the paper's system",
        table=_table(crossings, sweep.conditions.friction),
        findings=(_on_velocities(crossings, sweep.conditions.friction),),
        notes=(
            "The paper prints no numbers of the curve; the comparison is with Table 4.",
            f"{outcome.total} points, on {len(sweep.loads)} loads and {len(sweep.velocities)} "
            "velocities; those that the store holds already are not computed again.",
            *failed,
        ),
        data={
            "transitions": [
                {
                    "load": measured.normal_load,
                    "measured_velocity": measured.velocity,
                    "critical_velocity": at_scene_friction,
                    "measured_friction": measured.friction,
                    "critical_velocity_at_measured_friction": at_own_friction,
                }
                for measured, at_scene_friction, at_own_friction in crossings
            ],
            "computed": outcome.computed,
            "points": outcome.total,
        },
        figure=diagram(ds),
    )


def _crossings(ds: xr.Dataset, sweep: Sweep) -> list[_Crossing]:
    def critical(load: float, friction: float | None = None) -> float:
        return float(boundary(ds, friction=friction)["critical_velocity"].sel(load=load))

    return [
        _Crossing(entry, critical(entry.normal_load), critical(entry.normal_load, entry.friction))
        for entry in sweep.measured
    ]


def _table(crossings: Sequence[_Crossing], friction: float) -> Table:
    return Table(
        ("load [N]", "measured [m/s]", f"friction {friction:g}", "off", "measured friction", "off"),
        tuple(
            (
                f"{each.measured.normal_load:g}",
                f"{each.measured.velocity:g}",
                f"{each.at_scene_friction:.2f}",
                f"{100 * each.off:+.0f} %",
                f"{each.at_own_friction:.2f}",
                f"{100 * each.off_at_own_friction:+.0f} %",
            )
            for each in crossings
        ),
    )


def _on_velocities(crossings: Sequence[_Crossing], friction: float) -> Finding:
    off = [each.off for each in crossings]
    low = sum(value < 0 for value in off)
    return Finding(
        "good agreement between the measured transitions and those calculated at friction "
        f"{friction:g}",
        f"the computed velocities are {100 * min(off):+.0f} to {100 * max(off):+.0f} % off the "
        f"measured ones, {low} of {len(off)} too low",
        max(map(abs, off)) < _GOOD,
        "Nothing is fitted to them; the correlation length of the roughness, which the paper "
        "does not publish, moves the whole curve (see sensitivity).",
    )
