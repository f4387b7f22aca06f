"""The paper's whole diagram, 12 loads × 30 velocities, as a user runs it: start-up included."""

import os
import re
import subprocess
import sys
import time

import numpy as np
import pytest

import pipeline
from tests.benchmarks.scene import PAPER, SCENE

VELOCITIES = [f"{velocity:.3f} m/s" for velocity in np.linspace(0.5, 5.0, 30)]
WORKERS = os.cpu_count()
MODES = {
    "240 × 240, 100 increments": tuple(
        f"--set=fidelity.{name}={getattr(PAPER, name)}"
        for name in ("pixels_per_element", "increments", "fewest_elements", "contact_tolerance")
    ),
    "standard": (),
    "to 2 %": ("--accuracy", "2%"),
}


@pytest.fixture(scope="module")
def scene(tmp_path_factory):
    text = SCENE.read_text(encoding="utf-8")
    text = re.sub(r"^velocities = .*$", f"velocities = {VELOCITIES}", text, flags=re.MULTILINE)
    text = text.replace("fields = true", "fields = false")
    path = tmp_path_factory.mktemp("diagram") / "diagram.toml"
    path.write_text(text, encoding="utf-8")
    return path


@pytest.mark.parametrize("mode", MODES)
def test_whole_diagram(benchmark, scene, tmp_path, mode):
    out = tmp_path / "out.zarr"
    command = [sys.executable, "-m", "pipeline", "run", str(scene), "-o", str(out)]

    def run():
        began = time.perf_counter()
        subprocess.run([*command, *MODES[mode]], check=True, capture_output=True)
        return time.perf_counter() - began

    seconds = benchmark.pedantic(run, rounds=1)
    ds = pipeline.open_sweep(out)
    done = int((ds["status"] == 1).sum())
    points_take = float(ds["wall_time"].sum())
    line = f"\n{mode}: {done} points in {seconds:.1f} s on {WORKERS} workers, "
    line += f"of which points {points_take / WORKERS:.1f} s"
    print(line)
    assert done == ds["status"].size or "--accuracy" in MODES[mode]
