"""Unknown inputs of samples, and their distributions by SciPy."""

import math
from dataclasses import replace

from scipy import stats

from pipeline.uncertain.unknown import Unknown

CRITICAL = Unknown("temperature.critical", "normal", (418.15, 8.0), "K")
RATE = Unknown("wear.specific_wear_rate", "log-normal", (1.2e-15, 1.5), "m2 N-1")
FRICTION = Unknown("friction.coefficient", "normal", (0.1, 0.005))
LENGTH = Unknown("disk.roughness.correlation_length", "uniform", (3e-6, 6e-6), "m")
ALL = (CRITICAL, RATE, FRICTION, LENGTH)
JOINT = (CRITICAL, RATE, replace(FRICTION, correlated=((CRITICAL.path, 0.8),)), LENGTH)


def distribution_of(unknown):
    """SciPy distribution of an unknown input that is not a list of values."""
    first, second = unknown.parameters
    match unknown.kind:
        case "normal":
            return stats.norm(first, second)
        case "log-normal":
            return stats.lognorm(s=math.log(second), scale=first)
    return stats.uniform(first, second - first)
