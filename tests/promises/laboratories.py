"""What verdicts promise where inputs are uncertain: synthetic laboratories with a known truth.

Each has four inputs, a bias and a scatter drawn from their priors. Its tests are drawn, and places
judged that it has not tested.
"""

import sys

import numpy as np
from pipeline.analysis.likelihood import Prior, SpecimenResult, condition
from scipy.special import ndtr

from tests.helpers.campaigns import conclude, table

KINDS = "transitions", "stages", "outcomes"
HEADS = (
    "tests", "kind", "shift in 90 %", "mild at 2 to 5 %, severe", "severe at 95 to 98 %, mild",
)  # fmt: skip
_STAGE, _INPUTS, _PLACES = 0.15, 4, 40
_HELD, _MOST_WRONG = (0.85, 0.95), 0.07


def tests(kind, rng, shift, scatter, effects):
    """Results of tests on specimens whose latent values are moved by `shift` and `scatter`."""
    n = len(shift)
    at = -(shift + scatter * rng.normal(size=n))  # y of each specimen's transition
    y = {
        "transitions": at,
        "stages": at + rng.uniform(0, _STAGE, n),
        "outcomes": rng.uniform(-0.4, 0.4, n),
    }[kind]
    width = {"transitions": 0.0, "stages": _STAGE, "outcomes": np.inf}[kind]
    signs = np.where(y > at, 1, -1) if kind == "outcomes" else np.ones(n, int)
    rows = zip(y.tolist(), signs.tolist(), effects.tolist(), strict=True)
    return tuple(SpecimenResult(one, sign, width, a=tuple(a)) for one, sign, a in rows)


def cumulated(belief, a, shift):
    """Probability that the places' common shift is below `shift`."""
    size = np.column_stack([np.broadcast_to(a, (len(belief.bias), len(a))), belief.bias])
    mean = np.einsum("gk,gk->g", size, belief.means)
    variance = np.einsum("gk,gkl,gl->g", size, belief.covariances, size)
    return float(belief.weights @ ndtr((shift - mean) / np.sqrt(variance)))


def laboratory(kind, count, rng):
    """Position of the true shift in its distribution; stated probabilities, and outcomes."""
    a = rng.normal(-0.05, 0.08, _INPUTS)
    effects = a * rng.uniform(0.7, 1.3, (count, _INPUTS))
    z, bias = rng.normal(size=_INPUTS), 0.05 * rng.standard_t(4)
    scatter = 0.055 * np.sqrt(4 / rng.chisquare(4))
    seen = tests(kind, rng, effects @ z + bias, scatter, effects)
    belief, true = condition(seen, Prior(), _INPUTS), float(a @ z) + bias
    y = rng.uniform(-0.5, 0.3, _PLACES)
    severe = y + true + scatter * rng.normal(size=_PLACES) > 0
    return cumulated(belief, a, true), belief.probability(y, tuple(a)), severe


def judged(kind, count, number, seed=0):
    """Shares: intervals that hold the shift, and wrong verdicts that are barely mild and severe."""
    rng = np.random.default_rng(seed)
    parts = [laboratory(kind, count, rng) for _ in range(number)]
    places = np.array([place for place, _, _ in parts])
    stated, severe = (np.concatenate([part[k] for part in parts]) for k in (1, 2))
    mild, hot = (stated > 0.02) & (stated <= 0.05), (stated >= 0.95) & (stated < 0.98)
    held = float(np.mean((places > 0.05) & (places < 0.95)))
    return held, float(severe[mild].mean()), float((~severe[hot]).mean())


def main():
    """Judge as many laboratories of each kind as the command says, 400 if it does not."""
    number = int(sys.argv[1]) if sys.argv[1:] else 400
    rows, is_right = [], True
    for kind in KINDS:
        for count in (2, 4, 8):
            held, *wrong = judged(kind, count, number)
            is_right &= _HELD[0] <= held <= _HELD[1] and max(wrong) <= _MOST_WRONG
            rows.append((count, kind, *(f"{100 * share:.1f} %" for share in (held, *wrong))))
            print(*rows[-1], file=sys.stderr, flush=True)
    return conclude("laboratories", table(HEADS, rows), is_right)


if __name__ == "__main__":
    sys.exit(main())
