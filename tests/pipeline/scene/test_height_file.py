"""Surfaces from files (pipeline/scene/height_file.py)."""

import numpy as np
import pytest

from pipeline.scene.height_file import read_heights


@pytest.mark.parametrize("suffix", [".npy", ".csv"])
def test_measured_heights_are_read_in_their_unit_with_x_from_column_to_column(tmp_path, suffix):
    path = tmp_path / f"disk{suffix}"
    heights = np.array([[1.0, 2.0, 3.0], [4.0, 5.0, 6.5]])
    if suffix == ".npy":
        np.save(path, heights)
    else:
        path.write_bytes(b"\xef\xbb\xbf1,2,3\n4,5,6.5\n")  # with a byte order mark
    assert read_heights(path, unit=1e-6) == pytest.approx(heights.T * 1e-6)
