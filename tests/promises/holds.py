"""Judge the presets on scenes whose load is held, at one place of each scene.

The scenes are those of the wide family with a hold of 4 to 300 s, whose worst moment lies anywhere:
in every second one the bulk of the disk warms meanwhile. Balls and crowned pins that roughness
passes are left out, since nearly exact steps on them take ten minutes each.
"""

import argparse
import math
import sys
from dataclasses import replace

import numpy as np

from tests.helpers.campaigns import conclude, table
from tests.helpers.entries import changed
from tests.promises.judge import TRUTH
from tests.promises.report import COLUMNS, PROMISED, are_right, kept
from tests.promises.scenes import window_guess
from tests.promises.wide import random_wide_sweep
from tribo import PRESETS, Bulk, Conditions, Corrections, Ramp, judge, simulate, warnings

_APART = 0.03  # of the logarithm of the velocity, over which its exponent is taken


def held(seed):
    """Scene, load, velocity and conditions of a hold; None where the roughness passes a ball."""
    sweep, rng = random_wide_sweep(seed), np.random.default_rng([seed, 65])
    load, velocity = sweep.plane.loads[-1], 4 * sweep.plane.velocities[0]
    ramp = Ramp(load / rng.uniform(2, 8), load, math.exp(rng.uniform(math.log(4), math.log(300))))
    sweep = changed(sweep, loading=ramp, unequal_bulks=False)
    if sweep.scene.sweeps_over or not sweep.scene.wears:
        return None
    lengths = [1.0, 1.0]
    if rough := sweep.scene.roughness:
        pairs = zip(rough.correlation_length, sweep.scene.pixels.spacing, strict=True)
        lengths = [length / size for length, size in pairs]
    scene = window_guess(sweep, lengths, velocity).scene
    warming, settled = math.exp(rng.uniform(3, 5)), ramp.hold * math.exp(rng.uniform(-2.3, 0.7))
    loss = 0.1 * load * velocity / warming
    bulk = Corrections(disk_bulk=Bulk(capacity=settled * loss, loss=loss)) if seed % 2 else None
    return (
        scene,
        load,
        velocity,
        Conditions(friction=0.1, bulk_temperature=298.15, corrections=bulk),
    )


def rise(fidelity, scene, load, velocity, conditions):
    """Rise of the decisive temperature at its worst moment [K]."""
    found = judge(replace(scene, fidelity=fidelity), load, velocity, conditions)
    return found.decisive_temperature - found.bulk_temperature


def errors(place):
    """Error of the critical velocity by each preset, and the kinds of its warnings."""
    scene, load, velocity, conditions = place
    low, high = (
        rise(PRESETS["draft"], scene, load, velocity * math.exp(way), conditions)
        for way in (-_APART, _APART)
    )
    exponent = min(max(math.log(high / low) / (2 * _APART), 0.2), 2.0)
    true, rows = rise(TRUTH, *place), {}
    for name in PROMISED:
        own = replace(scene, fidelity=PRESETS[name])
        *_, state = simulate(own, load, velocity)
        found = math.log(rise(PRESETS[name], *place) / true) / exponent
        rows[name] = found, {warning.kind.label for warning in warnings(own, state)}
    return rows


def main():
    """Judge scenes by their seeds, and say which bounds are kept."""
    parser = argparse.ArgumentParser(prog="python -m tests.promises.holds", description=__doc__)
    parser.add_argument("--first", type=int, default=400, help="seed to begin with")
    parser.add_argument("--scenes", type=int, default=445, help="seeds below this one")
    options = parser.parse_args()
    found = []
    for seed in range(options.first, options.scenes):
        if not (place := held(seed)):
            continue
        found.append(errors(place))
        kind, hold = type(place[0].pin).__name__, place[0].loading.hold
        row = ", ".join(f"{name} {error:+.2%}" for name, (error, _) in found[-1].items())
        print(f"{seed} {kind}, {hold:.0f} s: {row}", file=sys.stderr, flush=True)
    rows = [
        kept(name, bound, *zip(*((abs(row[name][0]), row[name][1]) for row in found), strict=True))
        for name, bound in PROMISED.items()
    ]
    return conclude("holds", table(COLUMNS, rows), are_right(rows, "wide"))


if __name__ == "__main__":
    sys.exit(main())
