"""Parts of a computation that a scene does not need, with the reason."""

from __future__ import annotations

import math
from collections.abc import Iterator

from pipeline.sweep.model import Sweep
from pipeline.sweep.plan import step_count
from pipeline.sweep.stations import Stations


def savings(sweep: Sweep) -> Iterator[str]:
    """Say in a line each which work is saved that another scene would need, and why."""
    nx, ny = sweep.scene.grid.shape
    steps = max(step_count(sweep.scene, load) for load in sweep.plane.loads)
    if sweep.scene.is_plane:
        rows = sweep.scene.rows_per_element
        yield f"the axis y, since both bodies are smooth ({nx} × 1 elements, not {nx} × {rows})"
    increments = sum(
        1
        for _ in sweep.scene.loading.stations(
            max(sweep.plane.loads), sweep.scene.fidelity.increments
        )
    )
    if steps < increments:
        yield f"{increments - steps} of {increments} steps, since nothing wears between them"
    if sweep.scene.wear is None:
        yield "wear, since the scene has no table [wear]"
    if not math.isfinite(sweep.scene.hardness):
        yield "the upper bound on the pressure, since no body has a hardness"
    still = sum(velocity == 0 for velocity in sweep.plane.velocities)
    if not sweep.scene.friction_heat:
        yield "heat, since the friction coefficient is 0"
    elif still:
        points = still * len(sweep.plane.loads) * len(sweep.variants.names)
        yield f"heat at {points} points, since nothing moves there"
    is_end = Stations.of(sweep).interval is None
    if is_end and steps > 1 and sweep.scene.friction_heat and not sweep.scene.remembers_heat:
        yield f"temperatures before the last step (up to {steps - 1} a point)"
    if sweep.scene.coarsening > 1:
        factor = sweep.scene.coarsening
        yield f"wear before the last step on a coarser grid ({nx // factor} × {ny // factor})"
    if not sweep.record.fields:
        megabytes = 24e-6 * nx * ny * len(sweep.plane.loads) * sweep.ramps
        yield f"fields, since the scene does not ask for them (up to {megabytes:.0f} MB)"
