"""Where the names of the regions of a diagram stand (pipeline/figures/regions.py)."""

import numpy as np
import pytest
from scipy.ndimage import distance_transform_edt

from pipeline.figures.regions import _distances


@pytest.mark.parametrize("share", [0.0, 0.3, 0.9, 0.99, 1.0])
@pytest.mark.parametrize("shape", [(1, 5), (2, 3), (50, 70)])
def test_distances_to_the_edges_of_a_region_are_those_of_scipy(shape, share):
    inside = np.random.default_rng(0).random(shape) < share
    expected = distance_transform_edt(np.pad(inside, 1), sampling=(0.3, 0.7))[1:-1, 1:-1]
    np.testing.assert_allclose(_distances(inside, (0.3, 0.7)), expected, rtol=1e-12)
