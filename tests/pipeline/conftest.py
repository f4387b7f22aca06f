from contextlib import contextmanager
from unittest import mock

import numpy as np
import pytest

from pipeline.store import creation, locked, prepare
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


@contextmanager
def chunks_by_point():
    """New stores have chunks of one point each, as those of earlier versions, or in a bucket."""
    with mock.patch.object(creation, "block_of", lambda loads, axes: [1] * axes):
        yield


@pytest.fixture(scope="session")
def alone(tmp_path_factory):
    """The full tiny sweep, each of its points computed from the start and in chunks of its own."""
    path = tmp_path_factory.mktemp("alone") / "tiny.zarr"
    with np.errstate(all="raise", under="ignore"), chunks_by_point():
        commit_all(path, tiny.full())
    return path


@pytest.fixture(scope="session")
def shared(tmp_path_factory):
    """The same sweep in chunks that several points share."""
    path = tmp_path_factory.mktemp("shared") / "tiny.zarr"
    with np.errstate(all="raise", under="ignore"):
        commit_all(path, tiny.full())
    return path
