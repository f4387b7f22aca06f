"""Points of a sweep, simulated in this process."""

from pipeline.sweep import plan
from pipeline.sweep.plan import choose_stored_steps


def run_point(sweep, point, ramp_cache=None):
    """Simulate a point of a sweep, as a worker would."""
    case = sweep.case(point.case)
    return plan.run_point(
        case.scene, choose_stored_steps(sweep), point, ramp_cache, with_film=case.has_film
    )
