"""What xarray has cut answers as the whole does, or says in a line what is missing."""

import numpy as np
import pytest

from pipeline import boundary, margin
from tests.helpers import synthetic
from tribo import InputError


@pytest.mark.parametrize("step", [-1, [-2, -1], slice(None, -1)])
def test_a_dataset_without_the_ends_of_its_points_decides_nothing(step):
    ds = synthetic.sweep()
    for ask in (boundary, lambda cut: margin(cut, 400.0, 2.0)):
        with pytest.raises(InputError, match="not step 0, the end of each point"):
            ask(ds.sel(step=step))
    assert boundary(ds.sel(step=[-1, 0])).equals(boundary(ds))


def test_the_one_quantile_that_decides_is_enough():
    ds = synthetic.sweep()
    found = boundary(ds.sel(cooler_share=[0.9]))["critical_velocity"]
    np.testing.assert_allclose(found, boundary(ds)["critical_velocity"], rtol=1e-9)
