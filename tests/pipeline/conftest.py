import numpy as np
import pytest

from pipeline.store.create import writing
from pipeline.sweep.plan import points, run_point
from tests.helpers import tiny


def commit_all(path, sweep, skip=()):
    """Make the store of a sweep, computed here and point by point."""
    with writing(path, sweep) as store:
        wanted = [point for point in points(sweep) if point not in skip]
        store.commit(run_point(sweep, *point).record(sweep.store_fields) for point in wanted)


@pytest.fixture(scope="session")
def alone(tmp_path_factory):
    """Store of the full tiny sweep, each of its points computed from the start."""
    path = tmp_path_factory.mktemp("alone") / "tiny.zarr"
    with np.errstate(all="raise", under="ignore"):
        commit_all(path, tiny.full())
    return path
