"""The process that workers are forked from (pipeline/run/forkserver.py)."""

import os
import subprocess
import sys
import time
from pathlib import Path

import distributed
import psutil
import pytest
from packaging.version import Version

from pipeline.run import forkserver
from pipeline.run.cluster import connected

ROOT = Path(__file__).parents[3]


@pytest.mark.skipif(forkserver.METHOD != "forkserver", reason="workers are not forked here")
def test_workers_begin_with_their_settings_and_with_all_imported():
    with connected(1, None, 30.0) as client:
        ((environment, imported, frozen),) = client.run(_beginning).values()
    for name, value in forkserver.WORKER_ENVIRONMENT.items():
        assert f"{name}={value}" in environment
    assert imported > {"pipeline.run.work", "distributed", "scipy.special", "scipy.fft", "numpy"}
    assert not imported & {"xarray", "matplotlib", "zarr"}
    if Version(distributed.__version__) >= Version("2026.8"):  # older ones import it themselves
        assert "pandas" not in imported
    assert frozen > 10_000  # objects, of what was imported


def _beginning():
    import gc
    import sys

    environment = Path("/proc/self/environ").read_text().split("\0")
    return environment, set(sys.modules), gc.get_freeze_count()


def test_the_settings_of_workers_are_not_those_of_this_process(monkeypatch):
    monkeypatch.setenv("OMP_NUM_THREADS", "7")
    monkeypatch.delenv("MALLOC_TRIM_THRESHOLD_", raising=False)
    before = dict(os.environ)
    forkserver.start()
    assert dict(os.environ) == before
    monkeypatch.setenv("SET_LATER", "such as the key of an object store")
    with connected(1, None, 30.0) as client:
        (found,) = client.run(lambda: dict(os.environ)).values()
    assert found["SET_LATER"] == os.environ["SET_LATER"]
    assert found["OMP_NUM_THREADS"] == "1"


def server():
    forkserver.start()
    (found,) = (
        each for each in psutil.Process().children() if "forkserver" in " ".join(each.cmdline())
    )
    return found


@pytest.mark.skipif(forkserver.METHOD != "forkserver", reason="workers are not forked here")
def test_a_forkserver_that_was_stopped_is_waited_for_by_nobody():
    server().suspend()  # before workers start, and again before they end
    with connected(1, None, 30.0) as client:
        (worker,) = client.run(os.getpid).values()
        server().suspend()
    assert not psutil.pid_exists(worker)


@pytest.mark.skipif(forkserver.METHOD != "forkserver", reason="workers are not forked here")
@pytest.mark.skipif(not hasattr(os, "sched_setaffinity"), reason="processes choose their processor")
def test_a_forkserver_wakes_that_was_told_to_stop_and_has_not_come_to_it_yet():
    """As one that shares its processor with whoever wakes it."""
    before, stopped = os.sched_getaffinity(0), server()
    one = {min(before)}
    try:
        os.sched_setaffinity(0, one)
        os.sched_setaffinity(stopped.pid, one)
        for _ in range(20):
            stopped.suspend()
            forkserver.wake()
            time.sleep(0.01)
            assert stopped.status() != psutil.STATUS_STOPPED
    finally:
        stopped.resume()
        os.sched_setaffinity(0, before)
        os.sched_setaffinity(stopped.pid, before)


def test_what_workers_import_is_not_frozen_elsewhere():
    done = subprocess.run(
        [sys.executable, "-c", "import gc, pipeline.run.preload; print(gc.get_freeze_count())"],
        cwd=ROOT,
        capture_output=True,
        text=True,
        check=True,
        timeout=60,
    )
    assert done.stdout == "0\n"


SCRIPT = """
import sys
from pipeline.run.sweep import run_sweep
from tests.helpers import tiny

run_sweep(tiny.sweep(), sys.argv[1], workers=2)
"""


def test_a_script_that_calls_it_unguarded_is_told_so_once(tmp_path):
    script = tmp_path / "script.py"
    script.write_text(SCRIPT)
    done = subprocess.run(
        [sys.executable, script, tmp_path / "out.zarr"],
        env={**os.environ, "PYTHONPATH": str(ROOT)},
        capture_output=True,
        text=True,
        check=False,
        timeout=200,  # a busy machine takes two minutes
    )
    assert done.returncode == 1
    assert done.stderr.count("Traceback") == done.stderr.count("ExecutionError: in a script, ") == 1
    assert 'call run_sweep under if __name__ == "__main__":' in done.stderr
