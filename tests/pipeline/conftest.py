import numpy as np
import pytest

from pipeline.store import locked, prepare
from pipeline.sweep.plan import points, run_point
from tests.helpers import tiny


def commit_all(path, sweep, skip=()):
    """The store of a sweep, computed here and point by point."""
    with locked(path):
        store = prepare(path, sweep)
        for point in points(sweep):
            if point not in skip:
                store.commit(run_point(sweep, *point))
    return store


@pytest.fixture(scope="session")
def alone(tmp_path_factory):
    """The full tiny sweep, each of its points computed from the start."""
    path = tmp_path_factory.mktemp("alone") / "tiny.zarr"
    with np.errstate(all="raise", under="ignore"):
        commit_all(path, tiny.full())
    return path
