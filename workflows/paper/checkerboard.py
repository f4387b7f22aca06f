"""Fig. 2: the explicit loop of wear, whose increments are too long to be stable."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np
from matplotlib.figure import Figure

from pipeline import Sweep
from pipeline.figures.style import house_style
from tribo import Fidelity, Grid, InputError, Ramp, Scene, simulate
from tribo.types import Array

from .explicit_loop import EXPLICIT_LIMIT, explicit_loop, stiffness
from .publication import TABLE_4
from .recomputed import Recomputation, line, texts
from .resolution import draw_fields, neighbours_of
from .study import Study
from .transitions import label_of, worn

_INCREMENTS = 100  # up to the load of each test, as the paper states
_BLOCK = 2  # pixels along each side of an element of the paper
_DRAWN = Fidelity(pixels_per_element=_BLOCK, increments=_INCREMENTS)
"""Grid and increments of the pressure that is drawn."""
_POINT = TABLE_4[0]
_SCHEMES = "explicit (as published)", "implicit"


def fig2(study: Study) -> Recomputation:
    """Report on the steps of the explicit loop of Fig. 2, and on the checkerboard they leave."""
    sweep = worn(study.scene("table4"), "local")
    stiffnesses = np.array([_stiffness(sweep.scene, row) for row in TABLE_4])
    drawn = sweep.with_fidelity(_DRAWN)
    fields = {name: _pressure(drawn.scene, name) for name in study.stages(_SCHEMES)}
    neighbours = {name: neighbours_of(field) for name, field in fields.items()}
    explicit, stable = neighbours.values()
    needed = np.ceil(_INCREMENTS * stiffnesses / EXPLICIT_LIMIT)
    values = {
        "increments": _INCREMENTS,
        "limit": EXPLICIT_LIMIT,
        "stiffness": stiffnesses,
        "needed": needed,
        "explicit": explicit,
        "stable": stable,
        "load": _POINT.normal_load,
        "velocity": _POINT.velocity,
    }
    return Recomputation.from_values(
        "fig2",
        values,
        verdicts={
            "stable": bool((stiffnesses < EXPLICIT_LIMIT).all()),
            "checkerboard": abs(explicit - stable) < abs(stable) / 2,
        },
        table=texts(
            ("", *map(label_of, TABLE_4)),
            (
                line(f"k dS/λ_min with {_INCREMENTS} increments", stiffnesses, ".1f"),
                line("limit of stability", [EXPLICIT_LIMIT] * len(TABLE_4), "g"),
                line("increments needed", needed, ".0f"),
            ),
        ),
        data={"stiffness": stiffnesses, "increments_needed": needed, "neighbours": neighbours},
        figure=_draw(drawn, fields),
    )


def _stiffness(scene: Scene, row: Any) -> float:
    """Stiffness of an increment on the paper's grid, in the ramp to a transition of Table 4."""
    if not isinstance(scene.loading, Ramp):
        raise InputError("the scene table4 must have a ramp")
    (nx, ny), (dx, dy) = scene.pixels.shape, scene.pixels.spacing
    elements = (nx // _BLOCK, ny // _BLOCK), (_BLOCK * dx, _BLOCK * dy)
    grid = Grid(*elements, periodic=scene.pixels.periodic)
    duration = row.normal_load / scene.loading.rate
    return stiffness(scene, grid, row.velocity * duration / _INCREMENTS)


def _pressure(scene: Scene, scheme: str) -> Array:
    """Pressure at the end of the first test [Pa], by explicit or by implicit steps."""
    if scheme != "implicit":
        return explicit_loop(scene, _POINT.normal_load, _POINT.velocity)
    *_, state = simulate(scene, _POINT.normal_load, _POINT.velocity)
    return state.pressure


@house_style
def _draw(sweep: Sweep, fields: Mapping[str, Array]) -> Figure:
    figure = Figure(figsize=(10.4, 4.4))
    draw_fields(figure, sweep, fields, _INCREMENTS, "ab")
    return figure
