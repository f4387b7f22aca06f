"""A load record made from the paper's description of its own, which is not published."""

from __future__ import annotations

import numpy as np

from tribo.types import Array
from workflows.paper.printed import LOADING_RATE


def synthetic_record(
    load: float = 602.0,
    rate: float = LOADING_RATE,
    rounding: float = 0.2,
    noise: float = 1.0,
    onset: float = 0.3,
    seed: int = 0,
) -> str:
    r"""A load record as the paper describes its own, as CSV.

    A ramp that the compliance of the rig rounds off at both ends, as a lag of first order does,
    and the noise of a load cell.

    Parameters
    ----------
    load : float
        Load at the end [N].
    rate : float
        Rate at which the load grows [N/s].
    rounding : float
        Time constant of the lag [s].
    noise : float
        Standard deviation [N]; the paper's load cell is good to 2 N, taken as two of these.
    onset : float
        Time at which the pin touches the disk [s].
    seed : int
        Seed of the noise.

    Examples
    --------
    >>> print(*synthetic_record().splitlines()[4:7], sep="\n")
    time [s],normal load [N]
    0.00,0.1
    0.02,-0.1
    """
    t = np.arange(0.0, 6.0, 0.02)

    def lagging(s: Array) -> Array:
        s = np.maximum(s, 0.0)
        risen: Array = rate * (s - rounding * -np.expm1(-s / rounding))
        return risen

    F = lagging(t - onset) - lagging(t - onset - load / rate)
    F += noise * np.random.default_rng(seed).standard_normal(len(t))
    head = (
        "# Synthetic: the record of Fig. 8 of Bosman & de Rooij is not published as numbers. Made\n"
        f"# from their description by workflows.paper: {rate:g} N/s to {load:g} N from {onset:g} s "
        f"on,\n# rounded off by a lag of {rounding:g} s, with a noise of {noise:g} N "
        "(standard deviation).\n#\n"
    )
    rows = "\n".join(f"{time:.2f},{value:.1f}" for time, value in zip(t, F, strict=True))
    return f"{head}time [s],normal load [N]\n{rows}\n"
