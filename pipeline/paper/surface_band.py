"""How certain the transition is: over an ensemble of surfaces, and within the measured friction."""

from __future__ import annotations

from dataclasses import replace

from pipeline.analysis.boundary import boundary
from pipeline.analysis.dataset import open_sweep
from pipeline.figures.diagram import diagram
from pipeline.paper.report import Finding, Report, Table
from pipeline.paper.study import Study
from pipeline.run.sweep import run_sweep
from tribo import InputError

_SURFACES = 8
# Six loads and seven velocities place the boundary on each surface to a few parts in a thousand.
_LOADS = (200.0, 300.0, 400.0, 500.0, 600.0, 750.0)
_VELOCITIES = (0.8, 1.1, 1.5, 2.0, 2.7, 3.6, 4.8)
_SMALL = 0.05  # relative: a spread that the choice of a surface may have


def band(study: Study) -> Report:
    """The transition on each of several surfaces, and at the ends of the friction band."""
    scene = study.scene("irg_transition", usual_preset="standard")
    if scene.friction_band is None:
        raise InputError(f"the scene {scene.name} must have a friction band")
    least, most = scene.friction_band
    seeds = tuple(study.seeds(_SURFACES))
    sweep = replace(
        scene, loads=_LOADS, velocities=_VELOCITIES, realizations=seeds, store_fields=False
    )
    store = study.results / f"{sweep.name}_surfaces_{sweep.preset}.zarr"
    study.tell(f"the sweep in {store}, what is there already included")
    run_sweep(sweep, store, workers=study.workers)
    ds = open_sweep(store).sel(realization=list(seeds))
    found = boundary(ds)
    ends = boundary(ds, friction=(most, least))

    rows, data, spreads, shifts, inside = [], [], [], [], 0
    for entry in sorted(sweep.measured, key=lambda entry: -entry.normal_load):
        at, at_ends = (result.sel(load=entry.normal_load) for result in (found, ends))
        low, median, high = at["critical_velocity_quantile"].values.tolist()
        slow, fast = at_ends["critical_velocity_quantile"].sel(quantile=0.5).values.tolist()
        spreads.append(float(at["critical_velocity_spread"] / at["critical_velocity_mean"]))
        shifts += [slow / median - 1, fast / median - 1]
        inside += slow <= entry.velocity <= fast
        rows.append((
            f"{entry.normal_load:g}", f"{entry.velocity:g}", f"{median:.2f}",
            f"{low:.2f} to {high:.2f}", f"{100 * spreads[-1]:.1f} %", f"{slow:.2f} to {fast:.2f}",
        ))  # fmt: skip
        data.append({
            "load": entry.normal_load,
            "measured_velocity": entry.velocity,
            "critical_velocities": at["critical_velocity"].values.tolist(),
            "at_ends_of_friction_band": [slow, fast],
        })  # fmt: skip
    findings = (
        Finding(
            "the part of the surface that is taken represents the whole",
            f"from surface to surface of one kind the critical velocity spreads by "
            f"{100 * min(spreads):.1f} to {100 * max(spreads):.1f} % (one standard deviation)",
            max(spreads) < _SMALL,
            "That is the chance in one surface of known structure; the structure itself, which is "
            "not published, moves it by more (see sensitivity).",
        ),
        Finding(
            "all measured friction coefficients are in good agreement with 0.1",
            f"from {least:g} to {most:g} they move the critical velocity by "
            f"{100 * min(shifts):+.0f} to {100 * max(shifts):+.0f} %; {inside} of "
            f"{len(sweep.measured)} measured transitions lie in between",
            inside == len(sweep.measured),
            "That is more than the choice of a surface does.",
        ),
    )
    return Report(
        name="band",
        title=f"the transition over {len(seeds)} surfaces, and within the measured friction",
        table=Table(
            (
                "load [N]",
                "measured [m/s]",
                "median",
                "10 to 90 % of the surfaces",
                "spread",
                f"median at friction {most:g} to {least:g}",
            ),
            tuple(rows),
        ),
        findings=findings,
        notes=(
            f"Friction {sweep.conditions.friction:g} unless said otherwise. The friction band "
            "needs no simulation of its own. By hand: `irg run workflows/irg_transition.toml "
            f"--preset standard --set sweep.realizations={len(seeds)} -o results/surfaces.zarr`.",
        ),
        data={"transitions": data},
        figure=diagram(ds),
    )
