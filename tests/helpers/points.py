"""Points of a sweep, simulated in this process."""

from pipeline.sweep import plan
from pipeline.sweep.plan import choose_stored_steps


def run_point(sweep, point, ramp_cache=None):
    """Simulate a point of a sweep, as a worker would."""
    return plan.run_point(
        sweep.case(point.case).scene, choose_stored_steps(sweep), point, ramp_cache
    )
