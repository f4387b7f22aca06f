"""Surfaces from plain files (pipeline/laboratory/plain_scan.py, text_scan.py)."""

import numpy as np
import pytest

from pipeline.laboratory.surfaces import read_surface


@pytest.mark.parametrize("suffix", [".npy", ".csv"])
def test_measured_heights_are_read_in_their_unit_with_x_from_column_to_column(tmp_path, suffix):
    path = tmp_path / f"disk{suffix}"
    heights = np.array([[1.0, 2.0, 3.0], [4.0, 5.0, 6.5]])
    if suffix == ".npy":
        np.save(path, heights)
    else:
        path.write_bytes(b"\xef\xbb\xbf1,2,3\n4,5,6.5\n")  # with a byte order mark
    assert read_surface(path, 1e-6).heights == pytest.approx(heights.T * 1e-6)
