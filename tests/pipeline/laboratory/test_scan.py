"""A scan, and the random roughness that makes more of the same."""

import tomllib

import numpy as np
import pytest
from scipy import ndimage

from pipeline import load_scene, surface_statistics
from pipeline.scene.faults import SceneFileError
from pipeline.scene.units import to_si
from tribo import Grid, InputError
from tribo.surface import self_affine

GRID = Grid((240, 192), (0.8e-6, 0.9e-6))


@pytest.fixture(scope="module")
def scan(tmp_path_factory):
    """Path of a tilted scan with a lay across x, in micrometres."""
    heights = self_affine(GRID, 0.27e-6, 0.8, (4e-6, 12e-6), seed=3)
    i, j = np.indices(heights.shape)
    path = tmp_path_factory.mktemp("scan") / "scan.npy"
    np.save(path, 1e6 * (heights + 5e-2 * i * 0.8e-6 - 3e-2 * j * 0.9e-6).T)
    return path


def test_the_tilt_is_taken_off_and_the_printed_table_makes_the_same(scan):
    statistics = surface_statistics(scan, "um", ("0.8 um", "0.9 um"))
    assert statistics.tilt == pytest.approx(np.degrees((5e-2, -3e-2)), abs=0.06)
    assert statistics.ra == pytest.approx(0.27e-6, rel=2 * statistics.fit.rms_error)
    assert statistics.fit.lay == pytest.approx(90.0, abs=2) or statistics.fit.lay == pytest.approx(
        -90, abs=2
    )
    table = tomllib.loads(statistics.toml)["disk"]["roughness"]
    lengths = tuple(to_si(length, "1 um") for length in table["correlation_length"])
    ra = to_si(table["ra"], "1 um")
    again = self_affine(GRID, ra, table["hurst_exponent"], lengths, seed=8)
    np.save(scan.with_name("again.npy"), again.T)
    other = surface_statistics(scan.with_name("again.npy"), 1.0, GRID.spacing)
    assert other.ra == pytest.approx(statistics.ra, rel=0.01)
    assert other.rq == pytest.approx(statistics.rq, rel=2 * statistics.fit.rms_error)
    for one, two, error in zip(
        other.fit.correlation_length,
        statistics.fit.correlation_length,
        statistics.fit.length_error,
        strict=True,
    ):
        assert abs(one - two) < 4 * error
    assert (
        abs(other.fit.hurst_exponent - statistics.fit.hurst_exponent)
        < 4 * statistics.fit.hurst_error
    )


def test_heights_have_the_moments_and_the_unit_that_is_given(tmp_path):
    """Of a fifth of them at 4 and the others at −1 the skewness is 1.5, the kurtosis 3.25."""
    heights = np.random.default_rng(0).permutation(np.repeat([4.0, -1.0], [80, 320]))
    np.save(tmp_path / "scan.npy", heights.reshape(20, 20))
    found = surface_statistics(tmp_path / "scan.npy", "0.5 um", ("1 um", "1 um"))
    # The plane that is taken off such noise moves them by some 3/400 of their variance.
    assert found.rq == pytest.approx(0.5e-6 * 2.0, rel=0.02)
    assert (found.skewness, found.kurtosis) == pytest.approx((1.5, 3.25), rel=0.03)


def test_the_command_prints_the_table_and_says_what_is_missing(scan, irg):
    sides = ["--pixel-size", "0.8 um,0.9 um"]
    document = irg("surface", scan, "--height-unit", "um", *sides, "--json")
    assert document["toml"].startswith("[disk.roughness]")
    assert "no size of a pixel; give pixel_size" in irg(
        "surface", scan, "--height-unit", "um", code=2
    )
    with pytest.raises(InputError, match='"1 kg" cannot be converted'):
        surface_statistics(scan, "kg")


def test_a_scene_turns_its_scan_and_answers_a_narrow_one_with_mirror(scan):
    surface = {
        "without": "disk.roughness",
        "disk.roughness.file": str(scan),
        "disk.roughness.height_unit": "um",
        "window.pixels": [192, 240],
    }
    turned = {"disk.roughness.transpose": True, "disk.roughness.flip": "x"}
    sweep = load_scene("first_try", overrides=surface | turned)
    assert np.array_equal(sweep.scene.roughness.array, 1e-6 * np.load(scan)[::-1])
    with pytest.raises(SceneFileError, match=r"disk\.roughness\.transpose = true"):
        load_scene("first_try", overrides=surface)
    wide = surface | {"window.pixels": [480, 192]}
    with pytest.raises(SceneFileError, match=r'disk\.roughness\.repeat = "mirror"'):
        load_scene("first_try", overrides=wide)
    load_scene("first_try", overrides=wide | {"disk.roughness.repeat": "mirror"})


def test_a_filtered_scan_gets_no_random_roughness_in_its_place(tmp_path, irg):
    noise = np.random.default_rng(0).standard_normal((200, 240))
    np.save(tmp_path / "scan.npy", 1e-7 * ndimage.gaussian_filter(noise, 3, mode="wrap"))
    options = ["--height-unit", "m", "--pixel-size", "0.8 um"]
    printed = irg("surface", tmp_path / "scan.npy", *options)
    assert "use the scan itself" in printed
    assert "[disk.roughness]" not in printed
    assert "correlation length" not in printed  # of the fit, which failed
    assert "x, the sliding direction, is along the columns of the file" in printed
    document = irg("surface", tmp_path / "scan.npy", *options, "--json")
    assert document["fit"] is None
    # White noise after a Gauss filter of 3 pixels: the autocorrelation is exp(−r²/4σ²).
    assert document["lengths"]["along_x"] == pytest.approx(2 * 3 * 0.8e-6, rel=0.1)


def test_heights_too_flat_and_planes_too_steep_are_doubted(scan):
    sides = "0.8 um", "0.9 um"
    flat = surface_statistics(scan, "fm", sides).warnings
    assert any("check the unit of the heights" in doubt for doubt in flat)
    steep = surface_statistics(scan, "mm", sides).warnings
    assert any("tilted by 88" in doubt or "tilted by 89" in doubt for doubt in steep)
    assert surface_statistics(scan, "um", sides).warnings == ()


@pytest.mark.parametrize(
    ("heights", "said"),
    [
        (np.indices((20, 30))[1] * 0.1, "plane.npy: the heights are a plane, without any rough"),
        (np.eye(20) * 1e9, "plane.npy: heights of 1e.03 m; give the unit"),
        (np.eye(10), "plane.npy: 10 × 10 heights are too few"),
    ],
)
def test_what_has_no_roughness_is_refused(heights, said, tmp_path):
    np.save(tmp_path / "plane.npy", heights)
    with pytest.raises(InputError, match=said):
        surface_statistics(tmp_path / "plane.npy", "um", ("1 um", "1 um"))


def test_noise_between_pixels_has_no_length_of_a_fit(tmp_path):
    np.save(tmp_path / "noise.npy", np.random.default_rng(0).normal(size=(40, 50)))
    noise = surface_statistics(tmp_path / "noise.npy", "um", ("1 um", "1 um"))
    assert not noise.is_self_affine
    assert "the fit's lengths err by more than they are" in str(noise)
    assert any("hardly depend on each other" in doubt for doubt in noise.warnings)
    coarse = surface_statistics(tmp_path / "noise.npy", "um", ("1 m", "1 m"))
    assert any("check the size of the pixels" in doubt for doubt in coarse.warnings)


def test_a_scene_says_which_way_x_goes_and_doubts_a_steep_plane(scan):
    turned = {
        "without": "disk.roughness",
        "disk.roughness.file": str(scan),
        "disk.roughness.height_unit": "mm",
        "disk.roughness.level": True,
        "disk.roughness.transpose": True,
        "window.pixels": [192, 240],
    }
    notes = [str(note) for note in load_scene("first_try", overrides=turned).about.notes]
    assert any("x, the sliding direction, is along the rows of the file" in one for one in notes)
    assert any("the scan is tilted by" in one for one in notes)


def test_the_share_of_missing_heights_is_in_percent(tmp_path, scan):
    heights = np.load(scan)
    heights[10:30, 5] = np.nan
    np.save(tmp_path / "holed.npy", heights)
    statistics = surface_statistics(tmp_path / "holed.npy", "um", ("0.8 um", "0.9 um"))
    assert statistics.missing == 20
    share = 100 * 20 / heights.size
    assert f"20 heights ({share:.2g} %) are missing and were filled" in statistics.warnings
