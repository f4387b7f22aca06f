"""Closed forms against which the solvers are tested; none of them calls a solver.

Contact (Johnson, *Contact Mechanics*, 1985; E* is `material.contact_modulus`)
    `hertz_line_half_width`, `hertz_line_peak_pressure`, `hertz_point_radius`,
    `hertz_point_peak_pressure`, `hertz_point_approach`, `hertz_ellipse`, `hertz_pressure`,
    `westergaard_full_contact_pressure`, `westergaard_half_width`,
    `westergaard_mean_pressure`, `westergaard_pressure`
Wear
    `archard_wear_depth`, `worn_line_width`, `worn_point_width`
Heat (Carslaw & Jaeger, *Conduction of Heat in Solids*, 2nd ed., 1959; an insulated half-space)
    `uniform_flux_rise`, `ramped_flux_rise`, `square_source_rise`, `moving_band_rise`,
    `MOVING_SQUARE_PEAK`, `rolling_sliding_rise`, `resting_ellipse_rise`, `moving_ellipse_rise`
"""

from __future__ import annotations

import math
from typing import Literal, NamedTuple

import numpy as np
import scipy
from numpy.typing import ArrayLike

from tribo.errors import InputError, require_positive
from tribo.types import Array


def hertz_line_half_width(load_per_length: float, radius: float, contact_modulus: float) -> float:
    """Half-width a of the contact between a cylinder and a plane [m].

    a = √(4PR/(πE*)) with the load per length P [N/m] and the radius R [m] (Johnson, Eq. 4.43).

    Examples
    --------
    >>> f"{hertz_line_half_width(750 / 3.4e-3, 2e-3, 115.385e9):.4e} m"
    '6.9773e-05 m'
    """
    P, R, E = load_per_length, radius, contact_modulus
    return math.sqrt(4 * P * R / (math.pi * E))


def hertz_line_peak_pressure(
    load_per_length: float, radius: float, contact_modulus: float
) -> float:
    """Highest pressure p₀ between a cylinder and a plane [Pa].

    p₀ = √(PE*/(πR)) (Johnson, Eq. 4.45). With P [N/m] and R [m].

    Examples
    --------
    It carries the load: P = πap₀/2.

    >>> P, R, E = 750 / 3.4e-3, 2e-3, 115.385e9
    >>> p0 = hertz_line_peak_pressure(P, R, E)
    >>> f"{p0:.4e} Pa, {math.pi / 2 * hertz_line_half_width(P, R, E) * p0 / P:.6f}"
    '2.0127e+09 Pa, 1.000000'
    """
    P, R, E = load_per_length, radius, contact_modulus
    return math.sqrt(P * E / (math.pi * R))


def hertz_point_radius(normal_load: float, radius: float, contact_modulus: float) -> float:
    """Radius a of the contact between a sphere and a plane [m].

    a = (3FR/(4E*))^⅓ with the load F [N] and the sphere's radius R [m] (Johnson, Eq. 4.22).

    Examples
    --------
    >>> f"{hertz_point_radius(10.0, 10e-3, 115.385e9):.4e} m"
    '8.6624e-05 m'
    """
    F, R, E = normal_load, radius, contact_modulus
    return float(np.cbrt(3 * F * R / (4 * E)))


def hertz_point_peak_pressure(normal_load: float, radius: float, contact_modulus: float) -> float:
    """Highest pressure p₀ between a sphere and a plane [Pa].

    p₀ = (6FE*²/(π³R²))^⅓ (Johnson, Eq. 4.24). With F [N] and R [m].

    Examples
    --------
    It carries the load: F = 2πa²p₀/3.

    >>> p0 = hertz_point_peak_pressure(10.0, 10e-3, 115.385e9)
    >>> a = hertz_point_radius(10.0, 10e-3, 115.385e9)
    >>> f"{p0:.4e} Pa, {2 * math.pi / 3 * a**2 * p0:.6f} N"
    '6.3631e+08 Pa, 10.000000 N'
    """
    F, R, E = normal_load, radius, contact_modulus
    return float(np.cbrt(6 * F * E**2 / (math.pi**3 * R**2)))


def hertz_point_approach(normal_load: float, radius: float, contact_modulus: float) -> float:
    """Approach α of distant points of a sphere and a plane [m].

    α = a²/R = (9F²/(16RE*²))^⅓ (Johnson, Eq. 4.23). With F [N] and R [m].

    Examples
    --------
    >>> f"{hertz_point_approach(10.0, 10e-3, 115.385e9):.4e} m"
    '7.5037e-07 m'
    """
    F, R, E = normal_load, radius, contact_modulus
    return float(np.cbrt(9 * F**2 / (16 * R * E**2)))


class HertzEllipse(NamedTuple):
    """Elastic contact of a body of two radii and a plane.

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

    With the semi-axes a ≥ b, κ = b/a, and Carlson's integral R_D, which joins the complete elliptic
    integrals without their cancellation near a circle (Johnson, Eqs. 4.26 to 4.31):

        1/(2R_a) = p₀b/(3E*a²) R_D(0, κ², 1),   1/(2R_b) = p₀b/(3E*a²) R_D(0, 1, κ²),
        F = 2πp₀ab/3,   α = p₀b K(e)/E*,   e² = 1 − κ².

    Parameters
    ----------
    normal_load : float
        F [N].
    radius_x, radius_y : float
        Radii of curvature along x and y [m]; the semi-axis is the longer one along the larger.
    contact_modulus : float
        E* [Pa].

    Examples
    --------
    Equal radii make a circle:

    >>> print("{:.4e} {:.4e} {:.4e} {:.4e}".format(*hertz_ellipse(10.0, 10e-3, 10e-3, 115.385e9)))
    8.6624e-05 8.6624e-05 6.3631e+08 7.5037e-07
    """
    require_positive(normal_load=normal_load, radius_x=radius_x, radius_y=radius_y)
    F, E = normal_load, contact_modulus
    long, short = max(radius_x, radius_y), min(radius_x, radius_y)
    elliprd = scipy.special.elliprd

    def excess(log_ratio: float) -> float:
        """Logarithm of the ratio of curvatures of an ellipse of this b/a, less the one given."""
        square = math.exp(2 * log_ratio)
        ratio = elliprd(0.0, 1.0, square) / elliprd(0.0, square, 1.0)
        return float(np.log(ratio)) - math.log(long / short)

    # b/a lies between the inverse of the ratio of the radii and 1.
    flattest = -math.log(long / short)
    log_ratio = scipy.optimize.brentq(excess, flattest, 0.0, xtol=1e-15) if flattest else 0.0
    k = math.exp(log_ratio)
    a = float(np.cbrt(F * elliprd(0.0, k**2, 1.0) * long / (math.pi * E)))
    p0 = 3 * F / (2 * math.pi * k * a**2)
    approach = p0 * k * a * float(scipy.special.ellipkm1(k**2)) / E
    half_x, half_y = (a, k * a) if radius_x >= radius_y else (k * a, a)
    return HertzEllipse(half_x, half_y, p0, approach)


def hertz_pressure(distance: ArrayLike, contact_radius: float, peak_pressure: float) -> Array:
    """Pressure of a Hertzian line or point contact [Pa], of the shape of `distance`.

    p = p₀√(1 − r²/a²) for r < a, else 0 (Johnson, §4.2), with the distance r [m]
    from the line of symmetry or from the centre.

    Examples
    --------
    >>> hertz_pressure([0.0, 0.6, 1.0, 2.0], contact_radius=1.0, peak_pressure=10.0)
    array([10.,  8.,  0.,  0.])
    """
    r, a, p0 = np.asarray(distance, dtype=float), contact_radius, peak_pressure
    return p0 * np.sqrt(np.maximum(1 - (r / a) ** 2, 0.0))


def westergaard_full_contact_pressure(
    amplitude: float, wavelength: float, contact_modulus: float
) -> float:
    """Mean pressure p* that just flattens a wave z = Δ(1 − cos(2πx/λ)) [Pa].

    p* = πE*Δ/λ with the amplitude Δ and the wavelength λ [m] (Johnson, §13.2).

    Examples
    --------
    >>> f"{westergaard_full_contact_pressure(0.1e-6, 50e-6, 115.385e9):.4e} Pa"
    '7.2499e+08 Pa'
    """
    return math.pi * contact_modulus * amplitude / wavelength


def westergaard_half_width(
    mean_pressure: float, full_contact_pressure: float, wavelength: float
) -> float:
    """Half-width a of each contact on a sinusoidal wave [m]; λ/2 once contact is full.

    p̄ = p* sin²(πa/λ) (Westergaard 1939; Johnson, §13.2), solved for a.

    Examples
    --------
    >>> f"{westergaard_half_width(0.5, full_contact_pressure=1.0, wavelength=8.0):.6f} m"
    '2.000000 m'
    """
    share = min(mean_pressure / full_contact_pressure, 1.0)
    return wavelength / math.pi * math.asin(math.sqrt(share))


def westergaard_mean_pressure(
    half_width: float, full_contact_pressure: float, wavelength: float
) -> float:
    """Mean pressure p̄ = p* sin²(πa/λ) at which contacts on a wave are 2a wide [Pa].

    Examples
    --------
    >>> mean = westergaard_mean_pressure(half_width=1.0, full_contact_pressure=4.0, wavelength=6.0)
    >>> f"{mean:.6f} Pa"
    '1.000000 Pa'
    """
    return full_contact_pressure * math.sin(math.pi * half_width / wavelength) ** 2


def westergaard_pressure(
    position: ArrayLike, mean_pressure: float, full_contact_pressure: float, wavelength: float
) -> Array:
    """Pressure on a sinusoidal wave with its crests at x = 0, ±λ, … [Pa], shaped as `position`.

    p = 2p* cos ψ √(sin² ψ_a − sin² ψ), ψ = πx/λ, ψ_a = πa/λ, in contact, else 0;
    p = p̄ + p* cos 2ψ in full contact, p̄ ≥ p* (Westergaard 1939; Johnson, §13.2).

    Examples
    --------
    Both agree where contact becomes full, and the mean is the one given:

    >>> x = np.linspace(0.0, 1.0, 400, endpoint=False)
    >>> full = westergaard_pressure(x, 2.0, full_contact_pressure=2.0, wavelength=1.0)
    >>> bool(np.allclose(full, 2.0 + 2.0 * np.cos(2 * np.pi * x)))
    True
    >>> f"{westergaard_pressure(x, 0.5, full_contact_pressure=2.0, wavelength=1.0).mean():.4f}"
    '0.5000'
    """
    p_mean, p_full = mean_pressure, full_contact_pressure
    psi = math.pi * np.asarray(position, dtype=float) / wavelength
    if p_mean >= p_full:
        return p_mean + p_full * np.cos(2 * psi)
    inside = np.maximum(p_mean / p_full - np.sin(psi) ** 2, 0.0)
    return 2 * p_full * np.abs(np.cos(psi)) * np.sqrt(inside)


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
    The segment is two thirds of its width times its height:

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
    The cap is half its base times its height:

    >>> V, R = 5e-15, 5e-3
    >>> w = worn_point_width(V, R)
    >>> f"{w:.4e} m, {math.pi / 8 * w**2 * w**2 / (8 * R) / V:.6f}"
    '1.5023e-04 m, 1.000000'
    """
    return math.sqrt(math.sqrt(64 * radius * worn_volume / math.pi))


def uniform_flux_rise(heat_flux: float, time: float, thermal_effusivity: float) -> float:
    """Surface rise under a constant flux on the whole surface since time 0 [K].

    θ = 2q√t/(√π e), e = √(Kρc) (Carslaw & Jaeger, §2.9). The sum of all entries of a
    thermal influence kernel, times q, is the same, whatever the velocity.

    Examples
    --------
    >>> f"{uniform_flux_rise(1e6, 5.0, 12844.05):.2f} K"
    '196.44 K'
    """
    q, t, e = heat_flux, time, thermal_effusivity
    return 2 * q * math.sqrt(t) / (math.sqrt(math.pi) * e)


def ramped_flux_rise(final_heat_flux: float, time: float, thermal_effusivity: float) -> float:
    """Surface rise at the end of a flux that grows from 0 in proportion to time [K].

    θ = 4q√t/(3√π e), two thirds of what the final flux q gives if it acts from the start
    (Carslaw & Jaeger, §2.9).

    Examples
    --------
    >>> f"{ramped_flux_rise(1e6, 5.0, 12844.05) / uniform_flux_rise(1e6, 5.0, 12844.05):.6f}"
    '0.666667'
    """
    return uniform_flux_rise(final_heat_flux, time, thermal_effusivity) * 2 / 3


def square_source_rise(heat_flux: float, half_side: float, thermal_conductivity: float) -> float:
    """Steady rise at the centre of a square source at rest [K].

    θ = 4qa ln(1 + √2)/(πK) with half a side a [m] (Carslaw & Jaeger, §10.5).

    Examples
    --------
    >>> f"{square_source_rise(1e9, 1e-6, 45.0):.4f} K"
    '24.9378 K'
    """
    q, a, K = heat_flux, half_side, thermal_conductivity
    return 4 * q * a * math.log(1 + math.sqrt(2)) / (math.pi * K)


def moving_band_rise(
    position: ArrayLike,
    heat_flux: float,
    half_width: float,
    velocity: float,
    thermal_conductivity: float,
    thermal_diffusivity: float,
) -> Array:
    """Steady surface rise due to a band source on a moving half-space [K], as `position`.

    θ(x) = q/(πK) ∫_{−l}^{l} exp(V(x − x')/2κ) K₀(V|x − x'|/2κ) dx', where the solid moves at
    V > 0 along x past the band |x| < l (Jaeger 1942; Carslaw & Jaeger, §10.7). In closed form,
    since the integral of e^{±u} K₀(u) from 0 to U is U e^{±U} (K₀(U) ± K₁(U)) ∓ 1.

    Examples
    --------
    At a high Péclet number the trailing edge is as warm as under a uniform flux for 2l/V:

    >>> K, kappa, half_width, V = 45.0, 1.2275e-5, 1e-4, 5000.0
    >>> edge = moving_band_rise(half_width, 1e8, half_width, V, K, kappa)
    >>> f"{edge / uniform_flux_rise(1e8, 2 * half_width / V, K / math.sqrt(kappa)):.3f}"
    '0.998'
    """
    require_positive(velocity=velocity, half_width=half_width)
    x, q, K = np.asarray(position, dtype=float), heat_flux, thermal_conductivity
    scale = 2 * thermal_diffusivity / velocity

    def integral(U: Array) -> Array:
        """∫₀^U e^u K₀(|u|) du, for U of either sign."""
        size = np.maximum(np.abs(U), np.finfo(float).tiny)
        k0, k1 = scipy.special.k0e(size), scipy.special.k1e(size)
        behind = size * (k0 + k1) - 1
        ahead = size * np.exp(-2 * size) * (k1 - k0) - 1
        return np.asarray(np.where(U > 0, behind, ahead))

    band = integral((x + half_width) / scale) - integral((x - half_width) / scale)
    return np.asarray(q * scale / (math.pi * K) * band)


ROLLING_SLIDING_PEAK = {"uniform": 1.128379, "hertz": 1.111548}
"""Coefficient of `rolling_sliding_rise` by the profile of the pressure.

2/√π; and the highest value of ∫ (4/π) √(1 − ξ²)/√(2π(x − ξ)) dξ over −1 < ξ < x, at x = 0.65 half
widths. Blok's 1.11 is the latter.
"""


def rolling_sliding_rise(
    friction: float,
    load_per_length: float,
    width: float,
    velocities: tuple[float, float],
    thermal_effusivity: float,
    pressure: Literal["uniform", "hertz"] = "hertz",
) -> float:
    """Highest rise of a line contact of two identical bodies that roll and slide [K].

    θ = c µ w |√u₁ − √u₂|/(e √(2b)) with the load per length w [N/m], the contact's width 2b [m],
    the velocities u₁ and u₂ of both surfaces through it [m/s], in one direction, and the effusivity
    e = √(Kρc) of each body (Blok 1937). At high Péclet numbers: each point is heated on its way
    through the contact and loses nothing sideways, so that the heat is shared as √u₁ : √u₂.

    Examples
    --------
    >>> slow, fast = 15.0, 25.0
    >>> print(f"{rolling_sliding_rise(0.05, 1e5, 2e-4, (slow, fast), 12844.05):.1f} K")
    34.5 K
    >>> rolling_sliding_rise(0.05, 1e5, 2e-4, (fast, fast), 12844.05)
    0.0
    """
    µ, w, e, c = friction, load_per_length, thermal_effusivity, ROLLING_SLIDING_PEAK[pressure]
    slow, fast = sorted(velocities)
    if slow < 0:
        raise InputError(f"velocities are {velocities!r}; both must be at least 0")
    return c * µ * w * (math.sqrt(fast) - math.sqrt(slow)) / (e * math.sqrt(width))


def resting_ellipse_rise(
    peak_flux: float, half_x: float, half_y: float, thermal_conductivity: float
) -> float:
    """Highest steady rise under a flux q₀√(1 − x²/a² − y²/b²) on a body at rest [K].

    θ = q₀ b K(e)/(2K) with the shorter semi-axis b [m] and e² = 1 − b²/a²: the heat flows as the
    elastic displacement spreads (Johnson, Eq. 3.69).

    Examples
    --------
    On a circle πq₀a/(4K):

    >>> f"{resting_ellipse_rise(1e9, 1e-4, 1e-4, 45.0) / (math.pi * 1e5 / (4 * 45.0)):.6f}"
    '1.000000'
    """
    b, a = sorted((half_x, half_y))
    return peak_flux * b * float(scipy.special.ellipkm1((b / a) ** 2)) / (2 * thermal_conductivity)


def moving_ellipse_rise(
    peak_flux: float,
    half_x: float,
    half_y: float,
    velocity: float,
    thermal_conductivity: float,
    thermal_diffusivity: float,
) -> float:
    """Highest steady rise under a flux q₀√(1 − x²/a² − y²/b²) on a body that moves along x [K].

    1/θ² = 1/θ₀² + 1/θ∞² of the body at rest and of a fast one, as Tian & Kennedy (J. Tribology 116,
    1994) join them for a circle: θ = 2.32 q̄a/(K√(π(1.234 + Va/2κ))), q̄ = 2q₀/3. Fast, the middle
    row is a line contact: θ∞ = 1.1115 (π/4) q₀ √(2a/V)/√(Kρc), a along x. Both ends are exact; in
    between a circle is off by at most 1 %, an ellipse of semi-axes 1 : 4 by −6 % if it lies across
    the motion, by +17 % if along it (Va/2κ about 10).

    Examples
    --------
    >>> rise = moving_ellipse_rise(1.5e9, 1e-4, 1e-4, 1.0, 45.0, 1.2275e-5)
    >>> circle = 2.32 * 1e9 * 1e-4 / (45.0 * math.sqrt(math.pi * (1.234 + 1e-4 / (2 * 1.2275e-5))))
    >>> f"{rise / circle:.3f}"
    '1.000'
    """
    resting = resting_ellipse_rise(peak_flux, half_x, half_y, thermal_conductivity)
    if velocity == 0:
        return resting
    effusivity = thermal_conductivity / math.sqrt(thermal_diffusivity)
    fast = ROLLING_SLIDING_PEAK["hertz"] * math.pi / 4 * peak_flux / effusivity
    fast *= math.sqrt(2 * half_x / abs(velocity))
    return 1 / math.hypot(1 / resting, 1 / fast)


MOVING_SQUARE_PEAK = {0.0: 1.122200, 0.1: 1.064837, 1.0: 0.796781, 10.0: 0.347174, 100.0: 0.112436}
"""Highest steady rise θK/(ql) on a square source of half side l, by Péclet number Vl/(2κ).

Quadrature of the moving-source integral (Carslaw & Jaeger, §10.7) to 20 digits, rounded; the
first is 4 ln(1 + √2)/π, and the peak lies at x/l = 0, 0.11, 0.57, 0.92 and 0.99.
"""
