"""Judge the intervals of `pipeline.posterior` by samples taken as hidden truths.

Each truth is left out of the samples that judge it. Its own simulated boundary, with a scatter in
velocity, is what was measured. Prints a JSON document; the exit code is 1 unless the 90 % intervals
hold 80 to 100 % of the hidden values.
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
from pipeline.analysis.interpolation import crossing
from pipeline.run.follow import follow_boundary

WORKFLOWS = Path(__file__).parents[2] / "workflows"
SCATTER = 0.05


def measured_of(ensemble, number):
    """Transitions that a rig would have measured if this sample were the truth."""
    noise = np.random.default_rng(number)
    limit = float(np.exp(ensemble.log_limit(ensemble.inputs[[number]]))[0])
    (friction, *_) = (float(each[0]) for each in ensemble.conditions_at(ensemble.inputs[[number]]))
    for load, row in zip(ensemble.loads.tolist(), ensemble.rises[number], strict=True):
        velocity = crossing(ensemble.velocities, row, limit)
        if math.isfinite(velocity):
            velocity *= math.exp(SCATTER * noise.standard_normal())
            yield {"normal_load": load, "velocity": velocity, "friction": friction}


def held(ensemble, number):
    """Whether the interval of each input, by its path, holds the value of the sample left out."""
    kept = np.arange(len(ensemble.inputs)) != number
    others = replace(
        ensemble,
        inputs=ensemble.inputs[kept],
        rises=ensemble.rises[kept],
        widths=ensemble.widths[kept],
        measured=tuple(measured_of(ensemble, number)),
    )
    rows = zip(pipeline.posterior(others, SCATTER).summary(), ensemble.inputs[number], strict=True)
    return {
        row["path"]: row["posterior"]["interval"][0] <= value <= row["posterior"]["interval"][1]
        for row, value in rows
        if "interval" in row["posterior"]  # an input out of a list has none
    }


def main():
    parser = argparse.ArgumentParser(prog="python -m tests.promises.coverage", description=__doc__)
    parser.add_argument("--scene", type=Path, default=WORKFLOWS / "uncertain.toml")
    parser.add_argument("--store", type=Path, help="of the scene's samples; computed if not given")
    parser.add_argument("--preset", default="draft")
    parser.add_argument("--truths", type=int, default=40)
    options = parser.parse_args()
    with tempfile.TemporaryDirectory() as folder:
        store = options.store
        if store is None:
            overrides = {"fidelity.preset": options.preset}
            sweep = pipeline.load_scene(options.scene, overrides=overrides)
            store = Path(folder) / "samples.zarr"
            sweep = replace(sweep, store_fields=False)
            follow_boundary(sweep, store, workers=os.cpu_count())
        ensemble = pipeline.Ensemble.of(pipeline.open_sweep(store))
    found = [held(ensemble, number) for number in range(options.truths)]
    by_input = {path: float(np.mean([each[path] for each in found])) for path in found[0]}
    share = float(np.mean(list(by_input.values())))
    told = {"truths": len(found), "samples": len(ensemble.inputs), "held": share, **by_input}
    print(json.dumps(told, indent=1))
    return 0 if 0.8 <= share <= 1.0 else 1


if __name__ == "__main__":
    sys.exit(main())
