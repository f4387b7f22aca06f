import gc
import os
import shutil
from pathlib import Path

import numpy as np
import pytest

# By default a difference of 1e-12 passes, whatever is compared: more than all of a volume in m³ or
# a wear rate in m²/N. So a tolerance is relative, unless the test says what it may be at 0.
type(pytest.approx(0.0)).DEFAULT_ABSOLUTE_TOLERANCE = 0.0


MEMORY = Path("/dev/shm")


def pytest_configure(config):
    # A store syncs 200 files when it is made, which takes no time where nothing reaches a disk.
    if MEMORY.is_dir() and shutil.disk_usage(MEMORY).free > 4e9:
        os.environ.setdefault("PYTEST_DEBUG_TEMPROOT", str(MEMORY))
    config.addinivalue_line("markers", "slow: takes minutes; runs with -m slow only")


# What takes minutes begins first, so that no process is left alone with it in the end.
LONG = {"workflows", "run", "uncertain", "page", "test_pages.py", "test_verify.py"}
LONG |= {"test_printed_numbers.py", "test_own_laws.py", "test_doors.py", "test_extras.py"}


def pytest_collection_modifyitems(config, items):
    items.sort(key=lambda item: LONG.isdisjoint(item.path.parts))
    if config.getoption("-m"):
        return
    slow = [item for item in items if item.get_closest_marker("slow")]
    if slow:
        config.hook.pytest_deselected(items=slow)
        items[:] = [item for item in items if item not in slow]


# A search for garbage in all that is imported and collected takes 0.2 s, and finds none there.
def pytest_collection():
    gc.disable()


def pytest_collection_finish():
    gc.collect()
    gc.freeze()
    gc.set_threshold(20_000, 10, 20)
    gc.enable()


@pytest.fixture
def say(capsys):
    """Function that prints even while pytest captures output."""

    def print_now(*words):
        with capsys.disabled():
            print(*words)

    return print_now


@pytest.fixture(autouse=True)
def _floating_point_faults_are_errors():
    with np.errstate(all="raise", under="ignore"):
        yield
