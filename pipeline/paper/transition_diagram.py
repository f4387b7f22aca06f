"""Fig. 10: the transition diagram, computed, with the measured transitions."""

from __future__ import annotations

from pipeline.analysis.boundary import boundary
from pipeline.analysis.dataset import open_sweep
from pipeline.figures.diagram import diagram
from pipeline.paper.report import Finding, Report, Table
from pipeline.paper.study import Study
from pipeline.run.sweep import run_sweep

_GOOD = 0.15  # relative: what this project holds itself to


def fig10(study: Study) -> Report:
    """The diagram of the paper's system, from its store or computed into it."""
    sweep = study.scene("irg_transition")
    name = sweep.name if study.preset is None else f"{sweep.name}_{study.preset}"
    store = study.results / f"{name}.zarr"
    study.tell(f"the sweep in {store}, what is there already included")
    outcome = run_sweep(sweep, store, workers=study.workers)
    ds = open_sweep(store)

    def critical(load: float, friction: float | None = None) -> float:
        return float(boundary(ds, friction=friction)["critical_velocity"].sel(load=load))

    rows, off, data = [], [], []
    for entry in sweep.measured:
        at_common, at_own = critical(entry.normal_load), critical(entry.normal_load, entry.friction)
        off.append(at_common / entry.velocity - 1)
        rows.append(
            (
                f"{entry.normal_load:g}",
                f"{entry.velocity:g}",
                f"{at_common:.2f}",
                f"{100 * off[-1]:+.0f} %",
                f"{at_own:.2f}",
                f"{100 * (at_own / entry.velocity - 1):+.0f} %",
            )
        )
        data.append(
            {
                "load": entry.normal_load,
                "measured_velocity": entry.velocity,
                "critical_velocity": at_common,
                "measured_friction": entry.friction,
                "critical_velocity_at_measured_friction": at_own,
            }
        )
    friction = sweep.conditions.friction
    worst = max(off, key=abs)
    low = sum(value < 0 for value in off)
    findings = (
        Finding(
            "good agreement between the measured transitions and those calculated at friction "
            f"{friction:g}",
            f"the computed velocities are {100 * min(off):+.0f} to {100 * max(off):+.0f} % off the "
            f"measured ones, {low} of {len(off)} too low",
            abs(worst) < _GOOD,
            "Nothing is fitted to them; the correlation length of the roughness, which the paper "
            "does not publish, moves the whole curve (see sensitivity).",
        ),
    )
    failed = [f"{len(outcome.failed)} points failed and are left out."] if outcome.failed else []
    return Report(
        name="fig10",
        title="the transition diagram of the paper's system",
        table=Table(
            (
                "load [N]",
                "measured [m/s]",
                f"friction {friction:g}",
                "off",
                "measured friction",
                "off",
            ),
            tuple(rows),
        ),
        findings=findings,
        notes=(
            "The curve of the figure is not printed as numbers; compared is with Table 4.",
            f"{outcome.total} points, on {len(sweep.loads)} loads and {len(sweep.velocities)} "
            "velocities; those that the store holds already are not computed again.",
            *failed,
        ),
        data={"transitions": data, "computed": outcome.computed, "points": outcome.total},
        figure=diagram(ds),
    )
