"""Commands that only read load no library that they do not need, since each takes its time."""

import subprocess
import sys

import pytest

from tests.helpers import tiny
from tests.helpers.stores import commit

NOT_FOR_HELP = {"dask", "matplotlib", "pandas", "scipy.interpolate", "xarray", "zarr"}
# xarray itself looks for Dask and pint.
NOT_FOR_BOUNDARY = {"distributed", "matplotlib", "scipy.interpolate", "scipy.optimize"}
LOADED = """
import sys
from pipeline.cli import main
try:
    main(sys.argv[1:])
except SystemExit:
    pass
print("loaded", *sys.modules)
"""


@pytest.fixture(scope="module")
def store(tmp_path_factory):
    path = tmp_path_factory.mktemp("store") / "tiny.zarr"
    commit(path, tiny.full())
    return str(path)


def modules_of(*command):
    done = subprocess.run(
        [sys.executable, "-c", LOADED, *command], capture_output=True, text=True, check=True
    )
    said, _, loaded = done.stdout.rpartition("loaded ")
    assert said, done.stderr
    return {*loaded.split()}


def test_the_help_loads_no_library_of_arrays():
    assert not NOT_FOR_HELP & modules_of("--help")


@pytest.mark.parametrize("command", ["boundary", "margin"])
def test_reading_a_store_loads_no_solver_scheduler_or_figure(command, store):
    place = ["--load=400 N", "--velocity=1 m/s"] * (command == "margin")
    assert not NOT_FOR_BOUNDARY & modules_of(command, store, *place)
