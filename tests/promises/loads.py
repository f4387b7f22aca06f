"""Judge the common estimate of all loads: searches of planes whose boundary is known.

Each plane has a closed form with realizations at random (`tests.helpers.plane_model`). A search
for an accuracy ends with stated errors; without the preset's part, these have to hold at 95 % of
loads, and halfway between them. Loads of one plane share realizations, so shares are judged by the
number of planes.

    python -m tests.promises.loads                              # all kinds, in minutes
    python -m tests.promises.loads --planes 100 --loads 5 --accuracy 1
"""

import argparse
import sys

import numpy as np

from pipeline.constants import PRESET_BOUNDS
from tests.helpers.campaigns import conclude, table
from tests.helpers.plane_model import LOADS, PlaneModel, Verdict
from tests.promises.goals import highest_share

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
HEADS = "planes", "loads", "accuracy", "points", "reached", "held at loads", "held between them"


def promised(accuracy):
    """Error of the preset that a run with this accuracy has."""
    return PRESET_BOUNDS["standard" if accuracy > 1.25 * PRESET_BOUNDS["standard"] else "fine"]


def judged(kind, load_count, accuracy, planes):
    """Table row of a kind of planes, and True if stated errors may hold at 95 % of loads."""
    verdicts = []
    for seed in range(planes):
        model = PlaneModel(LOADS[load_count], seed, **KINDS[kind])
        verdicts.append(Verdict.of(model, model.search(accuracy, promised(accuracy))))
    points = [verdict.points for verdict in verdicts]
    reached = sum(verdict.stated <= accuracy for verdict in verdicts)
    at = np.mean([verdict.is_held_at.mean() for verdict in verdicts])
    between = np.mean([verdict.is_held_between.mean() for verdict in verdicts])
    is_right = min(highest_share(share, planes) for share in (at, between)) >= MIN_HELD
    count = f"{np.mean(points):.0f} ({min(points)} to {max(points)})"
    cells = f"{100 * accuracy:g} %", count, f"{reached} of {planes}", f"{at:.1%}", f"{between:.1%}"
    return (kind, load_count, *cells), is_right


def main():
    parser = argparse.ArgumentParser(prog="python -m tests.promises.loads", description=__doc__)
    parser.add_argument("--planes", type=int, default=20, help="planes of each kind")
    parser.add_argument("--loads", type=int, nargs="+", default=[4, 12, 15, 30], choices=LOADS)
    parser.add_argument("--accuracy", type=float, nargs="+", default=[1.0, 2.0], help="per cent")
    options = parser.parse_args()
    rows = [
        judged(kind, load_count, accuracy / 100, options.planes)
        for kind in KINDS
        for load_count in options.loads
        for accuracy in options.accuracy
    ]
    lines, are_right = zip(*rows, strict=True)
    return conclude("loads", table(HEADS, lines), all(are_right))


if __name__ == "__main__":
    sys.exit(main())
