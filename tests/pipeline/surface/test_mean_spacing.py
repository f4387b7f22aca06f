"""Correlation lengths by RSm, against elements of other profiles counted one by one."""

import numpy as np
import pytest

from pipeline import load_scene
from pipeline.surface.mean_spacing import correlation_lengths, mean_spacing

PIXELS, PROFILES = 512, 300
SIDES = 1.632e-6, 1.9e-6


def profiles_along(axis, lengths, sides, hurst, seed=8):
    """Normal profiles with the power spectrum of a self-affine surface, summed across them."""
    waves = [2 * np.pi * np.fft.fftfreq(PIXELS, side) * length for side, length in zip(
        sides, lengths, strict=True)]  # fmt: skip
    power = (1 + waves[axis][:, None] ** 2 + waves[1 - axis] ** 2) ** -(1 + hurst)
    power[0, 0] = 0.0
    noise = np.random.default_rng(seed).standard_normal((PROFILES, PIXELS))
    return np.fft.ifft(np.fft.fft(noise) * np.sqrt(power.sum(axis=1))).real


def rises_of(profile, limit):
    """Places of rises through 0 between a valley and a peak that both exceed a limit."""
    rises, rise, was_low = [], None, False
    for k in range(1, len(profile)):
        before, after = profile[k - 1], profile[k]
        if before < 0 <= after:
            rise = k - 1 + before / (before - after)
        if after > limit and was_low:
            rises.append(rise)
        if abs(after) > limit:
            was_low = after < 0
    return rises


def width_of_elements(profile, limit):
    """Mean width of elements that begin with a peak, and of those that begin with a valley."""
    places = (rises_of(side.tolist(), limit) for side in (profile, -profile))
    widths = np.concatenate([np.diff(ends) for ends in places])
    return widths.mean() if widths.size else len(profile)


def measured_rsm(axis, lengths, sides, hurst=0.8):
    spacings = []
    for profile in profiles_along(axis, lengths, sides, hurst):
        rz = np.mean([section.max() - section.min() for section in np.array_split(profile, 5)])
        spacings.append(width_of_elements(profile, 0.1 * rz) * sides[axis])
    return np.mean(spacings)


@pytest.mark.parametrize(("rsm", "hurst"), [(20e-6, 0.8), (60e-6, 0.8), (40e-6, 0.5)])
def test_profiles_of_a_surface_without_a_lay_have_the_rsm(rsm, hurst):
    lengths = correlation_lengths(rsm, hurst, (0.816e-6, 0.95e-6))
    assert lengths[0] == lengths[1]
    assert measured_rsm(0, lengths, (0.95e-6, 0.95e-6), hurst) == pytest.approx(rsm, rel=0.04)


def test_profiles_along_and_across_grooves_have_both_rsm():
    rsm = 30e-6, 200e-6
    lengths = correlation_lengths(rsm, 0.8, SIDES)
    for axis in (0, 1):
        assert measured_rsm(axis, lengths, SIDES) == pytest.approx(rsm[axis], rel=0.08)
    # Profiles along the grooves of equal surfaces, alone, have a shorter length.
    assert lengths[1] < 0.95 * correlation_lengths(rsm[1], 0.8, (SIDES[1],) * 2)[0]


def test_elements_lower_than_a_tenth_of_rz_are_not_counted():
    x = np.arange(4000)
    wave, ripple = np.sin(2 * np.pi * x / 200), 0.05 * np.sin(2 * np.pi * x / 7)
    assert mean_spacing(wave + ripple, 1.0, 0.2) == pytest.approx(200, rel=1e-3)
    assert mean_spacing(wave + ripple, 1.0, 0.001) < 190


def test_elements_of_a_short_profile_end_between_its_heights():
    for wavelength in (7.37, 9.61, 13.3):
        profile = np.sin(2 * np.pi * np.arange(40) / wavelength + 0.3)
        assert mean_spacing(profile, 1.0, 0.2) == pytest.approx(wavelength, rel=0.02)


def test_a_scene_with_rsm_is_the_scene_with_the_length_that_follows():
    by_rsm = load_scene("first_try", overrides={"disk.roughness.rsm": "60 um"})
    (length, _) = by_rsm.scene.roughness.correlation_length
    assert length == correlation_lengths(60e-6, 0.8, (0.816e-6, 0.95e-6))[0]
    stated = f"{length!r} m"
    by_length = by_rsm.changed("disk.roughness.correlation_length", stated)
    assert by_length.scene == by_rsm.scene
    words = f"a correlation length of {1e6 * length:.3g} µm"
    assert any(words in note.text for note in by_rsm.notes)
