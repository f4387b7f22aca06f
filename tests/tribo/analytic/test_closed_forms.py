"""Closed forms (tribo/analytic/) against the integrals and balances that they solve."""

import itertools
import math

import numpy as np
import pytest
from scipy import integrate, optimize, special

from tribo import analytic

E_STAR = 115.385e9
K, KAPPA = 45.0, 1.2275e-5
EFFUSIVITY = K / math.sqrt(KAPPA)
QUADRATURE = 1e-9


def integral(function, start, stop, singular=()):
    """Adaptive quadrature to the relative error `QUADRATURE`, with breaks at singular points."""
    inside = [start, *sorted(p for p in singular if start < p < stop), stop]
    return sum(
        integrate.quad(function, low, high, epsabs=0, epsrel=QUADRATURE / 10, limit=400)[0]
        for low, high in itertools.pairwise(inside)
    )


def test_hertz_line_pressure_carries_the_load():
    load, radius = 2.2e5, 2e-3
    a = analytic.hertz_line_half_width(load, radius, E_STAR)
    p0 = analytic.hertz_line_peak_pressure(load, radius, E_STAR)
    carried = integral(lambda x: float(analytic.hertz_pressure(x, a, p0)), -a, a)
    assert carried == pytest.approx(load, rel=QUADRATURE)
    assert not analytic.hertz_pressure([-1.01 * a, 1.01 * a], a, p0).any()


def test_hertz_line_pressure_presses_the_cylinder_flat():
    # u(x) = −2/(πE*) ∫ p ln|x − x'| dx' must follow −x²/2R.
    load, radius = 2.2e5, 2e-3
    a = analytic.hertz_line_half_width(load, radius, E_STAR)
    p0 = analytic.hertz_line_peak_pressure(load, radius, E_STAR)

    def displacement(x):
        return (
            -2
            / (math.pi * E_STAR)
            * integral(
                lambda s: float(analytic.hertz_pressure(s, a, p0)) * math.log(abs(x - s) / a),
                -a,
                a,
                singular=[x],
            )
        )

    for x in (0.3 * a, 0.8 * a):
        difference = displacement(0.0) - displacement(x)
        assert difference == pytest.approx(x**2 / (2 * radius), rel=20 * QUADRATURE)


def test_hertz_point_pressure_carries_the_load_and_meets_the_sphere():
    load, radius = 10.0, 10e-3
    a = analytic.hertz_point_radius(load, radius, E_STAR)
    p0 = analytic.hertz_point_peak_pressure(load, radius, E_STAR)
    alpha = analytic.hertz_point_approach(load, radius, E_STAR)
    carried = integral(lambda r: 2 * math.pi * r * float(analytic.hertz_pressure(r, a, p0)), 0, a)
    assert carried == pytest.approx(load, rel=QUADRATURE)
    # Boussinesq's displacement ∫ p/(πE*r) dA is the approach at the centre, and α − a²/2R at the
    # edge, where a ring of radius r acts as 4r/(a + r) times the elliptic integral K.
    centre = integral(lambda r: 2 * float(analytic.hertz_pressure(r, a, p0)) / E_STAR, 0, a)
    assert centre == pytest.approx(alpha, rel=QUADRATURE)
    edge = integral(
        lambda r: (
            float(analytic.hertz_pressure(r, a, p0))
            * 4
            * r
            / (a + r)
            * special.ellipk(4 * a * r / (a + r) ** 2)
            / (math.pi * E_STAR)
        ),
        0,
        a,
    )
    assert edge == pytest.approx(alpha - a**2 / (2 * radius), rel=QUADRATURE)


def test_a_sinusoidal_pressure_flattens_the_wave_in_full_contact():
    # Pressure p cos(kx) displaces the surface by 2p cos(kx)/(E*k) (Johnson, §13.2).
    amplitude, wavelength = 0.1e-6, 50e-6
    p_full = analytic.westergaard_full_contact_pressure(amplitude, wavelength, E_STAR)
    x = np.linspace(-wavelength, wavelength, 41)
    pressure = analytic.westergaard_pressure(x, 1.3 * p_full, p_full, wavelength)
    wave_number = 2 * math.pi / wavelength
    displacement = 2 * (pressure - 1.3 * p_full) / (E_STAR * wave_number)
    flat = displacement + amplitude * (1 - np.cos(wave_number * x))
    np.testing.assert_allclose(flat, amplitude, rtol=1e-12)
    assert pressure.min() == pytest.approx(0.3 * p_full)


@pytest.mark.parametrize("share", [0.02, 0.97])
def test_partial_contact_on_a_wave_carries_its_mean_pressure_on_its_width(share):
    p_full, wavelength = 7e8, 50e-6
    a = analytic.westergaard_half_width(share * p_full, p_full, wavelength)
    assert analytic.westergaard_mean_pressure(a, p_full, wavelength) == pytest.approx(
        share * p_full, rel=1e-12
    )

    def pressure(x):
        return float(analytic.westergaard_pressure(x, share * p_full, p_full, wavelength))

    carried = integral(pressure, -a, a)
    assert carried / wavelength == pytest.approx(share * p_full, rel=QUADRATURE)
    assert pressure(0.999 * a) > 0 == pressure(1.001 * a)
    assert pressure(wavelength + 0.5 * a) == pytest.approx(pressure(-0.5 * a), rel=1e-9)


def test_worn_volume_is_proportional_to_frictional_work():
    depth = analytic.archard_wear_depth(1.2e-15, np.array([1e9, 2e9]), 0.0625)
    # 1.2e-6 mm³/(N m) times N m gives mm³: 1 GPa on 1 mm² is 1000 N.
    assert depth[0] * 1e-6 * 1e9 == pytest.approx(1.2e-6 * 1000 * 0.0625)
    assert depth[1] == pytest.approx(2 * depth[0])


def test_heat_of_a_uniform_flux_is_in_the_profile_below_the_surface():
    # θ(z) = 2q√t/e ierfc(z/2√κt), (Carslaw & Jaeger, §2.9): its integral holds all the heat.
    q, t = 1e6, 5.0
    length = 2 * math.sqrt(KAPPA * t)
    surface = analytic.uniform_flux_rise(q, t, EFFUSIVITY)

    def profile(z):
        u = z / length
        return surface * (math.exp(-(u**2)) - math.sqrt(math.pi) * u * math.erfc(u))

    heat = integral(profile, 0, 9 * length)
    assert heat * K / KAPPA == pytest.approx(q * t, rel=QUADRATURE)


def test_a_ramp_is_the_sum_of_its_increments():
    q, t = 1e6, 5.0
    summed = integral(  # Duhamel: dq = q dt'/t acts for t − t'
        lambda start: analytic.uniform_flux_rise(q / t, t - start, EFFUSIVITY), 0, t
    )
    assert analytic.ramped_flux_rise(q, t, EFFUSIVITY) == pytest.approx(summed, rel=QUADRATURE)
    assert analytic.ramped_flux_rise(q, t, EFFUSIVITY) / analytic.uniform_flux_rise(
        q, t, EFFUSIVITY
    ) == pytest.approx(2 / 3, rel=1e-15)


def test_square_at_rest_is_the_sum_of_point_sources():
    q, a = 1e9, 1e-6
    eighth = integral(  # q/(2πKr) over eight triangles: ∫∫ dr dφ = ∫ a/cos φ dφ
        lambda angle: q / (2 * math.pi * K) * a / math.cos(angle), 0, math.pi / 4
    )
    assert analytic.square_source_rise(q, a, K) == pytest.approx(8 * eighth, rel=QUADRATURE)
    assert analytic.square_source_rise(q, a, K) * K / (q * a) == pytest.approx(
        analytic.MOVING_SQUARE_PEAK[0.0],
        rel=1e-6,  # six decimals
    )


@pytest.mark.parametrize("velocity", [0.01, 80.0])
def test_jaegers_band_is_the_sum_of_moving_line_sources(velocity):
    half_width, q = 1e-4, 1e8
    scale = velocity / (2 * KAPPA)
    x = np.array([-1.7, -1.0, -0.4, 0.0, 0.9, 1.0, 3.0]) * half_width
    expected = []
    for place in x:
        value = integral(
            lambda s, u=place: (
                math.exp((u - s - abs(u - s)) * scale) * special.k0e(abs(u - s) * scale)
            ),
            -half_width,
            half_width,
            singular=[place - 1 / scale, place, place + 1 / scale],
        )
        expected.append(q / (math.pi * K) * value)
    rise = analytic.moving_band_rise(x, q, half_width, velocity, K, KAPPA)
    np.testing.assert_allclose(rise, expected, rtol=QUADRATURE, atol=1e-12 * rise.max())


@pytest.mark.parametrize(("half_x", "half_y", "peclet"), [(1e-4, 1e-4, 1.0), (1e-4, 4e-4, 3.0)])
def test_a_moving_ellipse_is_the_sum_of_its_points(half_x, half_y, peclet):
    """Integral over rows of point sources q exp(−V(r − x + x')/(2κ))/(2πKr) at distance r."""
    velocity = peclet * 2 * KAPPA / half_x

    def rise(x):
        def row_conditions(y):
            reach = half_x * math.sqrt(1 - (y / half_y) ** 2)

            def of_point(s):
                r = math.hypot(x - s, y)
                flux = math.sqrt(max(1 - (s / half_x) ** 2 - (y / half_y) ** 2, 0.0))
                return flux * math.exp(-velocity * (r - x + s) / (2 * KAPPA)) / r

            near = [p for p in (x - 10 * y, x - y, x, x + y, x + 10 * y) if -reach < p < reach]
            return integrate.quad(of_point, -reach, reach, points=near, limit=200)[0]

        # Substitute y = half_y·u³, as rows near the point warm it as −ln y.
        rows = integrate.quad(
            lambda u: row_conditions(half_y * u**3) * 3 * half_y * u**2, 0, 1, epsrel=1e-7
        )[0]
        return 2 * rows / (2 * math.pi * K)

    highest = optimize.minimize_scalar(
        lambda x: -rise(x), bounds=(0, half_x), method="bounded", options={"xatol": 1e-3 * half_x}
    )
    exact = analytic.moving_ellipse_rise(1.0, half_x, half_y, velocity, K, KAPPA)
    assert exact == pytest.approx(-highest.fun, rel=1e-5)


@pytest.mark.parametrize("peclet", [0.1, 3.0, 100.0])
def test_a_moving_circle_is_that_of_tian_and_kennedy(peclet):
    velocity = peclet * 2 * KAPPA / 1e-4
    fit = 2.32 * 1e9 * 1e-4 / (K * math.sqrt(math.pi * (1.234 + peclet)))
    rise = analytic.moving_ellipse_rise(1.5e9, 1e-4, 1e-4, velocity, K, KAPPA)
    assert rise == pytest.approx(fit, rel=0.012)  # error of the fit between its two limits
