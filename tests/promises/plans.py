"""Judge the tests that `pipeline.candidates` plans, by hidden truths and direct simulations.

A test turns severe if a point simulated at its velocity, with a scatter, does. Tests are planned
one at a time, or follow a staircase at each load and bulk temperature in turn, or are random, until
the critical temperature is known to 5 K. Prints a JSON document; the exit code is 1 unless planned
tests take three quarters of a staircase's at most. The promise of a batch is judged by
`tests.promises.coverage`.
"""

import argparse
import itertools
import json
import math
import sys
import time
from pathlib import Path

import numpy as np

import pipeline
from pipeline.uncertain.inputs import CRITICAL
from tests.helpers.campaigns import conclude
from tests.promises.rigs import BULKS, CASES, Rig, ensemble_of, idle, weighed
from tests.promises.risk import WORKFLOWS

REACHED, MOST = 5.0, 24  # spread of the critical temperature [K], tests
STEP = 1.2  # of the staircase, in velocity


def spread_of(posterior):
    """Standard deviation of the critical temperature [K]."""
    return next(row["posterior"]["sd"] for row in posterior.summary() if row["path"] == CRITICAL)


def planned(rig, bulks):
    """Places of tests, each the best by all before it."""
    log = [idle(rig.ensemble)]
    while True:
        ranked = pipeline.candidates(weighed(rig.ensemble, log), CRITICAL, bulks)
        best = next(one.test for one in ranked if one.what.startswith("a test at"))
        log.append((yield best["normal_load"], best["velocity"], best["bulk_temperature"]))


def staircase(rig, bulks):
    """Places that go up in velocity after a mild test and down after a severe one."""
    places = list(itertools.product(rig.ensemble.loads.tolist(), bulks))
    low, high = rig.ensemble.velocities
    velocities = dict.fromkeys(places, math.sqrt(low * high))
    for load, bulk in itertools.cycle(places):
        test = yield load, velocities[load, bulk], bulk
        moved = velocities[load, bulk] * (STEP if test["outcome"] == "mild" else 1 / STEP)
        velocities[load, bulk] = min(max(moved, low), high)


def at_random(rig, bulks):
    """Places anywhere in the sweep."""
    chance = np.random.default_rng(rig.seed + 1)
    ends = np.log(rig.ensemble.velocities)
    while True:
        load, bulk = chance.choice(rig.ensemble.loads), chance.choice(bulks)
        yield float(load), float(np.exp(chance.uniform(*ends))), float(bulk)


def needed(rig, places):
    """Number of tests until the critical temperature is known well enough; `MOST` at most."""
    tests, test = [], None
    while len(tests) < MOST:
        test = rig.tried(*places.send(test))
        tests.append(test)
        if spread_of(weighed(rig.ensemble, tests)) <= REACHED:
            break
    return len(tests)


def main():
    parser = argparse.ArgumentParser(prog="python -m tests.promises.plans", description=__doc__)
    parser.add_argument("--case", choices=CASES, default="known")
    parser.add_argument("--scene", type=Path, default=WORKFLOWS / "uncertain.toml")
    parser.add_argument("--store", type=Path, help="of the scene's samples; computed if not given")
    parser.add_argument("--preset", default="draft")
    parser.add_argument("--truths", type=int, default=6)
    parser.add_argument("--minutes", type=float, default=60.0, help="begin no truth later")
    options = parser.parse_args()
    overrides = {"fidelity.preset": options.preset} | CASES[options.case]
    ensemble = ensemble_of(options.scene, overrides, options.store)
    counts = {rule.__name__: [] for rule in (planned, staircase, at_random)}
    began = time.monotonic()
    for number in range(options.truths):
        if time.monotonic() - began > 60 * options.minutes:
            break
        rig = Rig(ensemble, options.scene, overrides, number)
        for rule in (planned, staircase, at_random):
            counts[rule.__name__].append(needed(rig, rule(rig, BULKS[options.case])))
        print(number, *(numbers[-1] for numbers in counts.values()), file=sys.stderr, flush=True)
    means = {name: float(np.mean(numbers)) for name, numbers in counts.items()}
    found = json.dumps({"tests": counts, "mean": means}, indent=1)
    return conclude("plans", found, means["planned"] <= 0.75 * means["staircase"])


if __name__ == "__main__":
    sys.exit(main())
