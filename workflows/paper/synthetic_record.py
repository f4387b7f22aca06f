"""Load record made from the paper's description of its unpublished record."""

from __future__ import annotations

import numpy as np

from tribo.types import Array

from .publication import LOADING_RATE

_LOAD = 602.0  # load at the end [N]
_ONSET = 0.3  # time at which the pin touches the disk [s]
_ROUNDING = 0.2  # time constant of a lag of first order, by the compliance of the rig [s]
_NOISE = 1.0  # [N]: the paper's load cell is good to 2 N, taken as two standard deviations


def synthetic_record() -> str:
    r"""Load record of a ramp, rounded at both ends and with the noise of a load cell.

    It is CSV as a data logger saves it where decimals have commas, with a number in each row.

    Examples
    --------
    >>> print(*synthetic_record().splitlines()[4:7], sep="\n")
    sample;time [s];normal load [N]
    0;0,00;0,1
    1;0,02;-0,1
    """
    t = np.arange(0.0, 6.0, 0.02)

    def lagging(s: Array) -> Array:
        s = np.maximum(s, 0.0)
        risen: Array = LOADING_RATE * (s - _ROUNDING * -np.expm1(-s / _ROUNDING))
        return risen

    F = lagging(t - _ONSET) - lagging(t - _ONSET - _LOAD / LOADING_RATE)
    F += _NOISE * np.random.default_rng(0).standard_normal(len(t))
    head = (
        "# Synthetic: the record of Fig. 8 of Bosman & de Rooij is not published as numbers. Made\n"
        f"# from their description by workflows.paper: {LOADING_RATE:g} N/s to {_LOAD:g} N from "
        f"{_ONSET:g} s on,\n# rounded off by a lag of {_ROUNDING:g} s, with a noise of "
        f"{_NOISE:g} N (standard deviation).\n#\n"
    )
    rows = (f"{n};{time:.2f};{value:.1f}" for n, (time, value) in enumerate(zip(t, F, strict=True)))
    table = "\n".join(rows).replace(".", ",")
    return f"{head}sample;time [s];normal load [N]\n{table}\n"
