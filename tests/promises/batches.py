"""Judge the promised spreads of planned batches by many truths on the emulator.

Truths and draws are of what is known beforehand; a test turns severe by the emulator's boundary of
its truth, with a scatter drawn as the tool assumes it. Each truth weighs all draws by the exact
likelihood of its tests, its scatter known. Beside the batch stand a staircase and runs in turn
(`tests.promises.plans`). Prints a JSON document; the exit code is 1 unless the spread promised is
0.8 to 1.25 of that had, within its standard error, and the batch leaves at most four fifths of
the spread of the two others, or the plan says that they do as well.
"""

import argparse
import itertools
import json
import math
import sys

import numpy as np
from scipy.special import log_ndtr

import pipeline
from pipeline.uncertain.evidence import FACTOR
from pipeline.uncertain.inputs import CRITICAL, FRICTION
from tests.helpers.campaigns import conclude
from tests.promises.plans import STEP
from tests.promises.rigs import (
    BULKS,
    FRICTION_SCATTER,
    SCATTER,
    add_rig_options,
    idle,
    log_transitions,
    rigs_of,
    weighed,
)

COUNTS, BESIDE = (4, 10, 20, 40), 10
BETTER = 0.8  # share of another rule's spread that a plan leaves, unless it says otherwise
DRAWS = 2**13
_SEED = 1618


class Rigs:
    """Truths on the emulator, and draws that each of them weighs."""

    def __init__(self, posterior, count):
        self.chance, self.count = np.random.default_rng(_SEED), count
        self.ensemble, draws = posterior.ensemble, posterior.draws
        rows = self.chance.choice(len(draws.weights), count + DRAWS, p=draws.weights)
        self._inputs = draws.inputs[rows][:, : len(self.ensemble.unknown)]
        paths = [one.path for one in self.ensemble.unknown]
        self.friction = np.log(self._inputs[:, paths.index(FRICTION)])
        self.target = self._inputs[count:, paths.index(CRITICAL)]
        self.scatter = SCATTER * FACTOR ** self.chance.standard_normal(count)
        self._transitions = {}

    def transitions(self, load, bulk):
        """Logarithm of the critical velocity of all, at a place."""
        if (load, bulk) not in self._transitions:
            found = log_transitions(self.ensemble, self._inputs, load, bulk)
            self._transitions[load, bulk] = found
        return self._transitions[load, bulk]

    def spreads(self, places):
        """Spread that each test leaves, squared, of each truth (n_truth,); places learn of it."""
        count, likelihood, is_severe = self.count, 0.0, None
        while True:
            load, bulk, log_velocity = places.send(is_severe)
            critical = self.transitions(load, bulk)
            noise = self.scatter * self.chance.standard_normal(count)
            is_severe = log_velocity + noise > critical[:count]
            apart = (np.reshape(log_velocity, (-1, 1)) - critical[count:]) / self.scatter[:, None]
            likelihood += log_ndtr(np.where(is_severe[:, None], apart, -apart))
            measured = FRICTION_SCATTER * self.chance.standard_normal(count)
            missed = (self.friction[:count] + measured)[:, None] - self.friction[count:]
            likelihood -= 0.5 * (missed / FRICTION_SCATTER) ** 2
            weights = np.exp(likelihood - likelihood.max(axis=1, keepdims=True))
            weights /= weights.sum(axis=1, keepdims=True)
            yield weights @ self.target**2 - (weights @ self.target) ** 2


def planned(batch):
    """Places of a batch."""
    for test in (one.test for one in batch):
        yield test["normal_load"], test["bulk_temperature"], math.log(test["velocity"])


def in_turn(rigs, bulks):
    """Places at each load and bulk temperature where wear may be both."""
    ends = np.log(rigs.ensemble.velocities)
    for load, bulk in itertools.cycle(itertools.product(rigs.ensemble.loads.tolist(), bulks)):
        yield load, bulk, float(np.clip(np.median(rigs.transitions(load, bulk)), *ends))


def staircase(rigs, bulks):
    """Places that go up in velocity after a mild test and down after a severe one."""
    ends = np.log(rigs.ensemble.velocities)
    places = [*itertools.product(rigs.ensemble.loads.tolist(), bulks)]
    at = dict.fromkeys(places, np.full(rigs.count, ends.mean()))
    for place in itertools.cycle(places):
        is_severe = yield (*place, at[place])
        at[place] = (at[place] + math.log(STEP) * np.where(is_severe, -1, 1)).clip(*ends)


def rms(squares):
    """Root mean square, and its standard error."""
    mean = float(squares.mean())
    return math.sqrt(mean), float(squares.std()) / math.sqrt(len(squares)) / 2 / math.sqrt(mean)


def main():
    parser = argparse.ArgumentParser(prog="python -m tests.promises.batches", description=__doc__)
    add_rig_options(parser)
    parser.add_argument("--truths", type=int, default=400)
    options = parser.parse_args()
    ensemble, _ = rigs_of(options)
    before, bulks = weighed(ensemble, [idle(ensemble)]), BULKS[options.case]
    batch = pipeline.plan_tests(before, COUNTS[-1], CRITICAL, bulks)
    rigs = Rigs(before, options.truths)
    had = [*map(rms, itertools.islice(rigs.spreads(planned(batch)), COUNTS[-1]))]
    document, is_right = {}, True
    for count in COUNTS:
        promised, (spread, error) = batch[count - 1].spread, had[count - 1]
        document[f"{count} tests"] = {"promised": promised, "had": spread, "error": error}
        is_right &= promised / (spread - error) >= 0.8 and promised / (spread + error) <= 1.25
    last, spread = batch[BESIDE - 1], had[BESIDE - 1][0]
    for rule in (staircase, in_turn):
        *_, squares = itertools.islice(rigs.spreads(rule(rigs, bulks)), BESIDE)
        (other, error), promised = rms(squares), getattr(last, rule.__name__)
        document[rule.__name__] = {"promised": promised, "had": other, "error": error}
        is_right &= spread <= BETTER * (other + error) or last.spread > BETTER * promised
    document["said"] = last.comparison
    return conclude(f"batches_{options.case}", json.dumps(document, indent=1), bool(is_right))


if __name__ == "__main__":
    sys.exit(main())
