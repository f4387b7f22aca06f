import gc
import os
import shutil
from pathlib import Path

import numpy as np
import pytest

# By default pytest.approx allows an absolute difference of 1e-12, which is more than a worn volume
# in m³ or a wear rate in m²/N. So tolerances are relative unless a test gives an absolute one.
type(pytest.approx(0.0)).DEFAULT_ABSOLUTE_TOLERANCE = 0.0


pytest.register_assert_rewrite("tests.helpers.kept")  # which shows what differs

MEMORY = Path("/dev/shm")


def pytest_configure(config):
    # A new store syncs 200 files to disk, which takes no time in a file system in memory.
    if MEMORY.is_dir() and shutil.disk_usage(MEMORY).free > 4e9:
        os.environ.setdefault("PYTEST_DEBUG_TEMPROOT", str(MEMORY))
    config.addinivalue_line("markers", "slow: takes minutes; runs with -m slow only")


# Tests that take minutes begin first, so that no process is left alone with one at the end.
LONG = {"workflows", "run", "page", "test_verify.py"}


def pytest_collection_modifyitems(config, items):
    items.sort(key=lambda item: LONG.isdisjoint(item.path.parts))
    if config.getoption("-m"):
        return
    slow = [item for item in items if item.get_closest_marker("slow")]
    if slow:
        config.hook.pytest_deselected(items=slow)
        items[:] = [item for item in items if item not in slow]


# Garbage collection among all imported modules and collected tests takes 0.2 s and finds nothing.
def pytest_collection():
    gc.disable()


def pytest_collection_finish():
    gc.collect()
    gc.freeze()
    gc.set_threshold(20_000, 10, 20)
    gc.enable()


@pytest.fixture(autouse=True)
def _floating_point_faults_are_errors():
    with np.errstate(all="raise", under="ignore"):
        yield
