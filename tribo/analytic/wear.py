"""Worn depth, and width of the worn flat of a rigid pin."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import ArrayLike

from tribo.types import Array


def archard_wear_depth(
    specific_wear_rate: float, pressure: ArrayLike, sliding_distance: float
) -> Array:
    """Depth worn off by a constant pressure [m], of the shape of `pressure`.

    h = kpS with the specific wear rate k [m²/N], the pressure p [Pa] and the distance S [m]
    (Archard, J. Appl. Phys. 24, 1953).

    Examples
    --------
    >>> print(f"{archard_wear_depth(1.2e-15, 2e9, 0.0625):.2e} m")
    1.50e-07 m
    """
    return np.asarray(specific_wear_rate * np.asarray(pressure) * sliding_distance)


def worn_line_width(worn_area: float, radius: float) -> float:
    """Width of the flat worn on a rigid cylinder [m].

    w = (12RA)^⅓ with the worn area A [m²] of the cross-section, a segment of height w²/(8R), and
    the radius R [m]; w ≪ R.

    Examples
    --------
    The area of the segment is two thirds of its width times its height:

    >>> A, R = 8.3e-10, 2e-3
    >>> w = worn_line_width(A, R)
    >>> f"{w:.4e} m, {2 / 3 * w * w**2 / (8 * R) / A:.6f}"
    '2.7108e-04 m, 1.000000'
    """
    return float(np.cbrt(12 * radius * worn_area))


def worn_point_width(worn_volume: float, radius: float) -> float:
    """Width of the flat worn on a rigid ball [m].

    w = (64RV/π)^¼ with the worn volume V [m³], a cap of height w²/(8R), and the radius R [m];
    w ≪ R.

    Examples
    --------
    The volume of the cap is half of its base times its height:

    >>> V, R = 5e-15, 5e-3
    >>> w = worn_point_width(V, R)
    >>> f"{w:.4e} m, {math.pi / 8 * w**2 * w**2 / (8 * R) / V:.6f}"
    '1.5023e-04 m, 1.000000'
    """
    return math.sqrt(math.sqrt(64 * radius * worn_volume / math.pi))
