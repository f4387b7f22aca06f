"""What a scene takes of a scan, and the command that prints a table of a scene."""

import tomllib

import numpy as np
import pytest

from pipeline import SceneFileError, load_scene, to_si
from pipeline.surface.scan import Scan
from pipeline.surface.window import filled
from tribo.surface.areal import remove_form

HEIGHTS = np.random.default_rng(5).normal(0.0, 3e-7, (48, 40))
SIDES = 0.8e-6, 0.95e-6


@pytest.fixture
def scene(tmp_path):
    """Function that loads a scene with a scan."""

    def load(pixels=(48, 40), heights=HEIGHTS, **table):
        np.save(tmp_path / "a.npy", heights.T)
        table = {"file": str(tmp_path / "a.npy"), "height_unit": "m"} | table
        return load_scene("first_try", overrides={
            "without": "disk.roughness", "window.pixels": list(pixels),
            "window.pixel_size": ["0.8 um", "0.95 um"],
        } | {f"disk.roughness.{key}": value for key, value in table.items()})  # fmt: skip

    return load


def test_a_scene_takes_a_patch_levelled_and_filled(scene):
    holed = HEIGHTS.copy()
    holed[10, 12] = holed[20, 20] = np.nan
    sweep = scene((40, 32), holed, crop=[4, 6], level=True)
    patch, *_ = remove_form(holed[4:44, 6:38], SIDES)
    expected = filled(Scan(patch, SIDES), 0.1)
    np.testing.assert_array_equal(sweep.scene.roughness.array, expected)
    assert expected[6, 6] == pytest.approx(expected[[5, 7, 6, 6], [6, 6, 5, 7]].mean())
    assert any("2 of 1280 heights (0.16 %) are missing and were filled" in note.words
               for note in sweep.notes)  # fmt: skip
    with pytest.raises(SceneFileError, match=r"at most 0\.01 % are filled"):
        scene((40, 32), holed, crop=[4, 6], missing=0.0001)


def test_a_scan_of_another_size_is_refused_or_continued(scene):
    for pixels, table, words in (
        ((40, 48), {}, "by crop or repeat of"),
        ((48, 40), {"crop": [1, 0]}, "extends beyond"),
        ((48, 40), {"pixel_size": ["1 um", "0.95 um"]}, "give those, window.pixel_size"),
    ):
        with pytest.raises(SceneFileError, match=words):
            scene(pixels, **table)
    wide = scene((96, 40), repeat="mirror").scene.roughness.array
    np.testing.assert_array_equal(wide[48:], wide[:48][::-1])


def test_ra_and_rsm_of_a_profile_make_a_table(irg):
    found = irg("surface", "--ra", "0.2 um", "--rsm", "60 um", "--json")
    table = tomllib.loads(found["toml"])["disk"]["roughness"]
    assert (table["ra"], table["hurst_exponent"]) == ("0.2 um", 0.8)
    assert 1e-6 < to_si(table["correlation_length"], "1 um") < 60e-6
