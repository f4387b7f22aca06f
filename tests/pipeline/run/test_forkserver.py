"""The process that workers are forked from (pipeline/run/forkserver.py)."""

import os
from pathlib import Path

import pytest

from pipeline.run import forkserver
from pipeline.run.cluster import connected


@pytest.mark.skipif(forkserver.METHOD != "forkserver", reason="workers are not forked here")
def test_workers_begin_with_their_settings_and_with_all_imported():
    with connected(1, None, 30.0) as client:
        ((environment, imported, frozen),) = client.run(_beginning).values()
    for name, value in forkserver.WORKER_ENVIRONMENT.items():
        assert f"{name}={value}" in environment
    assert imported > {"pipeline.run.schedule", "scipy.special", "scipy.fft", "numpy"}
    assert not imported & {"pandas", "xarray", "matplotlib"}
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
