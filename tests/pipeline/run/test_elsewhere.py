"""Workers of another user, in another folder, who cannot see the store."""

import os
import shutil
import socket
import subprocess
import sys
import sysconfig
import time
from contextlib import ExitStack
from pathlib import Path

import numpy as np
import psutil
import pytest

import pipeline
from pipeline.run.sweep import run_sweep
from pipeline.store.verify import verify_store
from tests.crash.loop import faults_of, places
from tests.crash.sweeps import Expected
from tests.helpers import tiny

ROOT = Path(__file__).parents[3]
STRANGER = "nobody"
SWEEP = tiny.full(loads=(150.0, 600.0), velocities=(0.5, 1.0, 1.5))


def _as_stranger(command, **options):
    words = ["su", "-s", "/bin/sh", STRANGER, "-c", command]
    return subprocess.Popen(words, start_new_session=True, **options)


def _interpreter():
    """A Python of this version that the other user may run, if there is one."""
    name = f"python{sys.version_info.major}.{sys.version_info.minor}"
    for path in filter(None, (sys.executable, shutil.which(name, path="/usr/bin:/usr/local/bin"))):
        if _as_stranger(f"test -x {path}", stderr=subprocess.DEVNULL).wait() == 0:
            return path
    return None


needs_another_user = pytest.mark.skipif(
    os.geteuid() != 0 or not shutil.which("su") or _interpreter() is None,
    reason="needs root, and a Python that another user may run",
)


@pytest.fixture
def scheduler(tmp_path):
    """Address of a scheduler with two workers of another user, in a folder of its own."""
    with socket.socket() as free:
        free.bind(("127.0.0.1", 0))
        port = free.getsockname()[1]
    folder = Path("/tmp") / f"irg-elsewhere-{os.getpid()}"
    folder.mkdir()
    shutil.chown(folder, STRANGER)
    paths = [sysconfig.get_path("purelib"), ROOT]
    python = f"cd {folder} && PYTHONPATH={':'.join(map(str, paths))} exec {_interpreter()} -m"
    options = "--host 127.0.0.1 --no-dashboard"
    address = f"tcp://127.0.0.1:{port}"
    with ExitStack() as stack:
        for command in (
            f"{python} distributed.cli.dask_scheduler {options} --port {port}",
            f"{python} distributed.cli.dask_worker {address} {options} --nworkers 2 --nthreads 1",
        ):
            process = _as_stranger(command, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
            stack.callback(_end, process)
            while process.poll() is None and not _answers(port):
                time.sleep(0.1)
        yield address
    shutil.rmtree(folder, ignore_errors=True)


def _end(process):
    """Kill a process with all that it has started, which `su` puts into another session."""
    for child in psutil.Process(process.pid).children(recursive=True):
        child.kill()
    process.kill()
    process.wait()


def _answers(port):
    try:
        socket.create_connection(("127.0.0.1", port), 1.0).close()
    except OSError:
        return False
    return True


@needs_another_user
@pytest.mark.filterwarnings("ignore:Mismatched versions")  # of Python, in its last digit
@pytest.mark.timeout(300)
def test_workers_of_another_user_need_not_see_the_store(tmp_path, scheduler):
    hidden = tmp_path / "hidden"
    hidden.mkdir(mode=0o700)
    path = hidden / "out.zarr"
    outcome = run_sweep(SWEEP, path, scheduler=scheduler, patience=120.0)
    assert (outcome.done, outcome.failed) == (6, ())
    assert _as_stranger(f"ls {path}", stderr=subprocess.DEVNULL).wait() != 0
    assert verify_store(path).is_clean
    with pipeline.open_sweep(path) as ds:
        assert len(list(places(ds))) == 6
        assert list(faults_of(ds, Expected(SWEEP))) == []
        assert np.isfinite(ds["pressure"].values).all()
