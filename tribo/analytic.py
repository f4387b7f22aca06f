"""Closed forms of smooth contacts: Hertz, Blok's flash temperature, and the worn flat of a pin.

None of them calls a solver. E* is `tribo.contact_modulus`. Equations of Hertz are those of Johnson,
*Contact Mechanics*, 1985.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np
import scipy
from numpy.typing import ArrayLike

from tribo.errors import real_array, require_not_negative, require_pair, require_positive
from tribo.types import Array

_BLOK_FACTOR = 1.111548  # c of `rolling_sliding_rise`


def hertz_line_half_width(load_per_length: float, radius: float, contact_modulus: float) -> float:
    """Half-width a of the contact between a cylinder and a plane [m].

    a = √(4PR/(πE*)) with the load per length P [N/m], the radius R [m] and the contact modulus E*
    [Pa] (Johnson, Eq. 4.43).

    Examples
    --------
    >>> f"{hertz_line_half_width(750 / 3.4e-3, 2e-3, 115.385e9):.4e} m"
    '6.9773e-05 m'
    """
    require_not_negative(load_per_length=load_per_length)
    require_positive(radius=radius, contact_modulus=contact_modulus)
    P, R, E = load_per_length, radius, contact_modulus
    return math.sqrt(4 * P * R / (math.pi * E))


def hertz_line_peak_pressure(
    load_per_length: float, radius: float, contact_modulus: float
) -> float:
    """Highest pressure p₀ between a cylinder and a plane [Pa].

    p₀ = √(PE*/(πR)) with the load per length P [N/m], the radius R [m] and the contact modulus E*
    [Pa] (Johnson, Eq. 4.45).

    Examples
    --------
    The pressure carries the load: P = πap₀/2.

    >>> P, R, E = 750 / 3.4e-3, 2e-3, 115.385e9
    >>> p0 = hertz_line_peak_pressure(P, R, E)
    >>> f"{p0:.4e} Pa, {math.pi / 2 * hertz_line_half_width(P, R, E) * p0 / P:.6f}"
    '2.0127e+09 Pa, 1.000000'
    """
    require_not_negative(load_per_length=load_per_length)
    require_positive(radius=radius, contact_modulus=contact_modulus)
    P, R, E = load_per_length, radius, contact_modulus
    return math.sqrt(P * E / (math.pi * R))


def hertz_point_radius(normal_load: float, radius: float, contact_modulus: float) -> float:
    """Radius a of the contact between a sphere and a plane [m].

    a = (3FR/(4E*))^⅓ with the load F [N], the sphere's radius R [m] and the contact modulus E* [Pa]
    (Johnson, Eq. 4.22).

    Examples
    --------
    >>> f"{hertz_point_radius(10.0, 10e-3, 115.385e9):.4e} m"
    '8.6624e-05 m'
    """
    require_not_negative(normal_load=normal_load)
    require_positive(radius=radius, contact_modulus=contact_modulus)
    F, R, E = normal_load, radius, contact_modulus
    return float(np.cbrt(3 * F * R / (4 * E)))


def hertz_point_peak_pressure(normal_load: float, radius: float, contact_modulus: float) -> float:
    """Highest pressure p₀ between a sphere and a plane [Pa].

    p₀ = (6FE*²/(π³R²))^⅓ with the load F [N], the sphere's radius R [m] and the contact modulus E*
    [Pa] (Johnson, Eq. 4.24).

    Examples
    --------
    The pressure carries the load: F = 2πa²p₀/3.

    >>> p0 = hertz_point_peak_pressure(10.0, 10e-3, 115.385e9)
    >>> a = hertz_point_radius(10.0, 10e-3, 115.385e9)
    >>> f"{p0:.4e} Pa, {2 * math.pi / 3 * a**2 * p0:.6f} N"
    '6.3631e+08 Pa, 10.000000 N'
    """
    require_not_negative(normal_load=normal_load)
    require_positive(radius=radius, contact_modulus=contact_modulus)
    F, R, E = normal_load, radius, contact_modulus
    return float(np.cbrt(6 * F * E**2 / (math.pi**3 * R**2)))


class HertzEllipse(NamedTuple):
    """Elastic contact between a body of two principal radii and a plane.

    Attributes
    ----------
    half_x, half_y : float
        Semi-axes along x and y [m].
    peak_pressure : float
        Highest pressure, p₀ [Pa].
    approach : float
        Approach of distant points, α [m].
    """

    half_x: float
    half_y: float
    peak_pressure: float
    approach: float


def hertz_ellipse(
    normal_load: float, radius_x: float, radius_y: float, contact_modulus: float
) -> HertzEllipse:
    """Elliptical contact between a body of two principal radii and a plane.

    The semi-axes a ≥ b, along the radii R_a and R_b, the highest pressure p₀ and the approach α
    follow from (Johnson, Eqs. 4.26 to 4.31)

        1/(2R_a) = p₀b/(3E*a²) R_D(0, κ², 1),   1/(2R_b) = p₀b/(3E*a²) R_D(0, 1, κ²),
        F = 2πp₀ab/3,   α = p₀b K(e)/E*,   κ = b/a,   e² = 1 − κ²,

    with the complete elliptic integral of the first kind K. Carlson's integral R_D replaces
    differences of complete elliptic integrals, which cancel near a circle.

    Parameters
    ----------
    normal_load : float
        F [N].
    radius_x, radius_y : float
        Radii of curvature along x and y [m]; the longer semi-axis lies along the larger radius.
    contact_modulus : float
        E* [Pa].

    Returns
    -------
    HertzEllipse
        Semi-axes along x and y [m], highest pressure p₀ [Pa] and approach of distant points α [m].

    Examples
    --------
    Equal radii make a circle:

    >>> print("{:.4e} {:.4e} {:.4e} {:.4e}".format(*hertz_ellipse(10.0, 10e-3, 10e-3, 115.385e9)))
    8.6624e-05 8.6624e-05 6.3631e+08 7.5037e-07
    """
    require_positive(normal_load=normal_load, contact_modulus=contact_modulus)
    require_positive(radius_x=radius_x, radius_y=radius_y)
    F, E = normal_load, contact_modulus
    larger_radius, smaller_radius = max(radius_x, radius_y), min(radius_x, radius_y)
    elliprd = scipy.special.elliprd

    def excess(log_ratio: float) -> float:
        """Computed minus given ln(R_a/R_b), for a trial value `log_ratio` of ln(b/a)."""
        square = math.exp(2 * log_ratio)
        ratio = elliprd(0.0, 1.0, square) / elliprd(0.0, square, 1.0)
        return float(np.log(ratio)) - math.log(larger_radius / smaller_radius)

    # b/a lies between the inverse of the ratio of the radii and 1.
    flattest = -math.log(larger_radius / smaller_radius)
    log_ratio = scipy.optimize.brentq(excess, flattest, 0.0, xtol=1e-15) if flattest else 0.0
    k = math.exp(log_ratio)
    a = float(np.cbrt(F * elliprd(0.0, k**2, 1.0) * larger_radius / (math.pi * E)))
    p0 = 3 * F / (2 * math.pi * k * a**2)
    approach = p0 * k * a * float(scipy.special.ellipkm1(k**2)) / E
    half_x, half_y = (a, k * a) if radius_x >= radius_y else (k * a, a)
    return HertzEllipse(half_x, half_y, p0, approach)


class HertzContact(NamedTuple):
    """Elastic contact of a smooth pin and a plane, the result of `hertz_contact`.

    It has half the width along x [m], the highest pressure [Pa], and the width along y divided by
    the width along x, which is infinite under a cylinder.
    """

    half_width: float  # along x [m]
    peak_pressure: float  # p₀ [Pa]
    aspect: float  # length along y over the width; infinite under a cylinder


def hertz_contact(
    normal_load: float,
    contact_modulus: float,
    radius: float,
    length: float | None = None,
    crown_radius: float | None = None,
) -> HertzContact:
    """Hertzian contact of a ball, of a cylinder with `length`, or of a pin with `crown_radius`.

    The pin is a ball if neither is given; with a `crown_radius`, `length` is not used. Sizes are in
    metres; `radius` lies in the plane x, z, and `crown_radius` in the plane y, z. The load is in N,
    the contact modulus in Pa.

    Examples
    --------
    >>> hertz_contact(10.0, 115.385e9, 10e-3).aspect, hertz_contact(10.0, 1e11, 2e-3, 3e-3).aspect
    (1.0, inf)
    """
    sizes = {"radius": radius, "length": length, "crown_radius": crown_radius}
    known_sizes = {name: size for name, size in sizes.items() if size is not None}
    require_not_negative(normal_load=normal_load)
    require_positive(contact_modulus=contact_modulus, **known_sizes)
    F, E, R = normal_load, contact_modulus, radius
    if crown_radius is not None:
        half_x, half_y, peak_pressure, _ = hertz_ellipse(F, R, crown_radius, E)
        return HertzContact(half_x, peak_pressure, half_y / half_x)
    if length is None:
        peak_pressure = hertz_point_peak_pressure(F, R, E)
        return HertzContact(hertz_point_radius(F, R, E), peak_pressure, 1.0)
    P = F / length
    half_width = hertz_line_half_width(P, R, E)
    return HertzContact(half_width, hertz_line_peak_pressure(P, R, E), math.inf)


def hertz_pressure(distance: ArrayLike, contact_radius: float, peak_pressure: float) -> Array:
    """Pressure of a Hertzian line or point contact [Pa], of the shape of `distance`.

    p = p₀√(1 − r²/a²) for r < a, else 0 (Johnson, §4.2), with the distance r [m]
    from the line of symmetry or from the centre.

    Examples
    --------
    >>> hertz_pressure([0.0, 0.6, 1.0, 2.0], contact_radius=1.0, peak_pressure=10.0)
    array([10.,  8.,  0.,  0.])
    """
    require_positive(contact_radius=contact_radius)
    require_not_negative(peak_pressure=peak_pressure)
    r, a, p0 = real_array("distance", distance), contact_radius, peak_pressure
    return p0 * np.sqrt(np.maximum(1 - (r / a) ** 2, 0.0))


def rolling_sliding_rise(
    friction: float,
    load_per_length: float,
    width: float,
    velocities: tuple[float, float],
    thermal_effusivity: float,
) -> float:
    """Highest temperature rise of a line contact of two identical bodies that roll and slide [K].

    ``θ = c µ w |√u₁ − √u₂|/(e √(2b))`` with the friction coefficient µ, the load per length w
    [N/m], the contact's width 2b [m], the velocities u₁ and u₂ of the surfaces through the contact
    in one direction [m/s], and the effusivity e = √(Kρc) of each body (Blok 1937). For the
    pressure of Hertz, c = 1.111548 is the highest value of ∫ (4/π) √(1 − ξ²)/√(2π(x − ξ)) dξ over
    −1 < ξ < x, at x = 0.65 half-widths; Blok rounds it to 1.11. The formula is for high Péclet
    numbers. There a point loses no heat sideways on its way through the contact, and the heat is
    shared as √u₁ : √u₂.

    Examples
    --------
    >>> slow, fast = 15.0, 25.0
    >>> print(f"{rolling_sliding_rise(0.05, 1e5, 2e-4, (slow, fast), 12844.05):.1f} K")
    34.5 K
    >>> rolling_sliding_rise(0.05, 1e5, 2e-4, (fast, fast), 12844.05)
    0.0
    """
    require_pair(velocities=velocities)
    for velocity in velocities:
        require_not_negative(velocities=velocity)
    require_not_negative(friction=friction, load_per_length=load_per_length)
    require_positive(width=width, thermal_effusivity=thermal_effusivity)
    µ, w, e = friction, load_per_length, thermal_effusivity
    slow, fast = sorted(velocities)
    return _BLOK_FACTOR * µ * w * (math.sqrt(fast) - math.sqrt(slow)) / (e * math.sqrt(width))


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
    require_not_negative(worn_area=worn_area)
    require_positive(radius=radius)
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
    require_not_negative(worn_volume=worn_volume)
    require_positive(radius=radius)
    return math.sqrt(math.sqrt(64 * radius * worn_volume / math.pi))
