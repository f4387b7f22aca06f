"""Judge the intervals of `pipeline.posterior` by hidden truths.

Each truth is drawn by another seed than the samples. Its boundary, by direct simulations, with a
scatter in velocity, is what was measured. Prints a JSON document; the exit code is 1 unless the
90 % intervals hold 80 to 100 % of the hidden values.
"""

import argparse
import json
import math
import os
import sys
import tempfile
from dataclasses import replace
from pathlib import Path

import numpy as np

import pipeline
from tests.promises.risk import drawn_anew

WORKFLOWS = Path(__file__).parents[2] / "workflows"
SCATTER = 0.05


def measured_of(scene, overrides, noise):
    """Transitions that a rig would measure if the scene with these entries were the truth."""
    known = overrides | {"without": ["unknown", "sweep.samples"]}
    truth = pipeline.load_scene(scene, overrides=known)
    own = pipeline.vary(scene, {}, overrides=known).own
    for load, velocity in zip(truth.loads, own.critical_velocities, strict=True):
        if math.isfinite(velocity):
            velocity *= math.exp(SCATTER * noise.standard_normal())
            friction = truth.conditions.friction
            yield {"normal_load": load, "velocity": velocity, "friction": friction}


def held(ensemble, measured, truth):
    """Whether the interval of each input, by its path, holds its hidden value."""
    found = pipeline.posterior(replace(ensemble, measured=tuple(measured)), SCATTER)
    return {
        row["path"]: row["posterior"]["interval"][0] <= value <= row["posterior"]["interval"][1]
        for row, value in zip(found.summary(), truth, strict=True)
        if "interval" in row["posterior"]  # an input out of a list has none
    }


def main():
    parser = argparse.ArgumentParser(prog="python -m tests.promises.coverage", description=__doc__)
    parser.add_argument("--scene", type=Path, default=WORKFLOWS / "uncertain.toml")
    parser.add_argument("--store", type=Path, help="of the scene's samples; computed if not given")
    parser.add_argument("--preset", default="draft")
    parser.add_argument("--truths", type=int, default=40)
    options = parser.parse_args()
    overrides = {"fidelity.preset": options.preset}
    with tempfile.TemporaryDirectory() as folder:
        store = options.store
        if store is None:
            sweep = pipeline.load_scene(options.scene, overrides=overrides)
            store = Path(folder) / "samples.zarr"
            pipeline.run_sweep(replace(sweep, store_fields=False), store, workers=os.cpu_count())
        ensemble = pipeline.Ensemble.of(pipeline.open_sweep(store))
    overrides["without"] = ["unknown", "sweep.samples"]
    held_by = []
    for number, (truth, entries) in enumerate(
        zip(*drawn_anew(ensemble, options.truths), strict=True)
    ):
        noise = np.random.default_rng(number)
        measured = measured_of(options.scene, overrides | entries, noise)
        held_by.append(held(ensemble, measured, truth))
    by_input = {path: float(np.mean([each[path] for each in held_by])) for path in held_by[0]}
    share = float(np.mean(list(by_input.values())))
    result = {"truths": len(held_by), "samples": len(ensemble.inputs), "held": share, **by_input}
    print(json.dumps(result, indent=1))
    return 0 if 0.8 <= share <= 1.0 else 1


if __name__ == "__main__":
    sys.exit(main())
