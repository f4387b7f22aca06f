"""A sweep may be killed at any time; `make crash` tries all that is tried here in part."""

import json
import os
import subprocess
import sys
from pathlib import Path

ROOT = Path(__file__).parents[2]


def crashes(*options):
    done = subprocess.run(
        [sys.executable, "-m", "tests.pipeline.crash", *options],
        cwd=ROOT,
        env={**os.environ, "OMP_NUM_THREADS": "1", "OPENBLAS_NUM_THREADS": "1"},
        stdout=subprocess.PIPE,
        text=True,
        check=False,
    )
    return json.loads(done.stdout)


def test_killed_before_any_change_a_store_opens_keeps_its_points_and_resumes():
    found = crashes("--every", "191")
    assert found["crashes"] > 7
    assert found["faults"] == {}


def test_a_status_written_before_its_data_would_be_noticed():
    found = crashes("--every", "401", "--status-first")
    assert any("differs" in fault for faults in found["faults"].values() for fault in faults)
