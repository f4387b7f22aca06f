"""How certain the transition is: over an ensemble of surfaces, and within the measured friction."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import xarray as xr

from pipeline.analysis.boundary import boundary
from pipeline.analysis.dataset import open_sweep
from pipeline.figures.diagram import diagram
from pipeline.sweep.model import Measurement
from tribo import InputError
from workflows.paper.report import Finding, Report, Table
from workflows.paper.study import Study

_SURFACES = 8
# Six loads and seven velocities place the boundary on each surface to a few parts in a thousand.
_LOADS = (200.0, 300.0, 400.0, 500.0, 600.0, 750.0)
_VELOCITIES = (0.8, 1.1, 1.5, 2.0, 2.7, 3.6, 4.8)
_SMALL = 0.05  # relative: a spread that the choice of a surface may have


@dataclass(frozen=True, slots=True)
class _Transition:
    """A measured transition, and the critical velocities at its load [m/s]."""

    load: float  # [N]
    measured: float
    velocities: list[float]  # by surface
    quantiles: tuple[float, float, float]  # over surfaces: lower end of the band, median, upper
    spread: float  # over surfaces, relative to the mean
    ends: tuple[float, float]  # median at the highest and at the lowest friction


def band(study: Study) -> Report:
    """The transition on each of several surfaces, and at the ends of the friction band."""
    scene = study.scene("irg_transition")
    if scene.friction_band is None:
        raise InputError(f"the scene {scene.name} must have a friction band")
    least, most = scene.friction_band
    seeds = tuple(study.seeds(_SURFACES))
    sweep = replace(
        scene, loads=_LOADS, velocities=_VELOCITIES, realizations=seeds, store_fields=False
    )
    store = study.results / f"{sweep.name}_surfaces_{sweep.preset}.zarr"
    study.sweep(sweep, store)
    ds = open_sweep(store).sel(realization=list(seeds))
    found = boundary(ds)
    ends = boundary(ds, friction=(most, least))

    transitions = [
        _transition(entry, *(each.sel(load=entry.normal_load) for each in (found, ends)))
        for entry in sorted(sweep.measured, key=lambda entry: -entry.normal_load)
    ]
    return Report(
        name="band",
        title=f"the transition over {len(seeds)} surfaces, and within the measured friction",
        table=_table(transitions, scene.friction_band),
        findings=(_on_surfaces(transitions), _on_friction(transitions, scene.friction_band)),
        notes=(
            f"Friction {sweep.conditions.friction:g} unless said otherwise. The friction band "
            "needs no simulation of its own. By hand: `irg run workflows/irg_transition.toml "
            f"--set sweep.realizations={len(seeds)} -o results/surfaces.zarr`.",
        ),
        data={
            "transitions": [
                {
                    "load": at.load,
                    "measured_velocity": at.measured,
                    "critical_velocities": at.velocities,
                    "at_ends_of_friction_band": list(at.ends),
                }
                for at in transitions
            ]
        },
        figure=diagram(ds),
    )


def _transition(entry: Measurement, found: xr.Dataset, ends: xr.Dataset) -> _Transition:
    low, median, high = found["critical_velocity_quantile"].values.tolist()
    slow, fast = ends["critical_velocity_quantile"].sel(quantile=0.5).values.tolist()
    return _Transition(
        load=entry.normal_load,
        measured=entry.velocity,
        velocities=found["critical_velocity"].values.tolist(),
        quantiles=(low, median, high),
        spread=float(found["critical_velocity_spread"] / found["critical_velocity_mean"]),
        ends=(slow, fast),
    )


def _table(transitions: Sequence[_Transition], friction: tuple[float, float]) -> Table:
    least, most = friction
    return Table(
        (
            "load [N]",
            "measured [m/s]",
            "median",
            "10 to 90 % of the surfaces",
            "spread",
            f"median at friction {most:g} to {least:g}",
        ),
        tuple(
            (
                f"{at.load:g}",
                f"{at.measured:g}",
                f"{at.quantiles[1]:.2f}",
                f"{at.quantiles[0]:.2f} to {at.quantiles[2]:.2f}",
                f"{100 * at.spread:.1f} %",
                f"{at.ends[0]:.2f} to {at.ends[1]:.2f}",
            )
            for at in transitions
        ),
    )


def _on_surfaces(transitions: Sequence[_Transition]) -> Finding:
    spreads = [at.spread for at in transitions]
    return Finding(
        "the part of the surface that is taken represents the whole",
        f"from surface to surface of one kind the critical velocity spreads by "
        f"{100 * min(spreads):.1f} to {100 * max(spreads):.1f} % (one standard deviation)",
        max(spreads) < _SMALL,
        "That is the chance in one surface of known structure; the structure itself, which is "
        "not published, moves it by more (see sensitivity).",
    )


def _on_friction(transitions: Sequence[_Transition], friction: tuple[float, float]) -> Finding:
    least, most = friction
    shifts = [end / at.quantiles[1] - 1 for at in transitions for end in at.ends]
    inside = sum(at.ends[0] <= at.measured <= at.ends[1] for at in transitions)
    return Finding(
        "all measured friction coefficients are in good agreement with 0.1",
        f"from {least:g} to {most:g} they move the critical velocity by "
        f"{100 * min(shifts):+.0f} to {100 * max(shifts):+.0f} %; {inside} of "
        f"{len(transitions)} measured transitions lie in between",
        inside == len(transitions),
        "That is more than the choice of a surface does.",
    )
