"""Systems without POSIX, as Windows: reading works, writing says what it needs."""

import pytest

from tests.helpers.processes import python
from tests.helpers.scenes import SCENE

WITHOUT_POSIX = """
import multiprocessing, os, signal, sys
import asyncio, locket, psutil  # which have a part of their own for each system
sys.modules["fcntl"] = None
del os.getuid, os.sysconf, os.O_NONBLOCK, signal.pthread_sigmask
os.O_BINARY = 0
multiprocessing.get_all_start_methods = lambda: ["spawn"]
from pipeline.cli import main
sys.exit(main(sys.argv[1:]))
"""


def run(*arguments):
    return python("-c", WITHOUT_POSIX, *arguments, variables={"OMP_NUM_THREADS": "1"})


PLACE = ("--load", "200 N", "--velocity", "1 m/s")


@pytest.mark.parametrize(
    "command",
    [
        ("point", "small.toml", *PLACE, "--set", "increments=1"),
        ("plot", "tiny.zarr", "-o", "figure.png"),
    ],
    ids=lambda command: command[0],
)
def test_what_only_reads_works(command, alone, tmp_path):
    (tmp_path / "small.toml").write_text(SCENE)
    places = {"small.toml": tmp_path / "small.toml", "tiny.zarr": alone}
    places["figure.png"] = tmp_path / "figure.png"
    done = run(*(places.get(word, word) for word in command))
    assert done.returncode == 0, done.stderr
    assert all("so far" in line for line in done.stderr.splitlines())  # on a busy machine


def test_a_run_says_what_it_needs(tmp_path):
    (tmp_path / "small.toml").write_text(SCENE)
    done = run("run", tmp_path / "small.toml", "-o", tmp_path / "out.zarr")
    assert done.returncode == 2
    assert "no file locks, which irg run needs; run it on Linux or macOS" in done.stderr
    assert done.stderr.count("\n") == 1
