"""How the rise of heavily worn balls moves with the number of steps, and of positions of the disk.

Each ball wears by 9 to 64 times the roughness, whose summits pass over it, and touches on so few
elements that its temperature is a mean over positions of the disk. `standard` is held to its bound
where `FEWEST` elements touch or more. Where fewer do, each has a warning, and its move is told.
Every other ball has large pixels, on few of which it touches.
"""

import argparse
import math
import sys
from dataclasses import replace
from unittest import mock

import numpy as np
from scipy.optimize import brentq

import tribo
from tests.helpers.campaigns import conclude, table
from tests.promises.report import PROMISED
from tests.promises.scenes import PAIRS
from tests.promises.wide import hertz
from tribo.simulation import disk_positions
from tribo.simulation.step_measures import touching_elements

_NINE_TENTHS = tribo.QUANTILES.index(0.9)
STEPS = 25, 50, 100
FEWEST = 1000  # below which a ball is warned of few elements
_PIXELS = 160, 64  # across a window
_COUNTS = ("_MOST_POSITIONS", "_PIXELS")


def worn_ball(seed):
    """A rough ball that wears heavily, its load [N] and its velocity [m/s]."""
    rng = np.random.default_rng([seed, 66])

    def log(low, high):
        return math.exp(rng.uniform(math.log(low), math.log(high)))

    pin, disk = PAIRS[rng.integers(len(PAIRS))]
    ball, velocity, seconds = tribo.Ball(log(1e-3, 20e-3), pin), log(0.05, 3.0), rng.uniform(2, 8)
    pressure = rng.uniform(0.15, 0.4) * min(pin.hardness, disk.hardness, 4e9)
    load, (half_width, _) = hertz(ball, disk, pressure)
    ra = log(0.05e-6, 0.3e-6)
    depth = ra * log(9, 64)
    volume = math.exp(
        brentq(lambda x: ball.worn(half_width, math.exp(x)).depth - depth, -70.0, -10.0)
    )
    count = _PIXELS[seed % 2]
    side = 1.3 * ball.worn(half_width, volume).width / count
    scene = tribo.Scene(
        pin=ball,
        disk=disk,
        pixels=tribo.Grid((count, count), (side, side), (False, False)),
        loading=tribo.Ramp(load / seconds, load),
        roughness=tribo.SelfAffineRoughness(ra, 0.8, (rng.uniform(2, 5) * side,) * 2, seed),
        wear=tribo.Wear(volume / (load * velocity * seconds / 2)),
        fidelity=tribo.PRESETS["standard"],
    )
    return scene, load, velocity


def end(scene, load, velocity):
    """Rise that a tenth of the contact exceeds at the end [K], and the elements that touch."""
    *_, state = tribo.simulate(scene, load, velocity)
    return float(state.heat.rise_quantile[_NINE_TENTHS]), touching_elements(scene, state)


def moves(scene, load, velocity):
    """Elements, and how far the rise moves with twice the steps and twice the positions."""
    steps = [replace(scene, fidelity=replace(scene.fidelity, increments=n)) for n in STEPS]
    ends = [end(one, load, velocity) for one in steps]
    twice = {name: 2 * getattr(disk_positions, name) for name in _COUNTS}
    with mock.patch.multiple(disk_positions, **twice):
        more, _ = end(scene, load, velocity)
    first, second, third = (rise for rise, _ in ends)
    return ends[0][1], second / first - 1, third / second - 1, third / first - 1, more / first - 1


def main():
    """Compute balls by their seeds, and say how far their rises move."""
    parser = argparse.ArgumentParser(prog="python -m tests.promises.worn", description=__doc__)
    parser.add_argument("--balls", type=int, default=16, help="seeds below this one")
    found = []
    for seed in range(parser.parse_args().balls):
        scene, load, velocity = worn_ball(seed)
        found.append(moves(scene, load, velocity))
        shown = ", ".join(f"{move:+.2%}" for move in found[-1][1:])
        words = f"{1e3 * scene.pin.radius:.3g} mm, {load:.3g} N, {velocity:.2g} m/s"
        print(f"{seed} {words}, {found[-1][0]:.0f} elements: {shown}", file=sys.stderr, flush=True)
    low, mid, high = STEPS
    names = [f"{low} to {mid} steps", f"{mid} to {high} steps", f"{low} to {high} steps"]
    names.append("twice the positions")
    touching, *changes = np.abs(found).T
    enough = touching >= FEWEST
    rows = [
        (words, name, which.sum(), f"{np.median(sizes[which]):.2%}", f"{sizes[which].max():.2%}")
        for which, words in ((enough, f"at least {FEWEST}"), (~enough, "fewer"))
        for name, sizes in zip(names, changes, strict=True)
        if which.any()
    ]
    report = table(("elements", "change", "balls", "median", "largest"), rows)
    kept = np.transpose(changes)[enough] <= PROMISED["standard"]
    return conclude("worn", report, bool(kept.all()))


if __name__ == "__main__":
    sys.exit(main())
