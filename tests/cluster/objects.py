"""Stores in a real Ceph object gateway: the tests of stores, drivers that are killed."""

import json

from tests.helpers.processes import ROOT, python
from tests.helpers.s3 import RUNNING


def _command(gateway, *words):
    variables = gateway.environment | {RUNNING: "1"}
    return python("-m", *words, variables=variables, cwd=ROOT, timeout=900.0)


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


TRIALS = {trial.__name__: trial for trial in (suite, kills)}
