"""Judge confirmed limits of designs by plain direct simulations, which know no emulator.

Each draws its inputs by a seed of its own and simulates the point from the start of the ramp; the
probability is the mean of what the model's own error makes of each. Prints a table; the exit code
is 1 if a confirmed limit does not keep its risk, or if stated probabilities lie off by more than
their errors let expect.
"""

import argparse
import math
import os
import sys
import tempfile
from dataclasses import replace
from pathlib import Path

import numpy as np
from scipy.stats import chi2

import pipeline
from pipeline.analysis.model_error import ModelError
from pipeline.scene.along import Place
from pipeline.uncertain.answer_design import read_scene
from pipeline.uncertain.answers import run_probability
from pipeline.uncertain.design import Chances, Goal
from pipeline.uncertain.direct import log_rise, scene_values
from pipeline.uncertain.ensemble import Excess
from pipeline.uncertain.inputs import BULK, CRITICAL, FRICTION, prior
from tests.helpers.campaigns import conclude, table

SCENE = Path(__file__).parents[2] / "workflows" / "uncertain.toml"
LENGTH = "disk.roughness.correlation_length"
DESIGNS = (
    ("load", 400, 1.5, 0.01), ("load", 400, 1.0, 0.05), ("velocity", 400, 2.0, 0.01),
    ("velocity", 600, 1.0, 0.1), (CRITICAL, 400, 1.5, 0.01), (CRITICAL, 600, 2.0, 0.05),
    (CRITICAL, 300, 3.0, 0.001), (BULK, 400, 1.5, 0.05), (BULK, 250, 1.2, 0.01),
    (FRICTION, 400, 1.5, 0.01), (FRICTION, 700, 1.0, 0.05), (LENGTH, 400, 2.0, 0.45),
)  # fmt: skip
"""Entry, load [N], velocity [m/s] and risk."""
SEED = 31415
VIOLATED = 2.0  # standard errors above the risk, that count a confirmed limit as wrong


def designed(ensemble, scene_with, path, goal):
    """The chances, the limit, and what direct simulations say of it, as `irg design` finds them."""
    chances = Chances(ensemble, goal)
    for seed in range(2):
        limit = chances.limit(path)
        if limit.value is None:
            return chances, limit, None
        found = chances.simulated(limit, scene_with, seed)
        chances = replace(chances, shift=found.shift, spare=found.spare)
    return chances, limit, found


def direct(chances, limit, scene_with, count):
    """Probability at a limit by plain simulations, and its standard error."""
    ensemble, path = chances.ensemble, limit.entry.path
    inputs = prior(ensemble.unknown, SEED, count).inputs
    for number, one in enumerate(ensemble.unknown):
        if one.path == path:
            inputs[:, number] = limit.value
    load, velocity = limit.binding
    rises, slopes = np.empty((2, count))
    for number, row in enumerate(inputs):
        sweep = scene_with(scene_values(ensemble, row))
        rises[number] = log_rise(sweep, load, velocity, sweep.conditions)
    emulated = ensemble.rise(inputs, load, [velocity * 0.95, velocity * 1.05]).values
    slopes = np.maximum((emulated[:, 1] - emulated[:, 0]) / math.log(1.05 / 0.95), 0.05)
    values = {one: ensemble.values(one, inputs) for one in (CRITICAL, BULK, FRICTION)}
    if path in values:
        values[path] = np.full(count, limit.value)
    limits = np.log(np.maximum(values[CRITICAL] - values[BULK], 1.0) / values[FRICTION])
    tiny = np.full(count, 1e-9)
    excess = rises + chances.numerical - limits
    shares, _ = run_probability(Excess(excess, tiny, tiny), ModelError(), slopes)
    return float(shares.mean()), float(shares.std(ddof=1)) / math.sqrt(count)


def main():
    parser = argparse.ArgumentParser(prog="python -m tests.promises.designs", description=__doc__)
    parser.add_argument("--scene", type=Path, default=SCENE)
    parser.add_argument("--store", type=Path, help="of the scene's samples; computed if not given")
    parser.add_argument("--direct", type=int, default=400)
    every = range(1, len(DESIGNS) + 1)
    parser.add_argument("--only", type=int, nargs="+", default=every, help="numbers of designs")
    options = parser.parse_args()
    with tempfile.TemporaryDirectory() as folder:
        store = options.store or Path(folder) / "samples.zarr"
        if not store.exists():
            sweep = pipeline.load_scene(options.scene, "draft").changed(fields=False)
            arguments = str(options.scene), "--preset=draft"
            pipeline.run_sweep(sweep.changed(arguments=arguments), store, workers=os.cpu_count())
        ds = pipeline.open_sweep(store)
        ensemble, scene_with = pipeline.Ensemble.of(ds), read_scene(ds)
    rows, scores, is_right = [], [], True
    for path, load, velocity, risk in (DESIGNS[number - 1] for number in options.only):
        goal = Goal([Place(load, velocity)], risk)
        chances, limit, found = designed(ensemble, scene_with, path, goal)
        if found is None:
            rows.append((path, risk, limit.side, "", "", "", ""))
            continue
        share, error = direct(chances, limit, scene_with, options.direct)
        confirmed = found.confirms(risk)
        scores.append((found.probability - share) / math.hypot(found.error, error))
        is_right &= not confirmed or share - VIOLATED * error <= risk
        stated = f"{found.probability:.4f} ± {found.error:.4f}"
        rows.append(
            (path, risk, f"{limit.value:.5g}", stated, f"{share:.4f} ± {error:.4f}",
             f"{scores[-1]:.1f}", "yes" if confirmed else "no")
        )  # fmt: skip
        print(rows[-1], flush=True)
    is_right &= sum(one**2 for one in scores) < chi2.ppf(0.995, len(scores))
    heads = "entry", "risk", "limit", "stated", "direct", "errors apart", "confirmed"
    return conclude("designs", table(heads, rows), is_right)


if __name__ == "__main__":
    sys.exit(main())
