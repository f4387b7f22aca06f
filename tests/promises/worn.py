"""How the rise of heavily worn balls moves with the number of steps, and of positions of the disk.

Each ball wears by 9 to 64 times the roughness, whose summits pass over it. Where it touches on few
elements, its temperature is a mean over positions of the disk, and a warning says that they are
few. Without the warning `standard` is held to its bound as the steps grow. All presets share the
positions, which stand for surfaces: how far the rise moves with more of them is told.
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
_PIXELS = 384  # across a window
_FIRST = 100  # seed; balls of smaller ones set the limits of the warning
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
    side = 1.3 * ball.worn(half_width, volume).width / _PIXELS
    scene = tribo.Scene(
        pin=ball,
        disk=disk,
        pixels=tribo.Grid((_PIXELS, _PIXELS), (side, side), (False, False)),
        loading=tribo.Ramp(load / seconds, load),
        roughness=tribo.SelfAffineRoughness(ra, 0.8, (rng.uniform(2, 5) * side,) * 2, seed),
        wear=tribo.Wear(volume / (load * velocity * seconds / 2)),
        fidelity=tribo.PRESETS["standard"],
    )
    return scene, load, velocity


def end(scene, load, velocity):
    """Rise that a tenth of the contact exceeds at the end [K]."""
    *_, state = tribo.simulate(scene, load, velocity)
    return float(state.heat.rise_quantile[_NINE_TENTHS])


def moves(scene, load, velocity):
    """Elements, and how far the rise moves with twice the steps and twice the positions.

    The moves are None where a warning says that few elements touch.
    """
    steps = [replace(scene, fidelity=replace(scene.fidelity, increments=n)) for n in STEPS]
    *_, state = tribo.simulate(steps[0], load, velocity)
    if any(one.kind is tribo.WarningKind.FEW_NODES for one in tribo.warnings(steps[0], state)):
        return touching_elements(scene, state), None
    first, second, third = (end(one, load, velocity) for one in steps)
    twice = {name: 2 * getattr(disk_positions, name) for name in _COUNTS}
    with mock.patch.multiple(disk_positions, **twice):
        more = end(steps[0], load, velocity)
    shares = second / first, third / second, third / first, more / first
    return touching_elements(scene, state), [share - 1 for share in shares]


def main():
    """Compute balls by their seeds, and say how far their rises move."""
    parser = argparse.ArgumentParser(prog="python -m tests.promises.worn", description=__doc__)
    parser.add_argument("--balls", type=int, default=40, help="so many")
    found, warned = [], 0
    for seed in range(_FIRST, _FIRST + parser.parse_args().balls):
        scene, load, velocity = worn_ball(seed)
        elements, changes = moves(scene, load, velocity)
        shown = ", ".join(f"{move:+.2%}" for move in changes) if changes else "with a warning"
        words = f"{1e3 * scene.pin.radius:.3g} mm, {load:.3g} N, {velocity:.2g} m/s"
        print(f"{seed} {words}, {elements:.0f} elements: {shown}", file=sys.stderr, flush=True)
        if changes:
            found.append(changes)
        warned += not changes
    low, mid, high = STEPS
    names = [f"{low} to {mid} steps", f"{mid} to {high} steps", f"{low} to {high} steps"]
    names.append("twice the positions")
    sizes = np.abs(found).reshape(-1, len(names))
    rows = [
        (name, f"{np.median(one):.2%}", f"{one.max():.2%}")
        for name, one in zip(names, sizes.T, strict=True)
        if len(one)
    ]
    report = f"{len(found)} balls, and {warned} with a warning\n\n"
    report += table(("change", "median", "largest"), rows)
    kept = sizes[:, :-1] <= PROMISED["standard"]
    return conclude("worn", report, bool(found and kept.all()))


if __name__ == "__main__":
    sys.exit(main())
