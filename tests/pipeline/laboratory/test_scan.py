"""A scan, and the random roughness that makes more of the same."""

import tomllib

import numpy as np
import pytest
from scipy import ndimage

from pipeline import SceneFileError, load_scene, surface_statistics, to_si
from tribo import Grid
from tribo.simulation.lubrication import surface_facts
from tribo.surface import self_affine
from tribo.surface.areal import areal_roughness

GRID = Grid((240, 192), (0.8e-6, 0.9e-6))


@pytest.fixture(scope="module")
def scan(tmp_path_factory):
    """Path of a file with a tilted scan [µm], which has a lay across x."""
    heights = self_affine(GRID, 0.27e-6, 0.8, (4e-6, 12e-6), seed=0)
    i, j = np.indices(heights.shape)
    path = tmp_path_factory.mktemp("scan") / "scan.npy"
    np.save(path, 1e6 * (heights + 5e-2 * i * 0.8e-6 - 3e-2 * j * 0.9e-6).T)
    return path


def test_the_tilt_is_taken_off_and_the_printed_table_makes_the_same(scan):
    statistics = surface_statistics(scan, "um", ("0.8 um", "0.9 um"))
    assert statistics.roughness.slopes == pytest.approx((5e-2, -3e-2), abs=2e-3)
    scatter = dict(statistics.likeness)["Rq"].scatter
    assert statistics.ra == pytest.approx(0.27e-6, rel=3 * scatter)
    assert abs(statistics.roughness.lay) == pytest.approx(90.0, abs=5)
    table = tomllib.loads(statistics.toml)["disk"]["roughness"]
    lengths = tuple(to_si(length, "1 um") for length in table["correlation_length"])
    ra = to_si(table["ra"], "1 um")
    again = self_affine(GRID, ra, table["hurst_exponent"], lengths, seed=8)
    np.save(scan.with_name("again.npy"), again.T)
    other = surface_statistics(scan.with_name("again.npy"), 1.0, GRID.spacing)
    assert other.ra == pytest.approx(statistics.ra, rel=0.01)
    assert other.rq == pytest.approx(statistics.rq, rel=4 * scatter)
    # The lengths of eight such surfaces scatter by 12 %, exponents by 6 %; differences by √2 more.
    assert other.fit.correlation_length == pytest.approx(statistics.fit.correlation_length, rel=0.5)
    assert other.fit.hurst_exponent == pytest.approx(statistics.fit.hurst_exponent, rel=0.25)


def test_a_scene_turns_its_scan_and_answers_a_narrow_one_with_mirror(scan):
    surface = {
        "without": "disk.roughness",
        "disk.roughness.file": str(scan),
        "disk.roughness.height_unit": "um",
        "window.pixels": [192, 240],
    }
    turned = {"disk.roughness.transpose": True, "disk.roughness.flip": True}
    sweep = load_scene("first_try", overrides=surface | turned)
    assert np.array_equal(sweep.scene.roughness.array, -1e-6 * np.load(scan))
    with pytest.raises(SceneFileError, match="by crop, repeat or transpose of"):
        load_scene("first_try", overrides=surface)
    wide = surface | {"window.pixels": [480, 192]}
    with pytest.raises(SceneFileError, match="by crop, repeat or transpose of"):
        load_scene("first_try", overrides=wide)
    load_scene("first_try", overrides=wide | {"disk.roughness.repeat": "mirror"})


def test_a_filtered_scan_gets_no_random_roughness_in_its_place(tmp_path, irg):
    noise = np.random.default_rng(0).standard_normal((200, 240))
    np.save(tmp_path / "scan.npy", 1e-7 * ndimage.gaussian_filter(noise, 3, mode="wrap"))
    options = ["--height-unit", "m", "--pixel-size", "0.8 um"]
    printed = irg("surface", tmp_path / "scan.npy", *options)
    assert "use the scan itself" in printed
    assert "[disk.roughness]" not in printed
    assert "its spectrum is off the best fit by a factor" in printed
    assert "x, the sliding direction, goes from column to column" in printed
    document = irg("surface", tmp_path / "scan.npy", *options, "--json")
    assert document["toml"] is None
    # White noise after a Gauss filter of 3 pixels: the autocorrelation is exp(−r²/4σ²).
    assert document["roughness"]["sal"] == pytest.approx(2 * 3 * 0.8e-6, rel=0.1)


def test_heights_too_flat_and_too_rough_are_doubted(scan):
    sides = "0.8 um", "0.9 um"
    flat = surface_statistics(scan, "fm", sides).warnings
    assert any("check the unit of the heights" in doubt for doubt in flat)
    rough = surface_statistics(scan, "mm", sides).warnings
    assert any("check the unit of the heights" in doubt for doubt in rough)
    assert surface_statistics(scan, "um", sides).warnings == ()


def likely(seed, lengths=(6e-6, 6e-6), ra=0.3e-6, hurst=0.8, shape=(384, 384)):
    return self_affine(Grid(shape, (0.5e-6, 0.5e-6)), ra, hurst, lengths, seed=seed)


def test_random_surfaces_are_like_a_random_one_and_scatter_as_said(tmp_path):
    np.save(tmp_path / "scan.npy", likely(1))
    found = surface_statistics(tmp_path / "scan.npy", 1.0, ("0.5 um", "0.5 um"))
    likeness = dict(found.likeness)
    assert {*likeness} == {"Rq", "Sal", "Str"}
    assert found.is_like
    assert "Sal of the fit" in str(found)
    others = [areal_roughness(likely(seed), (0.5e-6, 0.5e-6)).sal for seed in range(12, 24)]
    scatter = np.std(others, ddof=1) / np.mean(others)
    # Standard deviations of 8 and of 12 surfaces differ by less than a factor 3 (F test, 1 %).
    assert scatter / 3 < likeness["Sal"].scatter < 3 * scatter


def test_a_ground_surface_is_unlike_isotropic_ones_and_says_so(tmp_path):
    """Random grooves longer than the scan have no fitted spectrum, but a lay and a Str."""
    profile = likely(2)[:, :1]
    np.save(tmp_path / "ground.npy", np.tile(profile, (1, 384)).T + 0.1 * likely(3))
    found = surface_statistics(tmp_path / "ground.npy", 1.0, ("0.5 um", "0.5 um"))
    assert abs(found.roughness.lay) == pytest.approx(90, abs=3)
    assert found.roughness.aspect < 0.2
    assert f"lay                 {found.roughness.lay:.0f}° from x" in str(found)


def test_a_curvature_is_taken_off_and_told_with_its_radius(tmp_path):
    x = (np.arange(384) - 191.5) * 0.5e-6
    curved = likely(4) - (x**2 / (2 * 4e-3))[:, None]
    np.save(tmp_path / "roller.npy", curved.T)
    sides = "0.5 um", "0.5 um"
    found = surface_statistics(tmp_path / "roller.npy", 1.0, sides)
    np.save(tmp_path / "flat.npy", likely(4).T)
    flat = surface_statistics(tmp_path / "flat.npy", 1.0, sides)
    assert found.roughness.radii[0] == pytest.approx(4e-3, rel=0.05)
    assert found.ra == pytest.approx(flat.ra, rel=0.02)
    assert "curvature           R 4" in str(found)
    assert "give a pin's radius as pin.radius" in str(found)
    assert "curvature  " not in str(flat)


def test_a_scene_takes_what_the_command_takes_and_describes_the_same(tmp_path, irg):
    np.save(tmp_path / "scan.npy", likely(1).T / 1e-6)
    command = irg("surface", tmp_path / "scan.npy", "--height-unit", "um",
                  "--pixel-size", "0.5 um", "--json")  # fmt: skip
    surface = {
        "without": "disk.roughness",
        "disk.roughness.file": str(tmp_path / "scan.npy"),
        "disk.roughness.height_unit": "um",
        "disk.roughness.pixel_size": ["0.5 um", "0.5 um"],
        "disk.roughness.level": True,
        "window.pixels": [384, 384],
        "window.pixel_size": ["0.5 um", "0.5 um"],
    }
    facts = surface_facts(load_scene("first_try", overrides=surface).scene)
    rough = command["roughness"]
    assert (facts.ra, facts.rq) == pytest.approx((rough["ra"], rough["rq"]), rel=1e-9)
    with pytest.raises(SceneFileError, match=r"the pixels of disk\.roughness\.file are"):
        load_scene("first_try", overrides=surface | {"window.pixel_size": ["1 um", "0.5 um"]})


def sine(amplitude, period, length, step):
    """Places and heights [µm] of a sine on a slope."""
    x = np.arange(0, length, step)
    return x, amplitude * np.sin(2 * np.pi * x / period) + 0.01 * x


def test_a_profile_has_the_roughness_of_its_formula(tmp_path, irg):
    x, z = sine(1.0, 60.0, 4000.0, 0.5)
    path = tmp_path / "profile.txt"
    np.savetxt(path, np.stack([x / 1e3, z], axis=1), "%.5f", header="X [mm]  Z [um]", comments="")
    found = irg("surface", path, "--json")
    assert found["cutoff"] == 0.8e-3
    # The filter leaves 1 − 2^(−(λc/λ)²) of a sine, nearly all here.
    assert found["ra"] == pytest.approx(2e-6 / np.pi, rel=0.01)
    assert found["rq"] == pytest.approx(1e-6 / np.sqrt(2), rel=0.01)
    assert found["rz"] == pytest.approx(2e-6, rel=0.02)
    assert found["rsm"] == pytest.approx(60e-6, rel=0.01)
    half = irg("surface", path, "--json", "--cutoff", "0.06 mm")
    assert half["rq"] == pytest.approx(0.5e-6 / np.sqrt(2), rel=0.02)  # 50 % at the cutoff


@pytest.mark.parametrize(("ra", "cutoff"), [(0.015, 0.08), (0.08, 0.25), (1.5, 0.8), (5.0, 2.5)])
def test_the_cutoff_is_that_of_the_profile_s_own_ra(tmp_path, irg, ra, cutoff):
    x, z = sine(ra * np.pi / 2, 30.0, 12500.0 * cutoff / 2.5, 0.5)
    np.savetxt(tmp_path / "p.csv", np.stack([x, z], axis=1), "%.5f", delimiter=",")
    units = "--height-unit", "um", "--length-unit", "um"
    assert irg("surface", tmp_path / "p.csv", *units, "--json")["cutoff"] == cutoff * 1e-3


def test_rounded_places_several_profiles_and_few_sections_are_told(tmp_path, irg):
    x, z = sine(1.0, 60.0, 1700.0, 1 / 3)
    table = np.stack([np.round(x, 1), z, 2 * z], axis=1)
    np.savetxt(tmp_path / "p.txt", table, "%.4f")
    units = "--height-unit", "um", "--length-unit", "um"
    said = irg("surface", tmp_path / "p.txt", *units)
    assert f"2 profiles of {len(x)} heights" in said
    assert "2 of 5 sections: the profile is short" in said
    assert "unfiltered; measure 4 mm" in irg(
        "surface", tmp_path / "p.txt", "--height-unit", "um",
        "--length-unit", "nm",
    )  # fmt: skip


RANDOM = 1e6 * self_affine(Grid((8000, 128), (5e-7, 5e-7)), 0.27e-6, 0.7, (6e-6, 6e-6), seed=3)


@pytest.fixture
def profile(tmp_path, irg):
    """Function that prints what `irg surface` finds of heights [µm] in steps of 0.5 µm."""

    def ask(*heights, options=()):
        columns = [0.5 * np.arange(len(heights[0])), *heights]
        np.savetxt(tmp_path / "p.txt", np.stack(columns, axis=1), "%.4f")
        units = "--height-unit", "um", "--length-unit", "um"
        return irg("surface", tmp_path / "p.txt", *units, *options, "--json")

    return ask


def test_a_profile_of_a_random_surface_makes_surfaces_like_it(profile, tmp_path):
    lines = RANDOM[:, 0], RANDOM[:, 64]
    for options, lay in (((), None), (("--lay", "60 um"), "60 um")):
        found = profile(*lines, options=options)
        (tmp_path / "a.toml").write_text(
            f'extends = "first_try"\nwithout = ["disk.roughness"]\n{found["toml"]}'
        )
        rough = load_scene(tmp_path / "a.toml").scene.roughness
        # Of eight such profiles the lengths scatter by 8 %, the exponents by 0.04.
        assert rough.correlation_length[0] == pytest.approx(6e-6, rel=0.25)
        assert rough.hurst_exponent == pytest.approx(0.7, abs=0.12)
        across, along = rough.correlation_length
        assert along == (across if lay is None else to_si(lay, "1 um"))
        assert any("lay" in note for note in found["notes"])
    assert found["likeness"]["RSm"]["is_like"]


@pytest.mark.parametrize(
    ("heights", "why"),
    [
        (RANDOM[:, 0] + 0.4 * sine(1.0, 60.0, 4000.0, 0.5)[1], "it repeats every 59.7 µm"),
        (np.minimum(RANDOM[:, 0], 0.1), "its Rp and Rv differ"),
        (ndimage.gaussian_filter(RANDOM[:, 0], 4), "its spectrum is off the best fit by a factor"),
        (RANDOM[:50, 0], "50 heights are too few for a spectrum"),
    ],
    ids=["turned", "honed", "filtered", "short"],
)
def test_a_profile_that_no_random_surface_has_says_why(profile, heights, why):
    found = profile(heights)
    assert found["toml"] is None
    assert why in found["fault_of_fit"]


def test_a_data_sheet_makes_random_surfaces_with_its_rsm(tmp_path, irg):
    found = irg("surface", "--ra", "0.2 um", "--rsm", "60 um", "--json")
    table = tomllib.loads(found["toml"])["disk"]["roughness"]
    assert (table["ra"], table["hurst_exponent"]) == ("0.2 um", 0.8)
    length = to_si(table["correlation_length"], "1 um")
    heights = self_affine(Grid((512, 512), (0.95e-6, 0.95e-6)), 0.2e-6, 0.8, (length, length), 9)
    x = 0.95e-6 * np.arange(512)
    path = tmp_path / "lines.txt"
    np.savetxt(path, np.column_stack([x, heights[:, ::50]])[:, :11] * 1e6, "%.6f")
    units = "--height-unit", "um", "--length-unit", "um"
    again = irg("surface", path, *units, "--cutoff", "none", "--json")
    assert again["rsm"] == pytest.approx(60e-6, rel=0.25)  # eleven lines of some eight elements
    (tmp_path / "a.toml").write_text(
        f'extends = "first_try"\nwithout = ["disk.roughness"]\n{found["toml"]}'
    )
    assert load_scene(tmp_path / "a.toml").scene.roughness.ra == 0.2e-6
