"""How much more one of two oils stands than the other, by what their tests leave together.

Body, surface and rig are shared, so that what is not known of them counts little in a difference.
"""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import asdict, dataclass
from typing import Any

import numpy as np

from pipeline.uncertain.answers import log_boundary
from pipeline.uncertain.inputs import CRITICAL
from pipeline.uncertain.posterior import Posterior
from tribo.types import Array


@dataclass(frozen=True, slots=True)
class Difference:
    """How much more the second of two sweeps has of a quantity.

    Attributes
    ----------
    what : str
        Quantity, in words.
    unit : str
        Unit: of a temperature K; 1 for the logarithm of a velocity.
    mean, sd : float
        Mean and standard deviation of the difference.
    interval : tuple of float
        Differences that 5, 50 and 95 % stay below.
    probability : float
        Probability that the second has more.

    Examples
    --------
    >>> Difference("critical temperature", "K", 12.0, 6.6, (1.1, 12.0, 22.9), 0.97).probability
    0.97
    """

    what: str
    unit: str
    mean: float
    sd: float
    interval: tuple[float, float, float]
    probability: float

    def as_dict(self) -> dict[str, Any]:
        """Return all fields by name."""
        return asdict(self)


def differences(posterior: Posterior) -> Iterator[Difference]:
    """Differences of the critical temperature and velocity of two sweeps; none of any other number.

    The velocity is that at a load in the middle of those that both sweeps have.
    """
    if len(posterior.ensembles) != 2:
        return
    inputs = [posterior.of_sweep(number).inputs for number in range(2)]
    pairs = list(zip(posterior.ensembles, inputs, strict=True))
    kelvins = [one.values(CRITICAL, of_sweep) for one, of_sweep in pairs]
    yield _difference(posterior, "critical temperature", "K", kelvins[1] - kelvins[0])
    low = max(float(one.loads[0]) for one in posterior.ensembles)
    high = min(float(one.loads[-1]) for one in posterior.ensembles)
    if low <= high:
        load = math.sqrt(low * high)
        first, second = (log_boundary(*pair, [load], with_error=False)[0][:, 0] for pair in pairs)
        yield _difference(posterior, f"critical velocity at {load:.3g} N", "1", second - first)


def _difference(posterior: Posterior, what: str, unit: str, values: Array) -> Difference:
    draws = posterior.draws
    mean = float(draws.mean(values))
    return Difference(
        what,
        unit,
        mean,
        math.sqrt(float(draws.mean((values - mean) ** 2))),
        draws.interval(values),
        float(draws.mean(np.where(values > 0, 1.0, 0.0))),
    )
