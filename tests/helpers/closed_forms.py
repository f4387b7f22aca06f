"""Closed forms against which the solvers are tested, in addition to those of `tribo.analytic`.

Johnson, *Contact Mechanics*, 1985; Carslaw & Jaeger, *Conduction of Heat in Solids*, 2nd ed., 1959.
"""

import math

import numpy as np
import scipy
from numpy.typing import ArrayLike

from tribo.errors import require_positive
from tribo.types import Array

_RAYS = 200  # rays in the integral over an ellipse, and nodes on each ray


def hertz_point_approach(normal_load: float, radius: float, contact_modulus: float) -> float:
    """Approach α of distant points of a sphere and a plane [m].

    α = a²/R = (9F²/(16RE*²))^⅓ with the radius a of the contact, the load F [N], the sphere's
    radius R [m] and the contact modulus E* [Pa] (Johnson, Eq. 4.23).

    Examples
    --------
    >>> f"{hertz_point_approach(10.0, 10e-3, 115.385e9):.4e} m"
    '7.5037e-07 m'
    """
    F, R, E = normal_load, radius, contact_modulus
    return float(np.cbrt(9 * F**2 / (16 * R * E**2)))


def westergaard_full_contact_pressure(
    amplitude: float, wavelength: float, contact_modulus: float
) -> float:
    """Mean pressure p* that just flattens a wave z = Δ(1 − cos(2πx/λ)) [Pa].

    p* = πE*Δ/λ with the amplitude Δ and the wavelength λ [m], and the contact modulus E* [Pa]
    (Johnson, §13.2).

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

    p̄ = p* sin²(πa/λ) is solved for a, with the mean pressure p̄, the pressure p* of full contact
    and the wavelength λ [m] (Westergaard 1939; Johnson, §13.2).

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

    p* is the pressure of full contact [Pa], and λ the wavelength [m].

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

    p = 2p* cos ψ √(p̄/p* − sin² ψ), ψ = πx/λ, where the surfaces touch, else 0;
    p = p̄ + p* cos 2ψ in full contact, p̄ ≥ p* (Westergaard 1939; Johnson, §13.2).

    Here x is the position, p̄ the mean pressure, p* the mean pressure that just makes full contact,
    and λ the wavelength. The surfaces touch where sin² ψ < p̄/p*.

    Examples
    --------
    Both formulas agree where contact becomes full, and the mean is the one given:

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


def uniform_flux_rise(heat_flux: float, time: float, thermal_effusivity: float) -> float:
    """Rise of the surface temperature under a constant flux on the whole surface since time 0 [K].

    θ = 2q√t/(√π e) with the flux q [W/m²], the time t [s] and the effusivity e = √(Kρc) (Carslaw &
    Jaeger, §2.9). The sum of all entries of a thermal influence kernel, times q, equals this rise
    at any velocity.

    Examples
    --------
    >>> f"{uniform_flux_rise(1e6, 5.0, 12844.05):.2f} K"
    '196.44 K'
    """
    q, t, e = heat_flux, time, thermal_effusivity
    return 2 * q * math.sqrt(t) / (math.sqrt(math.pi) * e)


def ramped_flux_rise(final_heat_flux: float, time: float, thermal_effusivity: float) -> float:
    """Rise of the surface temperature under a flux that has grown in proportion to time [K].

    θ = 4q√t/(3√π e) with the final flux q [W/m²], the time t [s] and the effusivity e = √(Kρc), two
    thirds of the rise if the final flux acted from the start (Carslaw & Jaeger, §2.9).

    Examples
    --------
    >>> f"{ramped_flux_rise(1e6, 5.0, 12844.05) / uniform_flux_rise(1e6, 5.0, 12844.05):.6f}"
    '0.666667'
    """
    return uniform_flux_rise(final_heat_flux, time, thermal_effusivity) * 2 / 3


def square_source_rise(heat_flux: float, half_side: float, thermal_conductivity: float) -> float:
    """Steady temperature rise at the centre of a square heat source at rest [K].

    θ = 4qa ln(1 + √2)/(πK) with the flux q [W/m²], half a side a [m] and the conductivity K [W/(m
    K)] (Carslaw & Jaeger, §10.5).

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
    """Steady temperature rise by a band source on a moving half-space [K], shape of `position`.

    ``θ(x) = q/(πK) ∫_{−l}^{l} exp(V(x − x')/2κ) K₀(V|x − x'|/2κ) dx'``, where the solid moves at V
    > 0 [m/s] along x past the band from −l to l (Jaeger 1942; Carslaw & Jaeger, §10.7). q is the
    flux [W/m²], l half the band's width [m], K the conductivity [W/(m K)], κ the diffusivity [m²/s]
    and K₀ a Bessel function. The closed form follows from the integral of e^{±u} K₀(u) from 0 to U,
    which is U e^{±U} (K₀(U) ± K₁(U)) ∓ 1.

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


def resting_ellipse_rise(
    peak_flux: float, half_x: float, half_y: float, thermal_conductivity: float
) -> float:
    """Highest steady temperature rise under a flux q₀√(1 − x²/a² − y²/b²) on a body at rest [K].

    θ = q₀ b F(e)/(2K) with the peak flux q₀ [W/m²], the semi-axes a ≥ b [m], e² = 1 − b²/a², the
    complete elliptic integral of the first kind F(e) and the conductivity K [W/(m K)]. Steady
    conduction and elastic displacement obey the same integral (Johnson, Eq. 3.69).

    Examples
    --------
    On a circle the rise is πq₀a/(4K):

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
    """Highest steady temperature rise under an elliptical flux on a body that moves along x [K].

    The flux is q = q₀√(1 − x²/a² − y²/b²) [W/m²], with the semi-axes a and b along x and y [m]. The
    result is the highest rise on the middle line, y = 0. The rise at a point is a sum of moving
    point sources (Carslaw & Jaeger, §10.7), here in polar coordinates r and φ about this point:

        θ = 1/(2πK) ∫∫ q exp(−V r (1 − cos φ)/(2κ)) dr dφ,

    with the velocity V [m/s], the conductivity K and the diffusivity κ, and with φ = 0 upstream.
    The result is accurate to 1e-4 for ratios of the semi-axes up to 20.

    Examples
    --------
    Compared with the fit of Tian & Kennedy (J. Tribology 116, 1994) for a circle, whose mean flux
    is q̄ = 2q₀/3:

    >>> rise = moving_ellipse_rise(1.5e9, 1e-4, 1e-4, 1.0, 45.0, 1.2275e-5)
    >>> fit = 2.32 * 1e9 * 1e-4 / (45.0 * math.sqrt(math.pi * (1.234 + 1e-4 / (2 * 1.2275e-5))))
    >>> f"{rise / fit:.3f}"
    '1.011'
    """
    a, b = half_x, half_y
    if velocity == 0:
        return resting_ellipse_rise(peak_flux, a, b, thermal_conductivity)
    nodes, weights = np.polynomial.legendre.leggauss(_RAYS)
    nodes, weights = (nodes + 1) / 2, weights / 2
    angle = (math.pi * nodes**3)[:, None]  # dense upstream, where the heat comes from
    angle_weights = (3 * math.pi * nodes**2 * weights)[:, None]
    along, across = np.cos(angle) / a, np.sin(angle) / b
    decay = abs(velocity) / (2 * thermal_diffusivity) * (1 - np.cos(angle))

    def negative_rise(x: float) -> float:
        """Steady rise at a point of the middle line, times −2πK/q₀ [m], to be minimised.

        The point lies `x` [m] behind the centre of the elliptical source. K is the thermal
        conductivity, and q₀ the peak flux.
        """
        # On a ray, 1 − x²/a² − y²/b² = `constant` + 2 `product` r − `square` r², whose positive
        # root in r is the edge of the ellipse.
        square, product, constant = along**2 + across**2, x / a * along, 1 - (x / a) ** 2
        edge = (product + np.sqrt(product**2 + square * constant)) / square
        r = edge * np.sin(math.pi / 2 * nodes) ** 2
        flux = np.sqrt(np.maximum(constant + 2 * product * r - square * r**2, 0.0))
        r_weights = edge * math.pi / 2 * np.sin(math.pi * nodes) * weights
        return -2 * float(np.sum(angle_weights * r_weights * flux * np.exp(-decay * r)))

    minimum = scipy.optimize.minimize_scalar(
        negative_rise, bounds=(0.0, a), method="bounded", options={"xatol": 1e-4 * a}
    )
    return -peak_flux * float(minimum.fun) / (2 * math.pi * thermal_conductivity)


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


MOVING_SQUARE_PEAK = {0.0: 1.122200, 0.1: 1.064837, 1.0: 0.796781, 10.0: 0.347174, 100.0: 0.112436}
"""Highest steady rise θK/(ql) on a square source of half side l, by Péclet number Vl/(2κ).

Quadrature of the moving-source integral (Carslaw & Jaeger, §10.7) to 20 digits, rounded; the
first is 4 ln(1 + √2)/π, and the peak lies at x/l = 0, 0.11, 0.57, 0.92 and 0.99.
"""
