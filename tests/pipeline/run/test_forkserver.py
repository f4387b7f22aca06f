"""The process that workers are forked from (pipeline/run/forkserver.py)."""

import os
from pathlib import Path

from pipeline.run import forkserver
from pipeline.run.cluster import connected
from tests.helpers.processes import python


def test_workers_begin_with_their_settings_which_are_not_those_of_this_process(monkeypatch):
    monkeypatch.setenv("OMP_NUM_THREADS", "7")
    monkeypatch.delenv("MALLOC_TRIM_THRESHOLD_", raising=False)
    before = dict(os.environ)
    forkserver.start()
    assert dict(os.environ) == before
    with connected(None, 1) as link:
        (environment,) = link.client.run(_environment).values()
    for name, value in forkserver.WORKER_ENVIRONMENT.items():
        assert f"{name}={value}" in environment


def _environment():
    """Environment with which the process of a worker began."""
    return Path("/proc/self/environ").read_text().split("\0")


SCRIPT = """
import sys
from pipeline.run.sweep import run_sweep
from tests.helpers import tiny

run_sweep(tiny.sweep(), sys.argv[1], workers=2)
"""


def test_a_script_that_calls_it_unguarded_is_told_so_once(tmp_path):
    script = tmp_path / "script.py"
    script.write_text(SCRIPT)
    done = python(script, tmp_path / "out.zarr")  # a busy machine takes two minutes
    assert done.returncode == 1
    assert done.stderr.count("Traceback") == done.stderr.count("ExecutionError: ") == 1
    assert 'call run_sweep under if __name__ == "__main__":' in done.stderr
