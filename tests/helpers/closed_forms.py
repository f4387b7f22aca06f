"""Closed forms against which the solvers are tested, in addition to those of `tribo.analytic`.

Johnson, *Contact Mechanics*, 1985; Carslaw & Jaeger, *Conduction of Heat in Solids*, 2nd ed., 1959.
"""

import math

import numpy as np
import scipy

_RAYS = 200  # rays in the integral over an ellipse, and nodes on each ray


def hertz_point_approach(normal_load, radius, contact_modulus):
    """Approach of distant points of a sphere and a plane, (9F²/(16RE*²))^⅓ [m] (Johnson, 4.23)."""
    return np.cbrt(9 * normal_load**2 / (16 * radius * contact_modulus**2))


def westergaard_pressure(position, mean_pressure, full_contact_pressure, wavelength):
    """Pressure on a sinusoidal wave with its crests at x = 0, ±λ, … [Pa], shaped as `position`.

    p = 2p* cos ψ √(p̄/p* − sin² ψ), ψ = πx/λ, where the surfaces touch, else 0;
    p = p̄ + p* cos 2ψ in full contact, p̄ ≥ p* (Westergaard 1939; Johnson, §13.2).
    """
    p_mean, p_full = mean_pressure, full_contact_pressure
    psi = math.pi * position / wavelength
    if p_mean >= p_full:
        return p_mean + p_full * np.cos(2 * psi)
    inside = np.maximum(p_mean / p_full - np.sin(psi) ** 2, 0.0)
    return 2 * p_full * np.abs(np.cos(psi)) * np.sqrt(inside)


def uniform_flux_rise(heat_flux, time, thermal_effusivity):
    """Rise of a surface under a constant flux since time 0, 2q√t/(√π e) [K].

    The effusivity is e = √(Kρc) (Carslaw & Jaeger, §2.9). Under a flux that has grown in proportion
    to time, the rise is two thirds of this.
    """
    return 2 * heat_flux * math.sqrt(time) / (math.sqrt(math.pi) * thermal_effusivity)


def moving_band_rise(
    position, heat_flux, half_width, velocity, thermal_conductivity, thermal_diffusivity
):
    """Steady temperature rise by a band source on a moving half-space [K], shape of `position`.

    ``θ(x) = q/(πK) ∫_{−l}^{l} exp(V(x − x')/2κ) K₀(V|x − x'|/2κ) dx'``, where the solid moves at V
    along x past the band from −l to l (Jaeger 1942; Carslaw & Jaeger, §10.7). The integral of
    e^{±u} K₀(u) from 0 to U is U e^{±U} (K₀(U) ± K₁(U)) ∓ 1.

    At a high Péclet number the trailing edge is as warm as under a uniform flux for 2l/V:

    >>> K, kappa, half_width, V = 45.0, 1.2275e-5, 1e-4, 5000.0
    >>> edge = moving_band_rise(half_width, 1e8, half_width, V, K, kappa)
    >>> f"{edge / uniform_flux_rise(1e8, 2 * half_width / V, K / math.sqrt(kappa)):.3f}"
    '0.998'
    """
    scale = 2 * thermal_diffusivity / velocity

    def integral(U):
        """∫₀^U e^u K₀(|u|) du, for U of either sign."""
        size = np.maximum(np.abs(U), np.finfo(float).tiny)
        k0, k1 = scipy.special.k0e(size), scipy.special.k1e(size)
        behind = size * (k0 + k1) - 1
        ahead = size * np.exp(-2 * size) * (k1 - k0) - 1
        return np.where(U > 0, behind, ahead)

    band = integral((position + half_width) / scale) - integral((position - half_width) / scale)
    return heat_flux * scale / (math.pi * thermal_conductivity) * band


def moving_ellipse_rise(
    peak_flux, half_x, half_y, velocity, thermal_conductivity, thermal_diffusivity
):
    """Highest steady temperature rise under an elliptical flux on a body that moves along x [K].

    The flux is q = q₀√(1 − x²/a² − y²/b²), with the semi-axes a and b along x and y. The result is
    the highest rise on the middle line, y = 0. The rise at a point is a sum of moving point sources
    (Carslaw & Jaeger, §10.7), here in polar coordinates r and φ about this point:

        θ = 1/(2πK) ∫∫ q exp(−V r (1 − cos φ)/(2κ)) dr dφ,

    with φ = 0 upstream. It is accurate to 1e-4 for ratios of the semi-axes up to 20. At rest it is
    q₀ b F(e)/(2K) with a ≥ b, e² = 1 − b²/a² and the complete elliptic integral of the first kind,
    since steady conduction and elastic displacement obey the same integral (Johnson, Eq. 3.69).

    Compared with the fit of Tian & Kennedy (J. Tribology 116, 1994) for a circle, whose mean flux
    is q̄ = 2q₀/3:

    >>> rise = moving_ellipse_rise(1.5e9, 1e-4, 1e-4, 1.0, 45.0, 1.2275e-5)
    >>> fit = 2.32 * 1e9 * 1e-4 / (45.0 * math.sqrt(math.pi * (1.234 + 1e-4 / (2 * 1.2275e-5))))
    >>> f"{rise / fit:.3f}"
    '1.011'
    """
    a, b = half_x, half_y
    if velocity == 0:
        short, long = sorted((a, b))
        integral = scipy.special.ellipkm1((short / long) ** 2)
        return peak_flux * short * integral / (2 * thermal_conductivity)
    nodes, weights = np.polynomial.legendre.leggauss(_RAYS)
    nodes, weights = (nodes + 1) / 2, weights / 2
    angle = (math.pi * nodes**3)[:, None]  # dense upstream, where the heat comes from
    angle_weights = (3 * math.pi * nodes**2 * weights)[:, None]
    along, across = np.cos(angle) / a, np.sin(angle) / b
    decay = abs(velocity) / (2 * thermal_diffusivity) * (1 - np.cos(angle))

    def negative_rise(x):
        """Rise at a point of the middle line, `x` behind the centre, times −2πK/q₀ [m]."""
        # On a ray, 1 − x²/a² − y²/b² = `constant` + 2 `product` r − `square` r², whose positive
        # root in r is the edge of the ellipse.
        square, product, constant = along**2 + across**2, x / a * along, 1 - (x / a) ** 2
        edge = (product + np.sqrt(product**2 + square * constant)) / square
        r = edge * np.sin(math.pi / 2 * nodes) ** 2
        flux = np.sqrt(np.maximum(constant + 2 * product * r - square * r**2, 0.0))
        r_weights = edge * math.pi / 2 * np.sin(math.pi * nodes) * weights
        return -2 * np.sum(angle_weights * r_weights * flux * np.exp(-decay * r))

    minimum = scipy.optimize.minimize_scalar(
        negative_rise, bounds=(0.0, a), method="bounded", options={"xatol": 1e-4 * a}
    )
    return -peak_flux * minimum.fun / (2 * math.pi * thermal_conductivity)


MOVING_SQUARE_PEAK = {0.0: 1.122200, 0.1: 1.064837, 1.0: 0.796781, 10.0: 0.347174, 100.0: 0.112436}
"""Highest steady rise θK/(ql) on a square source of half side l, by Péclet number Vl/(2κ).

Quadrature of the moving-source integral (Carslaw & Jaeger, §10.7) to 20 digits, rounded; the
first is 4 ln(1 + √2)/π, and the peak lies at x/l = 0, 0.11, 0.57, 0.92 and 0.99.
"""
