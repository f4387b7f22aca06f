"""Judge the tests that `pipeline.candidates` plans, by hidden truths and direct simulations.

Each truth is drawn by another seed than the samples. A test turns severe if a point simulated at
its velocity, with a scatter, does. Tests are planned one at a time, or follow a staircase at each
load in turn, or are random, until the critical temperature is known to 5 K; and a batch of tests is
planned at once, whose promised spread is held against that which is had. Prints a JSON document;
the exit code is 1 unless planned tests take three quarters of a staircase's at most, and the
promise is within 20 %.
"""

import argparse
import itertools
import json
import math
import os
import sys
import tempfile
from dataclasses import replace
from pathlib import Path

import numpy as np

import pipeline
from pipeline.uncertain.ensemble import CRITICAL, FRICTION
from tests.promises.risk import WORKFLOWS, drawn_anew, excess

SCATTER, FRICTION_SCATTER = 0.05, 0.02
# A critical temperature of which little is known, and a wear rate that was measured: with that to a
# factor of 1.5, which acts as the critical temperature does, no number of tests tells the latter.
UNKNOWN = {
    f"unknown.{CRITICAL}": {"mean": "145 degC", "sd": "20 K"},
    "unknown.wear.specific_wear_rate": {"median": "1.2e-6 mm^3/(N m)", "factor": 1.1},
}
REACHED, MOST = 5.0, 24  # spread of the critical temperature [K], tests
STEP = 1.2  # of the staircase, in velocity


class Rig:
    """A hidden truth, tried by direct simulations."""

    def __init__(self, ensemble, scene, overrides, entries, seed):
        self.ensemble, self.seed = ensemble, seed
        self._scene, self._entries = scene, entries
        self._overrides = overrides | {"without": ["unknown", "sweep.samples"]}
        self._chance = np.random.default_rng(seed)

    def tried(self, load, velocity):
        """A test at a place, as a log has it."""
        is_severe = self._excess(load, velocity * self._scatter(SCATTER)) > 0
        outcome = "severe" if is_severe else "mild"
        return self._logged(load, velocity) | {"outcome": outcome}

    def searched(self, load):
        """A transition at a load, as a log has it."""
        low, high = np.log(self.ensemble.velocities)
        for _ in range(8):
            middle = (low + high) / 2
            is_severe = self._excess(load, math.exp(middle)) > 0
            low, high = (low, middle) if is_severe else (middle, high)
        return self._logged(load, math.exp((low + high) / 2) * self._scatter(SCATTER))

    def _excess(self, load, velocity):
        return excess(self._scene, self._overrides, self._entries, load, velocity)

    def _scatter(self, share):
        return math.exp(share * self._chance.standard_normal())

    def _logged(self, load, velocity):
        friction = self._entries[FRICTION] * self._scatter(FRICTION_SCATTER)
        scatter = FRICTION_SCATTER * friction
        place = {"normal_load": load, "velocity": velocity}
        return place | {"friction": friction, "friction_scatter": scatter}

    def weighed(self, tests):
        return pipeline.posterior(replace(self.ensemble, tested=tuple(tests)), SCATTER)


def spread_of(posterior):
    """Standard deviation of the critical temperature [K]."""
    return next(row["posterior"]["sd"] for row in posterior.summary() if row["path"] == CRITICAL)


def planned(rig):
    """Places of tests, each the best by all before it."""
    tests = []
    while True:
        bulk = rig.ensemble.conditions.bulk_temperature
        ranked = pipeline.candidates(rig.weighed(tests), CRITICAL, [bulk])
        best = next(one.test for one in ranked if one.what.startswith("a test at"))
        tests.append((yield best["normal_load"], best["velocity"]))


def staircase(rig):
    """Places that go up in velocity after a mild test and down after a severe one."""
    loads = rig.ensemble.loads.tolist()
    velocities = dict.fromkeys(loads, math.sqrt(math.prod(rig.ensemble.velocities)))
    low, high = rig.ensemble.velocities
    for load in itertools.cycle(loads):
        test = yield load, velocities[load]
        moved = velocities[load] * (STEP if test["outcome"] == "mild" else 1 / STEP)
        velocities[load] = min(max(moved, low), high)


def at_random(rig):
    """Places anywhere in the sweep."""
    chance = np.random.default_rng(rig.seed + 1)
    ends = np.log(rig.ensemble.velocities)
    while True:
        yield float(chance.choice(rig.ensemble.loads)), float(np.exp(chance.uniform(*ends)))


def needed(rig, places):
    """Number of tests until the critical temperature is known well enough; `MOST` at most."""
    places, tests, test = places(rig), [], None
    while len(tests) < MOST:
        test = rig.tried(*places.send(test))
        tests.append(test)
        if spread_of(rig.weighed(tests)) <= REACHED:
            break
    return len(tests)


def main():
    parser = argparse.ArgumentParser(prog="python -m tests.promises.plans", description=__doc__)
    parser.add_argument("--scene", type=Path, default=WORKFLOWS / "uncertain.toml")
    parser.add_argument("--preset", default="draft")
    parser.add_argument("--truths", type=int, default=6)
    parser.add_argument("--batch", type=int, default=4)
    options = parser.parse_args()
    overrides = {"fidelity.preset": options.preset} | UNKNOWN
    sweep = pipeline.load_scene(options.scene, overrides=overrides)
    sweep = replace(sweep, store_fields=False, measured=(), tested=())
    with tempfile.TemporaryDirectory() as folder:
        store = Path(folder) / "samples.zarr"
        pipeline.run_sweep(sweep, store, workers=os.cpu_count())
        ensemble = pipeline.Ensemble.of(pipeline.open_sweep(store))
    _, entries = drawn_anew(ensemble, options.truths)
    rigs = [
        Rig(ensemble, options.scene, overrides, truth, number)
        for number, truth in enumerate(entries)
    ]
    before, bulk = pipeline.posterior(ensemble, SCATTER), ensemble.conditions.bulk_temperature
    batch = pipeline.batch(before, options.batch, CRITICAL, [bulk])
    had = []
    for rig in rigs:
        tests = [
            rig.searched(one.test["normal_load"])
            if "transition" in one.what
            else rig.tried(one.test["normal_load"], one.test["velocity"])
            for one in batch
        ]
        had.append(spread_of(rig.weighed(tests)))
    had = math.sqrt(np.mean(np.square(had)))
    counts = {
        places.__name__: [needed(rig, places) for rig in rigs]
        for places in (planned, staircase, at_random)
    }
    means = {name: float(np.mean(numbers)) for name, numbers in counts.items()}
    promise = {"today": batch[0].before, "promised": batch[-1].spread, "had": had}
    print(json.dumps({"tests": counts, "mean": means, "batch": promise}, indent=1))
    is_less = means["planned"] <= 0.75 * means["staircase"]
    return 0 if is_less and abs(had / promise["promised"] - 1) <= 0.2 else 1


if __name__ == "__main__":
    sys.exit(main())
