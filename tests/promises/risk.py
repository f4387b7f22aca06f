"""Judge `pipeline.risk` at one operating point by direct simulations, each with inputs of its own.

The direct ones know no surrogate and no boundary: each draws its inputs by another seed than the
samples and the probability do, simulates the point from the start of the ramp, and looks whether
wear is severe. Prints a JSON document; the exit code is 1 if the two differ by more than chance
and the stated error let expect.
"""

import argparse
import json
import math
import multiprocessing
import os
import sys
import tempfile
from dataclasses import replace
from pathlib import Path

import numpy as np

import pipeline
from pipeline.run.follow import follow_boundary
from pipeline.sweep.criterion import rise_limit
from pipeline.sweep.plan import run_point

WORKFLOWS = Path(__file__).parents[2] / "workflows"
SEED = 2718  # of the direct draws; the samples have 0 in the shipped scenes, and their risk has 1
LIMIT = 3.0  # standard errors of the difference


def excess(sweep, number, load, velocity):
    """Logarithm of the rise over its limit at a point, by the inputs of one sample alone."""
    alone = sweep.variant(sample=number)
    conditions = alone.conditions
    found = run_point(alone, load, velocity).verdict(conditions)
    limit = rise_limit(conditions) * conditions.friction
    return math.log((found.decisive_temperature - conditions.bulk_temperature) / limit)


def _of_chunk(task):
    scene, count, overrides, place, numbers = task
    np.seterr(all="raise", under="ignore")
    sweep = drawn_anew(scene, count, overrides)
    return [excess(sweep, number, *place) for number in numbers]


def drawn_anew(scene, count, overrides):
    """The scene with other samples than its own."""
    draws = {"sweep.samples": count, "sweep.sample_seed": SEED}
    return pipeline.load_scene(scene, overrides={**overrides, **draws})


def direct(scene, count, overrides, place, processes):
    """Logarithms of rise over limit at a point, of so many direct simulations."""
    chunks = np.array_split(np.arange(count), min(count, 8 * processes))
    tasks = [(scene, count, overrides, place, chunk.tolist()) for chunk in chunks]
    if processes == 1:
        return np.concatenate([_of_chunk(task) for task in tasks])
    with multiprocessing.get_context("spawn").Pool(processes) as pool:
        return np.concatenate(pool.map_async(_of_chunk, tasks, chunksize=1).get(timeout=4 * 3600))


def judged(ensemble, scene, count, overrides, place, processes=1):
    """The risk beside direct simulations, and what the surrogate misses of each."""
    load, velocity = place
    stated = pipeline.risk(ensemble, load, velocity)
    found = direct(scene, count, overrides, place, processes)
    share = float(np.mean(found > 0))
    by_chance = math.sqrt(share * (1 - share) / count)
    fit = ensemble.surrogate(load, [velocity])
    inputs = np.array(drawn_anew(scene, count, overrides).samples.values)
    missed = ensemble.excess(fit, inputs)[:, 0] - found
    return {
        "load": load,
        "velocity": velocity,
        "samples": stated.samples,
        "risk": stated.probability,
        "risk_error": stated.error,
        "direct_simulations": count,
        "direct": share,
        "direct_error": by_chance,
        "standard_errors_apart": (stated.probability - share) / math.hypot(stated.error, by_chance),
        "surrogate_bias": float(missed.mean()),
        "surrogate_spread": float(missed.std()),
        "surrogate_error": stated.surrogate_error,
    }


def main():
    parser = argparse.ArgumentParser(prog="python -m tests.promises.risk", description=__doc__)
    parser.add_argument("--scene", type=Path, default=WORKFLOWS / "uncertain.toml")
    parser.add_argument("--store", type=Path, help="of the scene's samples; computed if not given")
    parser.add_argument("--preset", default="draft")
    parser.add_argument("--direct", type=int, default=2000)
    parser.add_argument("--at", nargs=2, type=float, default=[400.0, 2.0], metavar=("N", "M/S"))
    parser.add_argument("--processes", type=int, default=os.cpu_count())
    options = parser.parse_args()
    overrides = {"fidelity.preset": options.preset}
    sweep = replace(pipeline.load_scene(options.scene, overrides=overrides), store_fields=False)
    with tempfile.TemporaryDirectory() as folder:
        store = options.store or Path(folder) / "samples.zarr"
        follow_boundary(sweep, store, workers=options.processes)
        ensemble = pipeline.Ensemble.of(pipeline.open_sweep(store))
    place = tuple(options.at)
    told = judged(ensemble, options.scene, options.direct, overrides, place, options.processes)
    print(json.dumps(told, indent=1))
    return 1 if abs(told["standard_errors_apart"]) > LIMIT else 0


if __name__ == "__main__":
    sys.exit(main())
