"""Stores in a real Ceph object gateway: the tests of stores, drivers that are killed, requests."""

import json
import os
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest
from aiobotocore.endpoint import AioEndpoint

import pipeline
from pipeline.run.sweep import run_sweep
from pipeline.store.verify import verify_store
from tests.cluster.gateway import BUCKET
from tests.helpers import tiny
from tests.helpers.s3 import RUNNING

ROOT = Path(__file__).parents[2]
_MOST = {"a_point": 3, "with_nothing_to_do": 30}  # requests
_LOADS, _VELOCITIES = 12, 30
_OF_A_RUN = ["wall_time"]
_PATIENCE = 900.0  # [s]


def _command(gateway, *words):
    environment = {**os.environ, **gateway.environment, RUNNING: "1"}
    return subprocess.run(
        [sys.executable, "-m", *words],
        cwd=ROOT,
        env=environment,
        capture_output=True,
        text=True,
        check=False,
        timeout=_PATIENCE,
    )


def suite(gateway, folder, expected):
    """The tests of stores in an object store."""
    run = _command(gateway, "pytest", "-q", "tests/pipeline/store/test_s3.py")
    yield {"said": run.stdout.strip().splitlines()[-1]}
    if run.returncode:
        yield run.stdout[-3000:]


def kills(gateway, folder, expected):
    """The campaign of killed drivers."""
    run = _command(gateway, "tests.crash", "objects")
    yield json.loads(run.stdout)["objects"] if run.stdout else {}
    if run.returncode:
        yield run.stdout + run.stderr


def requests(gateway, folder, expected):
    """Requests of 12 × 30 points, bit for bit as on a disk, and of a run with nothing to do."""
    address, log, send = f"s3://{BUCKET}/requests.zarr", [], AioEndpoint._send
    sweep = tiny.sweep(
        loads=tuple(np.linspace(150.0, 900.0, _LOADS)),
        velocities=tuple(np.linspace(0.5, 1.5, _VELOCITIES)),
    )

    async def logged(self, request):
        log.append(request.method)
        return await send(self, request)

    with pytest.MonkeyPatch.context() as patch:
        for name, value in gateway.environment.items():
            patch.setenv(name, value)
        patch.setattr(AioEndpoint, "_send", logged)
        done = run_sweep(sweep, address, workers=2).done
        counts = {"a_point": len(log) / (_LOADS * _VELOCITIES)}
        log.clear()
        run_sweep(sweep, address, workers=2)
        counts["with_nothing_to_do"] = len(log)
        yield counts
        run_sweep(sweep, folder / "requests.zarr", workers=2)
        if done != _LOADS * _VELOCITIES or not verify_store(address).is_clean:
            yield f"{done} points are done, or some are damaged"
        there, here = (
            pipeline.open_sweep(place).load().drop_vars(_OF_A_RUN)
            for place in (address, folder / "requests.zarr")
        )
        if not there.equals(here):
            yield "the store differs from one on a disk"
    for name, most in _MOST.items():
        if counts[name] > most:
            yield f"{counts[name]} requests {name}, and at most {most} were promised"


TRIALS = {trial.__name__: trial for trial in (suite, kills, requests)}
