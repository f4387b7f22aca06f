import numpy as np
import pytest

collect_ignore_glob = ["**/references/*"]  # scripts that made the references, not tests


# By default a difference of 1e-12 passes, whatever is compared: more than all of a volume in m³ or
# a wear rate in m²/N. So a tolerance is relative, unless the test says what it may be at 0.
type(pytest.approx(0.0)).DEFAULT_ABSOLUTE_TOLERANCE = 0.0


def pytest_configure(config):
    config.addinivalue_line("markers", "slow: takes minutes; runs with -m slow only")


def pytest_collection_modifyitems(config, items):
    if config.getoption("-m"):
        return
    slow = [item for item in items if item.get_closest_marker("slow")]
    if slow:
        config.hook.pytest_deselected(items=slow)
        items[:] = [item for item in items if item not in slow]


@pytest.fixture
def say(capsys):
    """Print past pytest's capture."""

    def print_now(*words):
        with capsys.disabled():
            print(*words)

    return print_now


@pytest.fixture(autouse=True)
def _floating_point_faults_are_errors():
    with np.errstate(all="raise", under="ignore"):
        yield
