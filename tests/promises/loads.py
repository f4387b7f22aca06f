"""Judge the common estimate of all loads: searches of planes whose boundary is known.

Each plane has a closed form with realizations at random (`tests.helpers.plane_model`). A search
for an accuracy ends with stated errors; without the preset's part, these have to hold at 95 % of
loads, and halfway between them. This is judged for each kind of planes, and for all planes. Loads
of a plane share realizations, so the standard error is that of the shares of planes.

    python -m tests.promises.loads                              # all kinds, in minutes
    python -m tests.promises.loads --planes 100 --loads 5 --accuracy 1
"""

import argparse
import sys

import numpy as np

from pipeline.constants import PRESET_BOUNDS
from tests.helpers.campaigns import conclude, table
from tests.helpers.plane_model import LOADS, PlaneModel, Verdict

KINDS = {
    "as irg_transition": {},
    "independent loads": {"correlation": 0.0},
    "correlation 0.3": {"correlation": 0.3},
    "correlation 0.9": {"correlation": 0.9},
    "flat boundary": {"steepness": 0.4},
    "steep boundary": {"steepness": 1.5},
    "realizations drift along velocity": {"drift": 10.0},
    "small deviations": {"scale": 0.4},
    "grooves along y": {"scale": 2.0, "freedom": 3.0},
}
"""Options of planes."""
MIN_HELD = 0.95
MAX_DISTANCE = 3.0  # of a share of planes from `MIN_HELD` by chance, in standard errors
HEADS = "planes", "loads", "accuracy", "points", "reached", "held at loads", "held between them"
KIND_HEADS = "planes", "number", "held at loads", "held between them"


def promised(accuracy):
    """Error of the preset that a run with this accuracy has."""
    return PRESET_BOUNDS["standard" if accuracy > 1.25 * PRESET_BOUNDS["standard"] else "fine"]


def searched(kind, load_count, accuracy, planes):
    """Verdicts on the searches of some planes of a kind."""
    models = (PlaneModel(LOADS[load_count], seed, **KINDS[kind]) for seed in range(planes))
    return [Verdict.of(model, model.search(accuracy, promised(accuracy))) for model in models]


def shares_of(verdicts):
    """Shares of loads, and of positions between them, whose stated error holds (n_plane, 2)."""
    held = [(verdict.is_held_at, verdict.is_held_between) for verdict in verdicts]
    return np.array([(at_loads.mean(), between.mean()) for at_loads, between in held])


def search_row(kind, load_count, accuracy, verdicts):
    """Table row of the searches of a kind of planes for an accuracy."""
    points = [verdict.points for verdict in verdicts]
    reached = sum(verdict.stated <= accuracy for verdict in verdicts)
    count = f"{np.mean(points):.0f} ({min(points)} to {max(points)})"
    held = (f"{share:.1%}" for share in shares_of(verdicts).mean(axis=0))
    return kind, load_count, f"{100 * accuracy:g} %", count, f"{reached} of {len(points)}", *held


def kind_row(kind, shares):
    """Table row of the `shares` of planes (n_plane, 2), and True if both may be 95 %."""
    means, errors = shares.mean(axis=0), shares.std(axis=0, ddof=1) / len(shares) ** 0.5
    cells = [
        f"{100 * mean:.1f} ± {100 * error:.1f} %" for mean, error in zip(means, errors, strict=True)
    ]
    may_hold = (means + MAX_DISTANCE * errors >= MIN_HELD).all()
    return (kind, len(shares), *cells), bool(may_hold)


def main():
    parser = argparse.ArgumentParser(prog="python -m tests.promises.loads", description=__doc__)
    parser.add_argument("--planes", type=int, default=20, help="planes of each kind")
    parser.add_argument("--loads", type=int, nargs="+", default=[4, 12, 15, 30], choices=LOADS)
    parser.add_argument("--accuracy", type=float, nargs="+", default=[1.0, 2.0], help="per cent")
    options = parser.parse_args()
    rows, shares_by_kind = [], {}
    for kind in KINDS:
        shares = []
        for load_count in options.loads:
            by_accuracy = []
            for accuracy in options.accuracy:
                verdicts = searched(kind, load_count, accuracy / 100, options.planes)
                rows.append(search_row(kind, load_count, accuracy / 100, verdicts))
                by_accuracy.append(shares_of(verdicts))
            shares.append(np.mean(by_accuracy, axis=0))  # searches of the same planes
        shares_by_kind[kind] = np.concatenate(shares)
    # Planes of different kinds are drawn with the same numbers, and so are not independent.
    shares_by_kind["mean of all"] = np.mean([*shares_by_kind.values()], axis=0)
    lines, may_hold = zip(*(kind_row(*item) for item in shares_by_kind.items()), strict=True)
    text = "\n\n".join([table(HEADS, rows), table(KIND_HEADS, lines)])
    return conclude("loads", text, all(may_hold))


if __name__ == "__main__":
    sys.exit(main())
