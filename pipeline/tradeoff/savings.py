"""Parts of a computation that a scene does not need, with the reason."""

from __future__ import annotations

import math
from collections.abc import Iterator

from pipeline.sweep.model import Sweep
from pipeline.sweep.plan import step_count


def savings(sweep: Sweep) -> Iterator[str]:
    """Say in a line each which work is saved that another scene would need, and why."""
    nx, ny = sweep.grid.shape
    steps = max(step_count(sweep, load) for load in sweep.loads)
    if sweep.is_plane:
        rows = sweep.rows_per_element
        yield f"the axis y, since both bodies are smooth ({nx} × 1 elements, not {nx} × {rows})"
    increments = sum(1 for _ in sweep.loading.stations(max(sweep.loads), sweep.fidelity.increments))
    if steps < increments:
        yield f"{increments - steps} of {increments} steps, since nothing wears between them"
    if sweep.wear is None:
        yield "wear, since the scene has no table [wear]"
    if not math.isfinite(sweep.hardness):
        yield "the upper bound on the pressure, since no body has a hardness"
    still = sum(velocity == 0 for velocity in sweep.velocities)
    if not sweep.friction_heat:
        yield "heat, since the friction coefficient is 0"
    elif still:
        points = still * len(sweep.loads) * len(sweep.variants)
        yield f"heat at {points} points, since nothing moves there"
    interval = sweep.fidelity.temperature_interval
    if not interval and steps > 1 and sweep.friction_heat and not sweep.remembers_heat:
        yield f"temperatures before the last step (up to {steps - 1} a point)"
    if sweep.coarsening > 1:
        factor = sweep.coarsening
        yield f"wear before the last step on a coarser grid ({nx // factor} × {ny // factor})"
    if not sweep.store_fields:
        megabytes = 24e-6 * nx * ny * len(sweep.loads) * sweep.ramps
        yield f"fields, since the scene does not ask for them (up to {megabytes:.0f} MB)"
