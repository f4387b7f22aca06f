"""Judge the tests that `pipeline.candidates` plans, by hidden truths and direct simulations.

A test turns severe if a point simulated at its velocity, with a scatter, does. Tests are planned
one at a time, or follow a staircase at each load and bulk temperature in turn, or are random, until
the critical temperature is known to 5 K. Prints a JSON document; the exit code is 1 unless planned
tests take three quarters of a staircase's at most. The promise of a batch is judged by
`tests.promises.coverage`.

With ``--runs`` a batch of so many runs stands beside as many of the staircase, and beside as many
at each load and bulk temperature in turn where the transition is likeliest. The exit code is 1 if
the batch leaves over four fifths of the spread of either, and the plan does not say so.
"""

import argparse
import itertools
import json
import math
import sys
import time

import numpy as np

import pipeline
from pipeline.uncertain.inputs import CRITICAL, prior
from tests.helpers.campaigns import conclude
from tests.promises.rigs import (
    BULKS,
    add_rig_options,
    idle,
    log_transitions,
    rigs_of,
    weighed,
)

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


def in_turn(rig, bulks):
    """Places where wear may be both, by what is known beforehand."""
    ensemble = rig.ensemble
    inputs = prior(ensemble.unknown, ensemble.design.seed, 2**10).inputs
    for load, bulk in itertools.cycle(itertools.product(ensemble.loads.tolist(), bulks)):
        middle = math.exp(np.median(log_transitions(ensemble, inputs, load, bulk)))
        yield load, float(np.clip(middle, *ensemble.velocities)), bulk


def as_planned(batch):
    """Places of a batch."""
    names = "normal_load", "velocity", "bulk_temperature"
    yield from (tuple(one.test[name] for name in names) for one in batch)


def tried(rig, places, count):
    """So many tests of a rig."""
    tests, test = [], None
    for _ in range(count):
        test = rig.tried(*places.send(test))
        tests.append(test)
    return tests


def compared(options):
    """Spread that a batch, a staircase and runs in turn leave, root mean square over truths."""
    ensemble, rig_of = rigs_of(options)
    bulks, began = BULKS[options.case], time.monotonic()
    before = weighed(ensemble, [idle(ensemble)])
    batch = pipeline.plan_tests(before, options.runs, CRITICAL, bulks)
    squares = []
    for rig in map(rig_of, range(options.truths)):
        if time.monotonic() - began > 60 * options.minutes:
            break
        rules = as_planned(batch), staircase(rig, bulks), in_turn(rig, bulks)
        tests = (tried(rig, places, options.runs) for places in rules)
        squares.append([spread_of(weighed(ensemble, one, fewer=4)) ** 2 for one in tests])
        print(rig.seed, np.sqrt(squares[-1]).round(2), file=sys.stderr, flush=True)
    again = np.random.default_rng(0).choice(np.array(squares), (2000, len(squares))).mean(axis=1)
    spreads, over = np.sqrt(np.mean(squares, axis=0)), np.sqrt(again[:, :1] / again[:, 1:])
    shares, errors = spreads[0] / spreads[1:], over.std(axis=0)
    last = batch[-1]
    document = {
        "truths": len(squares), "promised": last.spread, "promised in turn": last.in_turn,
        "said": last.comparison, "spreads": spreads.tolist(), "over staircase": shares[0],
        "over in turn": shares[1], "errors": errors.tolist(),
    }  # fmt: skip
    promised = last.spread / np.array([last.staircase, last.in_turn])
    held = bool(((promised > 0.8) | (shares - errors <= 0.8)).all())
    return conclude(f"plans_{options.case}_{options.runs}", json.dumps(document, indent=1), held)


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
    add_rig_options(parser)
    parser.add_argument("--truths", type=int, default=6)
    parser.add_argument("--runs", type=int, help="of a batch beside as many of other rules")
    parser.add_argument("--minutes", type=float, default=60.0, help="begin no truth later")
    options = parser.parse_args()
    if options.runs:
        return compared(options)
    _, rig_of = rigs_of(options)
    counts = {rule.__name__: [] for rule in (planned, staircase, at_random)}
    began = time.monotonic()
    for number, rig in enumerate(map(rig_of, range(options.truths))):
        if time.monotonic() - began > 60 * options.minutes:
            break
        for rule in (planned, staircase, at_random):
            counts[rule.__name__].append(needed(rig, rule(rig, BULKS[options.case])))
        print(number, *(numbers[-1] for numbers in counts.values()), file=sys.stderr, flush=True)
    means = {name: float(np.mean(numbers)) for name, numbers in counts.items()}
    found = json.dumps({"tests": counts, "mean": means}, indent=1)
    return conclude("plans", found, means["planned"] <= 0.75 * means["staircase"])


if __name__ == "__main__":
    sys.exit(main())
