"""What a scene does not require and is not computed, and why."""

from __future__ import annotations

import math
from collections.abc import Iterator

from pipeline.sweep.model import Sweep
from pipeline.sweep.plan import step_count


def left_out(sweep: Sweep) -> Iterator[str]:
    """What would be computed or stored for another scene, and why not for this one; a line each."""
    nx, ny = sweep.grid.shape
    surfaces = len(sweep.simulated)
    steps = max(step_count(sweep, load) for load in sweep.loads)
    if sweep.is_plane:
        yield (
            f"the axis y: both bodies are smooth, so {nx} × 1 elements stand for "
            f"{nx} × {sweep.rows_per_element}"
        )
    increments = sum(1 for _ in sweep.loading.stations(max(sweep.loads), sweep.fidelity.increments))
    if steps < increments:
        yield f"{increments - steps} of {increments} steps: without wear no step needs the others"
    if sweep.wear is None:
        yield "wear: the scene has none"
    if not math.isfinite(sweep.hardness):
        yield "the bound on the pressure from above: no body has a hardness"
    still = sum(velocity == 0 for velocity in sweep.velocities)
    if not sweep.friction_heat:
        yield "heat: the friction coefficient is 0, so nothing gets warmer"
    elif still:
        yield f"heat at {still * len(sweep.loads) * surfaces} points: nothing moves there"
    interval = sweep.fidelity.temperature_interval
    if not interval and steps > 1 and sweep.friction_heat and not sweep.remembers_heat:
        yield f"temperatures at up to {steps - 1} steps before the last: asked for at the last only"
    if sweep.coarsening > 1:
        factor = sweep.coarsening
        yield (
            "the scene's own grid before a point's last step: the wear up to there is computed on "
            f"{nx // factor} × {ny // factor} elements, unless hardly any touch"
        )
    if not sweep.store_fields:
        megabytes = 24e-6 * nx * ny * len(sweep.loads) * len(sweep.velocities) * surfaces
        yield f"fields: not asked for, which would take up to {megabytes:.0f} MB"
