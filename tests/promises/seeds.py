"""Judge how far the posterior hangs on seeds: that of its draws, and that of the samples.

The log is the scene's own, or with ``--tests`` that of a hidden rig. Prints a JSON document with
the spread of the critical temperature by seed of the samples and draws; the exit code is 1 if
two of the draws are apart by more than 5 %.
"""

import argparse
import json
import os
import sys
import tempfile
from dataclasses import replace
from pathlib import Path

import numpy as np

import pipeline
from pipeline.uncertain.inputs import CRITICAL
from tests.helpers.campaigns import conclude
from tests.helpers.entries import changed
from tests.promises.rigs import BULKS, CASES, WORKFLOWS, Rig

APART = 0.05
SCENE = WORKFLOWS / "uncertain.toml"


def spread_of(posterior):
    """Standard deviation of the critical temperature [K]."""
    return next(row["posterior"]["sd"] for row in posterior.summary() if row["path"] == CRITICAL)


def samples_of(overrides, folder, seed):
    """Samples of the scene by a seed, with its tests."""
    overrides = {"fidelity.preset": "draft", "sweep.sample_seed": seed} | overrides
    sweep = changed(pipeline.load_scene(SCENE, overrides=overrides), fields=False)
    store = Path(folder) / f"{seed}.zarr"
    if not store.exists():
        pipeline.run_sweep(sweep, store, workers=os.cpu_count())
    return pipeline.Ensemble.of(pipeline.open_sweep(store))


def logged(ensemble, overrides, case, count):
    """Transitions that a hidden rig has at each load and bulk temperature in turn."""
    rig = Rig(ensemble, SCENE, {"fidelity.preset": "draft"} | overrides, 0)
    places = [(load, bulk) for bulk in BULKS[case] for load in ensemble.loads.tolist()]
    return tuple(rig.searched(*places[number % len(places)]) for number in range(count))


def spreads_by_seed(ensemble, count):
    """Spread of the critical temperature by the seed of the draws."""
    for seed in range(count):
        again = replace(ensemble, design=replace(ensemble.design, seed=1000 * (seed + 1)))
        vars(again)["_rise"] = ensemble._rise
        posterior = pipeline.posterior(again)
        print(seed, spread_of(posterior), posterior.draws.effective, file=sys.stderr, flush=True)
        yield spread_of(posterior)


def main():
    parser = argparse.ArgumentParser(prog="python -m tests.promises.seeds", description=__doc__)
    parser.add_argument("--case", choices=CASES, default="unknown", help="of a hidden rig")
    parser.add_argument("--tests", type=int, help="of a hidden rig; the scene's own if not given")
    parser.add_argument("--samples", type=int, default=2, help="seeds of the samples")
    parser.add_argument("--draws", type=int, default=8, help="seeds of the draws")
    parser.add_argument("--folder", type=Path, help="of the stores, which are kept")
    options = parser.parse_args()
    overrides = CASES[options.case] if options.tests else {}
    found, tests = {}, None
    with tempfile.TemporaryDirectory() as folder:
        for seed in range(options.samples):
            ensemble = samples_of(overrides, options.folder or folder, seed)
            if options.tests:
                tests = tests or logged(ensemble, overrides, options.case, options.tests)
                ensemble = replace(ensemble, tests=tests)
            found[seed] = [*spreads_by_seed(ensemble, options.draws)]
    apart = {seed: max(spreads) / min(spreads) - 1 for seed, spreads in found.items()}
    means = [float(np.mean(spreads)) for spreads in found.values()]
    document = {"spreads [K]": found, "apart": apart, "samples apart": max(means) / min(means) - 1}
    is_right = max(apart.values()) <= APART
    return conclude(f"seeds_{options.tests or 'own'}", json.dumps(document, indent=1), is_right)


if __name__ == "__main__":
    sys.exit(main())
