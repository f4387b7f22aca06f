"""Two viscosities of an oil from what its data sheet gives: an index, or more than two."""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np

from tribo.errors import InputError

# ASTM D2270, equations for L and H by the viscosity Y at 100 °C [mm²/s]: the end of a range of Y,
# and the factors of Y², Y and 1 of both. They join within 0.2 % at the ends of the ranges and
# agree with tabulated values within 0.1 %.
_EQUATIONS = np.array(
    [
        [3.8, 1.14673, 1.7576, -0.109, 0.84155, 1.5521, -0.077],
        [4.4, 3.38095, -15.4952, 33.196, 0.78571, 1.7929, -0.183],
        [5.0, 2.5, -7.2143, 13.812, 0.82143, 1.5679, 0.119],
        [6.4, 0.101, 16.635, -45.469, 0.04985, 9.1613, -18.557],
        [7.0, 3.35714, -23.5643, 78.466, 0.22619, 7.7369, -16.656],
        [7.7, 0.01191, 21.475, -72.87, 0.79762, -0.7321, 14.61],
        [9.0, 0.41858, 16.1558, -56.04, 0.05794, 10.5156, -28.24],
        [12.0, 0.88779, 7.5527, -16.6, 0.26665, 6.7015, -10.81],
        [15.0, 0.7672, 10.7972, -38.18, 0.20073, 8.4658, -22.49],
        [18.0, 0.97305, 5.3135, -2.2, 0.28889, 5.9741, -4.93],
        [22.0, 0.97256, 5.25, -0.98, 0.24504, 7.416, -16.73],
        [28.0, 0.91413, 7.4759, -21.82, 0.20323, 9.1267, -34.23],
        [40.0, 0.87031, 9.7157, -50.77, 0.18411, 10.1015, -46.75],
        [55.0, 0.84703, 12.6752, -133.31, 0.17029, 11.4866, -80.62],
        [70.0, 0.85921, 11.1009, -83.19, 0.1713, 11.368, -76.94],
        [math.inf, 0.83531, 14.6731, -216.246, 0.16841, 11.8493, -96.947],
    ]
)
_LEAST, _MOST = 2.0, 500.0  # mm²/s at 100 °C, in which the index is known


def viscosity_index(cold: float, warm: float) -> float:
    """Viscosity index by the kinematic viscosities at 40 and 100 °C [m²/s] (ASTM D2270).

    Examples
    --------
    >>> f"{viscosity_index(73.3e-6, 8.86e-6):.0f}, {viscosity_index(22.83e-6, 5.05e-6):.0f}"
    '92, 156'
    """
    U, Y = 1e6 * cold, 1e6 * warm
    row = _EQUATIONS[np.searchsorted(_EQUATIONS[:, 0], Y)]
    L, H = (float(np.polyval(factors, Y)) for factors in (row[1:4], row[4:]))
    if U >= H:
        return 100 * (L - U) / (L - H)
    return 100 + (10 ** (math.log10(H / U) / math.log10(Y)) - 1) / 0.00715


def warm_viscosity(cold: float, index: float) -> float:
    """Kinematic viscosity at 100 °C of an oil of a viscosity at 40 °C and an index [m²/s].

    Parameters
    ----------
    cold : float
        Kinematic viscosity at 40 °C [m²/s].
    index : float
        Viscosity index by ASTM D2270.

    Raises
    ------
    InputError
        If no viscosity at 100 °C from 2 to 500 mm²/s has that index.

    Examples
    --------
    >>> f"{1e6 * warm_viscosity(220e-6, 95):.2f} mm²/s"
    '18.75 mm²/s'
    """
    from scipy.optimize import brentq

    def off(warm: float) -> float:
        return viscosity_index(cold, warm) - index

    low, high = 1e-6 * _LEAST, min(1e-6 * _MOST, 0.9 * cold)
    if not (low < high and off(low) < 0 < off(high)):
        raise InputError(
            f"no oil of {1e6 * cold:g} mm²/s at 40 °C has a viscosity index of {index:g}; give the "
            "viscosity at 100 °C"
        )
    return float(brentq(off, low, high))


def viscosity_line(
    temperatures: Sequence[float], viscosities: Sequence[float]
) -> tuple[tuple[float, float], float]:
    """Viscosities at the first and the last temperature by the line of ASTM D341 [m²/s].

    log log(ν + 0.7) is fitted linearly in log T, with ν [mm²/s] and T [K]; two viscosities are
    returned as given.

    Parameters
    ----------
    temperatures : sequence of float
        Temperatures, at least two, rising [K].
    viscosities : sequence of float
        Kinematic viscosity at each of them [m²/s].

    Returns
    -------
    ends : tuple of float
        Kinematic viscosity at the first and the last temperature [m²/s].
    beside : float
        The most by which the line differs from a viscosity, relative to it.

    Raises
    ------
    InputError
        If the temperatures do not rise, or a viscosity is not above 0.3 mm²/s.

    Examples
    --------
    >>> ends, beside = viscosity_line((313.15, 353.15, 373.15), (100e-6, 19.6e-6, 11.1e-6))
    >>> f"{1e6 * ends[0]:.1f}, {1e6 * ends[1]:.2f} mm²/s; {beside:.1%}"
    '100.2, 11.13 mm²/s; 0.4%'
    """
    T, nu = np.array(temperatures, dtype=float), 1e6 * np.array(viscosities, dtype=float)
    if not np.all(np.diff(T, prepend=0.0) > 0):
        raise InputError(f"temperatures are {', '.join(f'{t:g}' for t in T)} K; they must rise")
    if not nu.min() > 0.3:
        raise InputError(f"viscosity is {1e-6 * nu.min():g} m²/s; it must be above 3e-07 m²/s")
    if len(nu) == 2:
        return (viscosities[0], viscosities[1]), 0.0
    x, y = np.log(T), np.log(np.log(nu + 0.7))
    line = np.exp(np.exp(np.polyval(np.polyfit(x, y, 1), x))) - 0.7
    return (float(1e-6 * line[0]), float(1e-6 * line[-1])), float(np.abs(line / nu - 1).max())
