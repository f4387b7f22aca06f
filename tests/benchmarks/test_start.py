"""What a command takes on all of its processes, in units of the imports of its libraries alone.

Counted in CPU time, in turns, so that it holds on a machine that others use, too.
"""

import os
import subprocess
import sys

import pytest

LIBRARIES = "import numpy, scipy.special, pandas, xarray, zarr"
FEW = ('sweep.loads=["200 N", "400 N", "750 N"]', 'sweep.velocities=["1 m/s", "2 m/s", "4 m/s"]')
ROUNDS = 3
COMMANDS = {
    "margin": "margin STORE --load 400N --velocity 2m/s",
    "boundary": "boundary STORE",
    "status": "status STORE",
    "check": "check irg_transition",
    "point": "point irg_transition --load 400N --velocity 2m/s --set without=measured",
    "run": "run irg_transition --set without=measured --workers 2 -o OUT",
}


def cpu_time(*command):
    """CPU time of a process and of all that it starts [s]."""
    # The measuring process waits for those whose parents are gone, too, as for the fork server.
    measure = (
        "import ctypes, os, resource, subprocess, sys, contextlib\n"
        "ctypes.CDLL(None).prctl(36, 1, 0, 0, 0)\n"  # PR_SET_CHILD_SUBREAPER
        "subprocess.run(sys.argv[1:], stdout=-3, stderr=-3, check=True)\n"
        "with contextlib.suppress(ChildProcessError):\n"
        "    while True:\n"
        "        os.wait()\n"
        "used = resource.getrusage(resource.RUSAGE_CHILDREN)\n"
        "print(used.ru_utime + used.ru_stime)\n"
    )
    done = subprocess.run(
        [sys.executable, "-c", measure, *command], capture_output=True, text=True, check=True
    )
    return float(done.stdout)


@pytest.fixture(scope="module")
def store(tmp_path_factory):
    path = tmp_path_factory.mktemp("start") / "few.zarr"
    settings = [word for value in FEW for word in ("--set", value)]
    command = [sys.executable, "-m", "pipeline", "run", "irg_transition", "-o", path, *settings]
    subprocess.run([*command, "--set", "without=measured"], check=True, capture_output=True)
    return path


@pytest.mark.skipif(not sys.platform.startswith("linux"), reason="counts orphans as Linux does")
@pytest.mark.parametrize("name", COMMANDS)
def test_a_command_beside_the_imports_of_its_libraries(benchmark, store, tmp_path, name):
    given, bare = [], []

    def in_turns():
        for number in range(ROUNDS):
            names = {"STORE": store, "OUT": tmp_path / f"{number}.zarr"}
            words = [os.fspath(names.get(word, word)) for word in COMMANDS[name].split()]
            if name in ("run", "point", "check"):
                words += [word for value in FEW for word in ("--set", value)]
            given.append(cpu_time(sys.executable, "-m", "pipeline", *words))
            bare.append(cpu_time(sys.executable, "-c", LIBRARIES))

    benchmark.pedantic(in_turns, rounds=1)
    ratio = min(given) / min(bare)
    print(f"\nirg {name}: {min(given):.2f} s of CPU, {ratio:.2f} of its libraries' imports")
