import pytest


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
