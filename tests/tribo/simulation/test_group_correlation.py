"""The quality of the jackknife (tribo/simulation/group_correlation.py), by random fields."""

from dataclasses import replace

import numpy as np
import pytest
from scipy.special import stdtrit

from tests.helpers.scenes import STEEL, small_scene
from tribo import (
    PRESETS,
    QUANTILES,
    Ball,
    Grid,
    MeasuredRoughness,
    Ramp,
    Scene,
    SelfAffineRoughness,
    Wear,
    simulate,
)
from tribo.constants import FREEDOM_OF_CELLS, HOT_SPOT_POWER
from tribo.simulation import fit_elements, heat, jackknife_quality
from tribo.simulation.surface_groups import surface_groups

NINE_TENTHS = QUANTILES.index(0.9)
WINDOWS = {
    "line": Grid((48, 64), (4e-6, 4e-6), (False, True)),
    "ball": Grid((64, 64), (8e-6, 8e-6), (False, False)),
}


def scene_of(window, lengths):
    """Scene with a random surface of these correlation lengths along x and y [µm]."""
    rough = SelfAffineRoughness(0.27e-6, 0.8, tuple(1e-6 * length for length in lengths))
    scene = replace(small_scene(), pixels=WINDOWS["line"], roughness=rough, wear=None)
    if window == "line":
        return scene
    return replace(scene, pin=Ball(5e-3, scene.disk), pixels=WINDOWS["ball"])


def quality_of_fields(scene, count=2000):
    """Degrees of freedom and factor of the jackknife of means of random fields."""
    shape = scene.grid.shape
    surfaces = [replace(scene.roughness, seed=seed).heights(scene.pixels) for seed in range(200)]
    covariance = np.fft.irfft2(sum(np.abs(np.fft.rfft2(z)) ** 2 for z in surfaces), shape)
    spots = np.maximum(covariance / covariance[0, 0], 0.0) ** HOT_SPOT_POWER
    amplitude = np.sqrt(np.maximum(np.fft.rfft2(spots).real, 0.0))
    noise = np.random.default_rng(4).standard_normal((count, *shape))
    fields = np.fft.irfft2(amplitude * np.fft.rfft2(noise), shape).reshape(count, -1)
    is_left_out = surface_groups(scene).ravel() == np.arange(8)[:, None]
    without = ~is_left_out @ fields.T / (~is_left_out).sum(axis=1)[:, None]
    estimates = 7 / 8 * np.square(without - without.mean(axis=0)).sum(axis=0)
    factor = fields.mean(axis=1).std() / np.sqrt(estimates.mean())
    return 2 * estimates.mean() ** 2 / estimates.var(), factor


@pytest.mark.parametrize(
    ("window", "lengths"),
    [("line", (8, 8)), ("line", (8, 32)), ("line", (8, 64)), ("line", (64, 8)), ("ball", (8, 32))],
)
def test_factor_and_degrees_of_freedom_are_those_of_random_fields(window, lengths):
    scene = scene_of(window, lengths)
    freedom, factor = quality_of_fields(scene)
    if window == "ball":
        freedom = FREEDOM_OF_CELLS
    assert jackknife_quality(scene) == pytest.approx((freedom, factor), rel=0.05)


@pytest.mark.parametrize(
    ("load", "wear", "realizations"),
    [(60.0, None, 20), pytest.param(150.0, Wear(1.2e-15), 8, marks=pytest.mark.slow)],
)
def test_a_ball_on_a_lay_states_at_most_five_times_how_its_realizations_differ(
    load, wear, realizations
):
    window = Grid((80, 80), (5.2e-6, 5.2e-6), (False, False))
    ball = Scene(
        pin=Ball(5e-3, STEEL), disk=STEEL, pixels=window, loading=Ramp(100.0, 200.0), wear=wear,
        fidelity=PRESETS["standard"],
    )  # fmt: skip
    rises, bounds = [], []
    for seed in range(realizations):
        ground = SelfAffineRoughness(0.15e-6, 0.8, (6e-6, 45e-6), seed)
        scene = replace(ball, roughness=ground)
        *_, state = simulate(scene, load, 1.5)
        sampling = heat(fit_elements(scene, load), state, 1.5, is_sampled=True).sampling
        level = stdtrit(sampling["rise_realization_freedom"], 0.975)
        rises.append(state.heat.rise_quantile[NINE_TENTHS])
        bounds.append(level * sampling["rise_realization_std"][NINE_TENTHS])
    levels, bounds = np.log(rises), np.array(bounds)
    errors = np.abs(levels - levels.mean()) * np.sqrt(realizations / (realizations - 1))
    assert np.mean(errors <= bounds) >= 0.95
    assert 0.8 < np.median(bounds) / (1.96 * levels.std(ddof=1)) < 5


def test_a_scan_of_a_surface_has_about_the_quality_of_the_surface():
    for lengths in ((8, 8), (8, 32), (8, 64)):
        scene = scene_of("line", lengths)
        scan = MeasuredRoughness(scene.roughness.heights(scene.pixels))
        expected = jackknife_quality(scene)
        assert jackknife_quality(replace(scene, roughness=scan)).factor == pytest.approx(
            expected.factor, rel=0.35
        )


def mirrored(heights, shape):
    """Heights that fill a window of this shape, mirrored at their far edges."""
    padding = [(0, size - number) for size, number in zip(shape, heights.shape, strict=True)]
    return MeasuredRoughness(np.pad(heights, padding, "symmetric"))


def test_four_strips_and_their_mirror_images_count_as_four():
    """Of eight values, which are four twice, the jackknife has 3/7 of the variance of the mean."""
    scene = scene_of("line", (8, 8))
    heights = scene.roughness.heights(scene.pixels)
    freedom, factor = jackknife_quality(replace(scene, roughness=MeasuredRoughness(heights)))
    half = mirrored(heights[:, :32], heights.shape)
    expected = 3, pytest.approx(factor * np.sqrt(7 / 3), rel=0.2)
    quality = jackknife_quality(replace(scene, roughness=half))
    assert (round(quality.freedom), quality.factor) == expected
    eighth = mirrored(heights[:, :8], heights.shape)
    assert jackknife_quality(replace(scene, roughness=eighth)).freedom == 0
    # Strips cross the window along x, and differ by as much as realizations do.
    along_x = jackknife_quality(replace(scene, roughness=mirrored(heights[:24], heights.shape)))
    assert along_x == pytest.approx((freedom, factor), rel=0.2)


def test_mirror_images_under_a_ball_make_groups_alike_on_elements_of_any_size():
    scene = scene_of("ball", (8, 8))
    heights = scene.roughness.heights(scene.pixels)
    scan = replace(scene, roughness=MeasuredRoughness(heights))
    factor = jackknife_quality(scan).factor
    quarter = replace(scene, roughness=mirrored(heights[:32, :32], heights.shape))
    assert jackknife_quality(quarter).factor > 1.4 * factor
    coarse = replace(quarter, fidelity=replace(scene.fidelity, pixels_per_element=2))
    assert jackknife_quality(coarse).factor == pytest.approx(
        jackknife_quality(quarter).factor, rel=0.3
    )


def test_grooves_through_the_window_leave_the_deviation_unknown():
    grooves = np.sin(np.arange(48.0))[:, None] * np.ones(64)
    scene = replace(scene_of("line", (4, 4)), roughness=MeasuredRoughness(1e-7 * grooves))
    assert jackknife_quality(scene).freedom == 0
    *_, state = simulate(scene, 200.0, 2.0)
    sampling = heat(scene, state, 2.0, is_sampled=True).sampling
    assert np.isinf(sampling["rise_realization_std"]).all()
    assert sampling["rise_realization_freedom"] == 0


def test_a_smooth_and_a_flat_disk_have_all_degrees_of_freedom():
    flat = replace(scene_of("line", (4, 4)), roughness=MeasuredRoughness(np.zeros((48, 64))))
    for scene in (replace(flat, roughness=None), flat):
        assert jackknife_quality(scene) == (7.0, 1.0)


def test_realizations_and_wear_share_a_quality_but_for_local_wear():
    scene = scene_of("line", (8, 32))
    quality = jackknife_quality(scene)
    other = replace(scene.roughness, seed=7, ra=0.1e-6)
    swept = replace(scene, roughness=other, wear=Wear(1e-15))
    assert jackknife_quality(swept) == quality
    local = jackknife_quality(replace(scene, wear=Wear(1e-15, "local")))
    assert local == (1.0, pytest.approx(2 * quality.factor))


def test_the_stored_deviation_is_the_jackknife_times_its_factor():
    scene = scene_of("line", (8, 64))
    *_, state = simulate(scene, 200.0, 2.0)
    sampled = heat(scene, state, 2.0, is_sampled=True)
    without = sampled.quantile_without[:, 8]
    estimate = np.sqrt(7 / 8 * np.square(without - without.mean()).sum()) / without.mean()
    expected = jackknife_quality(scene).factor * estimate
    assert sampled.sampling["rise_realization_std"][8] == pytest.approx(expected, rel=1e-9)
