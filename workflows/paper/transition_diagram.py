"""Fig. 10: the transition diagram, computed, with the measured transitions."""

from __future__ import annotations

from pipeline.analysis.boundary import boundary
from pipeline.figures.diagram import diagram
from workflows.paper.report import Report, Table
from workflows.paper.study import Study

_GOOD = 0.15  # relative: what this project holds itself to


def fig10(study: Study) -> Report:
    """The diagram of the paper's system, from its store or computed into it."""
    sweep = study.scene("irg_transition")
    name = sweep.name if study.preset is None else f"{sweep.name}_{study.preset}"
    outcome, ds = study.sweep(sweep, name)

    def critical(load: float, friction: float | None = None) -> float:
        return float(boundary(ds, friction=friction)["critical_velocity"].sel(load=load))

    computed = [
        (critical(entry.normal_load), critical(entry.normal_load, entry.friction))
        for entry in sweep.measured
    ]
    transitions = list(zip(sweep.measured, computed, strict=True))
    off = [velocity / entry.velocity - 1 for entry, (velocity, _) in transitions]
    values = {
        "friction": sweep.conditions.friction,
        "off": off,
        "low": sum(value < 0 for value in off),
        "number": len(off),
        "points": outcome.total,
        "loads": len(sweep.loads),
        "velocities": len(sweep.velocities),
        "failed": f"{len(outcome.failed)} points failed and are left out."
        if outcome.failed
        else "",
    }
    return Report.of(
        "fig10",
        values,
        verdicts={
            "velocities": max(map(abs, off)) < _GOOD,
        },
        table=Table(
            (
                *("load [N]", "measured [m/s]", f"friction {sweep.conditions.friction:g}", "off"),
                *("measured friction", "off"),
            ),
            tuple(
                (
                    *(f"{value:g}" for value in (entry.normal_load, entry.velocity)),
                    *(
                        text
                        for velocity in pair
                        for text in (
                            f"{velocity:.2f}",
                            f"{100 * (velocity / entry.velocity - 1):+.0f} %",
                        )
                    ),
                )
                for entry, pair in transitions
            ),
        ),
        data={
            "transitions": [
                {
                    "load": entry.normal_load,
                    "measured_velocity": entry.velocity,
                    "critical_velocity": at_scene_friction,
                    "measured_friction": entry.friction,
                    "critical_velocity_at_measured_friction": at_measured_friction,
                }
                for entry, (at_scene_friction, at_measured_friction) in transitions
            ],
            "computed": outcome.computed,
            "points": outcome.total,
        },
        figure=diagram(ds),
    )
