"""Judge the presets on balls and crowned pins of the wide family, at one place of each scene.

That is the middle load at the velocity in the middle of the diagram, where the boundary lies. The
error of a critical velocity is that of the rise there over its exponent, which takes a tenth of the
time of a boundary that is sought.
"""

import argparse
import math
import sys

from pipeline.tradeoff.probe import Target
from tests.helpers.campaigns import conclude, table
from tests.promises.judge import TRUTH, exponent_at, rise_at
from tests.promises.report import COLUMNS, PROMISED, are_right, kept
from tests.promises.wide import random_wide_sweep
from tribo import PRESETS, Cylinder


def errors(sweep):
    """Error of the critical velocity by each preset, and the kinds of its warnings."""
    place = Target(sweep.plane.loads[1], sweep.variants.names[0])
    velocity = 4 * sweep.plane.velocities[0]
    exponent = exponent_at(sweep, PRESETS["draft"], place, velocity)
    true, _ = rise_at(sweep, TRUTH, place, velocity)
    rows = {}
    for name in PROMISED:
        rise, warnings = rise_at(sweep, PRESETS[name], place, velocity)
        rows[name] = math.log(rise / true) / exponent, {one.kind.label for one in warnings}
    return rows


def main():
    """Judge scenes by their seeds, and say which bounds are kept."""
    parser = argparse.ArgumentParser(prog="python -m tests.promises.curved", description=__doc__)
    parser.add_argument("--first", type=int, default=300, help="seed to begin with")
    parser.add_argument("--scenes", type=int, default=345, help="seeds below this one")
    options = parser.parse_args()
    found = []
    for seed in range(options.first, options.scenes):
        sweep = random_wide_sweep(seed)
        pin = type(sweep.scene.pin)
        if pin is Cylinder:
            continue
        found.append(errors(sweep))
        row = ", ".join(f"{name} {error:+.2%}" for name, (error, _) in found[-1].items())
        print(f"{seed} {pin.__name__}: {row}", file=sys.stderr, flush=True)
    rows = [
        kept(name, bound, *zip(*((abs(row[name][0]), row[name][1]) for row in found), strict=True))
        for name, bound in PROMISED.items()
    ]
    return conclude("curved", table(COLUMNS, rows), are_right(rows, "wide"))


if __name__ == "__main__":
    sys.exit(main())
