"""Areas of a scan as surfaces of a scene: levelled, filled and mirrored."""

import numpy as np
import pytest

from pipeline import SceneFileError, load_scene
from pipeline.surface.window import filled
from tribo.surface.areal import remove_form

HEIGHTS = np.random.default_rng(5).normal(0.0, 3e-7, (48, 40))
SIDES = 0.8e-6, 0.95e-6


@pytest.fixture
def scene(tmp_path):
    """Function that loads a scene with a scan."""

    def load(pixels=(48, 40), heights=HEIGHTS, realizations=None, **table):
        np.save(tmp_path / "a.npy", heights.T)
        table = {"file": str(tmp_path / "a.npy"), "height_unit": "m"} | table
        entries = {
            "window.pixels": list(pixels), "window.pixel_size": ["0.8 um", "0.95 um"],
            "sweep.realizations": realizations,
        } | {f"disk.roughness.{key}": value for key, value in table.items()}  # fmt: skip
        known = {path: value for path, value in entries.items() if value is not None}
        return load_scene("first_try", overrides={"without": "disk.roughness"} | known)

    return load


def test_a_scene_takes_an_area_levelled_and_filled(scene):
    holed = HEIGHTS.copy()
    holed[10, 12] = holed[20, 20] = np.nan
    sweep = scene((40, 32), holed, level=True)
    part, *_ = remove_form(holed[4:44, 4:36], SIDES)  # from the middle
    expected = filled(part, 0.1)
    np.testing.assert_array_equal(sweep.scene.roughness.array, expected)
    assert expected[6, 8] == pytest.approx(expected[[5, 7, 6, 6], [8, 8, 7, 9]].mean())
    words = (
        r"2 of 1280 heights \(0\.16 %\) are missing, the first at x 6, y 8 \(counted from 0\); "
        r"at most 0\.01 % are filled; measure again, or allow more \(missing\)$"
    )
    with pytest.raises(SceneFileError, match=words):
        scene((40, 32), holed, missing=0.0001)


def test_a_curvature_that_is_removed_is_told(scene):
    along_x = SIDES[0] * np.arange(48.0)
    curved = HEIGHTS / 1000 - along_x[:, None] ** 2 / 2e-3
    *_, note = scene(heights=curved, level=True).notes
    assert note.text == "disk.roughness.file: curvature removed: R 1 mm along x"


@pytest.mark.parametrize("share", [0.02, 0.5])
def test_missing_heights_are_the_mean_of_their_neighbours(share):
    """Fields z = x² − y² and xy have this mean inside, where no edge is missing."""
    x, y = np.meshgrid(np.arange(30.0), np.arange(20.0), indexing="ij")
    for heights in (x**2 - y**2, x * y):
        holed = heights.copy()
        holed[1:-1, 1:-1][np.random.default_rng(3).random((28, 18)) < share] = np.nan
        np.testing.assert_allclose(filled(holed, 1.0), heights, rtol=1e-9, atol=1e-9)


def test_realizations_of_a_scan_are_its_areas(scene):
    """The scan of 48 × 40 has 3 × 2 areas of 14 × 18, in its middle, along x first."""
    sweep = scene((14, 18), realizations=6)
    areas = [HEIGHTS[i : i + 14, j : j + 18] for j in (2, 20) for i in (3, 17, 31)]
    assert [case.name for case in sweep.cases] == [(("realization", k),) for k in range(6)]
    for case, area in zip(sweep.cases, areas, strict=True):
        np.testing.assert_array_equal(case.scene.roughness.array, area)
    listed = scene((14, 18), realizations=[5, 2])
    assert [dict(case.name)["realization"] for case in listed.cases] == [2, 5]
    assert listed.scene == listed.cases[0].scene == sweep.cases[2].scene
    assert sweep.take_surface(4).scene == sweep.cases[4].scene
    words = (
        "the scan has 6 areas of 14 × 18 heights, numbered from 0; there is no area 6: give fewer "
        r"sweep\.realizations, or fewer window\.pixels$"
    )
    for numbers in (7, [0, 6]):
        with pytest.raises(SceneFileError, match=words):
            scene((14, 18), realizations=numbers)


def test_a_scan_smaller_than_the_window_is_mirrored_if_asked_to(scene):
    wide = scene((96, 20), mirror=True, realizations=2)
    for case, part in zip(wide.cases, (HEIGHTS[:, :20], HEIGHTS[:, 20:]), strict=True):
        np.testing.assert_array_equal(case.scene.roughness.array[:48], part)
        np.testing.assert_array_equal(case.scene.roughness.array[48:], part[::-1])
