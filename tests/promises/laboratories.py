"""What verdicts promise: synthetic laboratories with a known truth.

Each has a bias and a scatter drawn from their priors. Its tests are drawn, and points judged that
it has not tested.
"""

import sys

import numpy as np

from pipeline.answers.posterior import Outcome, Prior, update
from tests.helpers.campaigns import conclude, table

KINDS = "transitions", "stages", "outcomes"
HEADS = (
    "tests", "kind", "bias in 90 %", "mild at 2 to 5 %, severe", "severe at 95 to 98 %, mild",
)  # fmt: skip
_STAGE, _POINTS = 0.15, 40
_INSIDE, _MAX_WRONG = (0.85, 0.95), 0.07


def tests(kind, count, rng, bias, scatter):
    """Results of tests on specimens whose ln(rise) has errors `bias` and `scatter`."""
    at = -(bias + scatter * rng.normal(size=count))  # y of each specimen's transition
    if kind == "transitions":
        return tuple(Outcome(y, y) for y in at.tolist())
    if kind == "stages":
        severe = at + rng.uniform(0, _STAGE, count)
        return tuple(Outcome(y, y - _STAGE) for y in severe.tolist())
    pairs = zip(rng.uniform(-0.4, 0.4, count).tolist(), at.tolist(), strict=True)
    return tuple(
        Outcome(severe=y) if y > transition else Outcome(mild=y) for y, transition in pairs
    )


def laboratory(kind, count, rng):
    """Position of the true bias in its distribution; stated probabilities, and outcomes."""
    prior = Prior()
    bias = prior.bias * rng.standard_t(4)
    scatter = prior.scatter * np.sqrt(4 / rng.chisquare(4))
    belief = update(tests(kind, count, rng, bias, scatter), prior)
    y = rng.uniform(-0.5, 0.3, _POINTS)
    severe = y + bias + scatter * rng.normal(size=_POINTS) > 0
    return belief.weights[belief.bias < bias].sum(), belief.probability(y), severe


def judged(kind, count, number, seed=0):
    """Shares of intervals that contain the bias, and of wrong ones among verdicts near a limit."""
    rng = np.random.default_rng(seed)
    parts = [laboratory(kind, count, rng) for _ in range(number)]
    positions = np.array([position for position, _, _ in parts])
    stated, severe = (np.concatenate([part[k] for part in parts]) for k in (1, 2))
    mild, hot = (stated > 0.02) & (stated <= 0.05), (stated >= 0.95) & (stated < 0.98)
    inside = float(np.mean((positions > 0.05) & (positions < 0.95)))
    return inside, float(severe[mild].mean()), float((~severe[hot]).mean())


def main():
    """Judge as many laboratories of each kind as the command says, 400 if it does not."""
    number = int(sys.argv[1]) if sys.argv[1:] else 400
    rows, is_right = [], True
    for kind in KINDS:
        for count in (2, 4, 8):
            inside, *wrong = judged(kind, count, number)
            is_right &= _INSIDE[0] <= inside <= _INSIDE[1] and max(wrong) <= _MAX_WRONG
            rows.append((count, kind, *(f"{100 * share:.1f} %" for share in (inside, *wrong))))
            print(*rows[-1], file=sys.stderr, flush=True)
    return conclude("laboratories", table(HEADS, rows), is_right)


if __name__ == "__main__":
    sys.exit(main())
