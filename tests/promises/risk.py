"""Judge the probability of samples at an operating point by direct simulations of other inputs.

The direct ones know no emulator: each draws its inputs by another seed than the samples and the
probability do, simulates the point from the start of the ramp, and looks whether
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
from pathlib import Path

import numpy as np

import pipeline
from pipeline import run_point
from pipeline.quantities import shown_in
from pipeline.sweep.severity import rise_limit, worst_rises
from pipeline.sweep.variants import Variants
from pipeline.uncertain.answers import draws_of
from pipeline.uncertain.fields import SampleField
from pipeline.uncertain.unknown import drawn
from tests.helpers.campaigns import conclude
from tests.helpers.entries import changed

WORKFLOWS = Path(__file__).parents[2] / "workflows"
SEED = 2718  # seed of direct draws; shipped scenes use 0 for samples, and their risk 1
LIMIT = 3.0  # most standard errors of a difference


def _of_chunk(task):
    scene, overrides, place, inputs = task
    np.seterr(all="raise", under="ignore")
    return [excess(scene, overrides, entries, *place) for entries in inputs]


def excess(scene, overrides, inputs, load, velocity):
    """ln(rise/limit) at a point, simulated with inputs given as scene entries."""
    alone = pipeline.load_scene(scene, overrides=overrides | inputs)
    alone = changed(alone, variants=Variants())
    rise = worst_rises(run_point(alone, load, velocity).columns, load, alone.conditions)
    return math.log(float(rise) / rise_limit(alone.conditions))


def drawn_anew(ensemble, count):
    """Random inputs with another seed: values (count, n_unknown), and their scene entries."""
    values = drawn(ensemble.unknown, SEED, count)
    return values, [entries_of(ensemble.unknown, row) for row in values]


def entries_of(unknown, values):
    """Scene entries by path for values of unknown inputs [SI]."""
    pairs = zip(unknown, values.tolist(), strict=True)
    return {entry.path: written(entry, value) for entry, value in pairs}


def written(unknown, value):
    """Value of an unknown input as a scene file writes it."""
    unit = unknown.shown
    if unit:
        return f"{float(shown_in(value, unit))!r} {unit}"
    return int(value) if unknown.kind == "list" and value.is_integer() else value


def direct(scene, entries, overrides, place, processes):
    """ln(rise/limit) at a point for each set of entries, by direct simulations."""
    chunks = np.array_split(np.arange(len(entries)), min(len(entries), 8 * processes))
    without = overrides | {"without": ["unknown", "sweep.samples"]}
    tasks = [(scene, without, place, [entries[i] for i in chunk]) for chunk in chunks]
    if processes == 1:
        return np.concatenate([_of_chunk(task) for task in tasks])
    with multiprocessing.get_context("spawn").Pool(processes) as pool:
        return np.concatenate(pool.map_async(_of_chunk, tasks, chunksize=1).get(timeout=4 * 3600))


def risk(field, load, velocity):
    """Probability of severe wear at a point by the samples, and its standard error.

    The emulator's error is taken as the same for all draws.
    """
    draws = field.draws
    share = float(draws.mean(field.temperatures(load, velocity).is_severe[:, 0]))
    excess = field.ensemble.excess(draws.inputs, load, velocity)
    low, high = (float(draws.mean(excess.values > sign * excess.error)) for sign in (1, -1))
    by_draws = math.sqrt(share * (1 - share) / draws.effective)
    return share, math.hypot(by_draws, (high - low) / 2)


def judged(ensemble, scene, count, overrides, place, processes=1):
    """Risk by the samples beside the risk by direct simulations, and errors of emulated rises."""
    load, velocity = place
    draws = draws_of(ensemble, None)
    of_draws = ensemble.excess(draws.inputs, load, velocity)
    stated, error = risk(SampleField(ensemble, draws, None), load, velocity)
    values, entries = drawn_anew(ensemble, count)
    excesses = direct(scene, entries, overrides, place, processes)
    share = float(np.mean(excesses > 0))
    by_chance = math.sqrt(share * (1 - share) / count)
    emulated = ensemble.excess(values, load, velocity)
    missed = emulated.values - excesses
    return {
        "load": load,
        "velocity": velocity,
        "samples": len(ensemble.inputs),
        "risk": stated,
        "risk_error": error,
        "direct_simulations": count,
        "direct": share,
        "direct_error": by_chance,
        "standard_errors_apart": (stated - share) / max(math.hypot(error, by_chance), 1e-12),
        "bias": float(missed.mean()),
        "spread": float(missed.std()),
        "rise_error": math.sqrt(float(draws.mean(of_draws.error**2))),
        "within_90_percent": float(np.mean(np.abs(missed) < 1.645 * emulated.error)),
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
    sweep = changed(pipeline.load_scene(options.scene, overrides=overrides), fields=False)
    with tempfile.TemporaryDirectory() as folder:
        store = options.store or Path(folder) / "samples.zarr"
        if options.store is None:
            pipeline.run_sweep(sweep, store, workers=options.processes)
        ensemble = pipeline.Ensemble.of(pipeline.open_sweep(store))
    place = tuple(options.at)
    verdict = judged(ensemble, options.scene, options.direct, overrides, place, options.processes)
    is_right = abs(verdict["standard_errors_apart"]) <= LIMIT
    return conclude("risk", json.dumps(verdict, indent=1), is_right)


if __name__ == "__main__":
    sys.exit(main())
