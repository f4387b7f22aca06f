"""Whether the stated errors hold at pairs of velocities 1 % apart, and how far rises jump there.

Five surfaces of each scene are computed by the presets and by `reference`, at two velocities. The
error of a critical velocity is that of the rise over 0.65; 95 % must be below the stated error, of
which the positions of the disk are a part. A jump is the change of the rise from one velocity to
the other, less the change by `reference`.

    python -m tests.promises.neighbours [--surfaces N] [--minutes M] [NAME ...]
"""

import argparse
import math
import sys
import time
from dataclasses import replace
from pathlib import Path

import numpy as np

import pipeline
from pipeline.constants import PRESET_BOUNDS, RISE_EXPONENT
from tests.helpers.campaigns import commit, compute, conclude, read, table
from tests.promises.moving_disk import decisive
from tests.promises.positions import stated
from tribo import PRESETS, SelfAffineRoughness, simulate

JUDGED = "standard", "fine"
RATIO = 1.01  # of the two velocities
MIN_HELD = 0.95
_WINDOW = {"window.pixels": [400, 96], "window.pixel_size": ["1.3 um", "1.5 um"]}
SCENES = {
    "without a lay": (_WINDOW, (5.5e-6, 5.5e-6), 310.0, 2.7),
    "lay across sliding": (_WINDOW, (4.5e-6, 70e-6), 480.0, 1.9),
    "local wear": (_WINDOW | {"wear.pattern": "local"}, (5.5e-6, 5.5e-6), 310.0, 2.7),
}
"""Entries, correlation lengths [m], load [N] and velocity [m/s] by name."""
FILE = Path("results/neighbours.jsonl")
HEADS = (
    "scene", "preset", "largest error of the velocity [%]", "stated [%]", "held", "largest jump [%]"
)  # fmt: skip


def ends(scene, preset, load, velocity):
    """ln of the rises Θ₁₀ at both velocities, and the errors of velocities that are stated."""
    scene, rises, errors = replace(scene, fidelity=PRESETS[preset]), [], []
    for speed in (velocity, RATIO * velocity):
        *_, state = simulate(scene, load, speed)
        rises.append(math.log(decisive(state.heat)))
        positions = stated(scene, state, speed) if scene.wears_by_strips else 0.0
        errors.append(math.hypot(PRESET_BOUNDS[preset], positions / RISE_EXPONENT))
    return np.array(rises), np.array(errors)


def computed(task):
    """Row of the file of a surface of a scene: deviations from `reference`, and stated errors."""
    name, seed = task
    began, (entries, lengths, load, velocity) = time.process_time(), SCENES[name]
    scene = pipeline.load_scene("first_try", "standard", entries).scene
    scene = replace(scene, roughness=SelfAffineRoughness(0.27e-6, 0.8, lengths, seed))
    row = {"name": f"{name}, {seed}", "commit": commit()}
    true, _ = ends(scene, "reference", load, velocity)
    for preset in JUDGED:
        rises, errors = ends(scene, preset, load, velocity)
        row[preset] = {"deviations": (rises - true).tolist(), "stated": errors.tolist()}
    return row | {"seconds": time.process_time() - began}


def judged(name, preset, rows):
    """Table row of a preset on the surfaces of a scene, whether errors held, and jumps."""
    deviations = np.array([row[preset]["deviations"] for row in rows])
    bounds = np.array([row[preset]["stated"] for row in rows])
    errors, jumps = np.abs(deviations) / RISE_EXPONENT, np.abs(np.diff(deviations))
    is_held = errors <= bounds
    cells = (
        f"{100 * errors.max():.2f}", f"{100 * bounds.min():.2f} to {100 * bounds.max():.2f}",
        f"{is_held.sum()} of {is_held.size}", f"{100 * jumps.max():.2f}",
    )  # fmt: skip
    return (name, preset, *cells), is_held.ravel().tolist(), jumps.ravel().tolist()


def main():
    parser = argparse.ArgumentParser(prog="python -m tests.promises.neighbours")
    parser.add_argument("names", nargs="*", default=[*SCENES], metavar="NAME")
    parser.add_argument("--surfaces", type=int, default=5)
    parser.add_argument("--minutes", type=float, default=30.0, help="begin no surface later")
    options = parser.parse_args()
    done = {row["name"] for row in read(FILE)}
    tasks = [(name, 700 + k) for k in range(options.surfaces) for name in options.names]
    missing = [(name, seed) for name, seed in tasks if f"{name}, {seed}" not in done]
    compute(computed, missing, FILE, options.minutes)
    lines, statements, is_right = [], [], True
    for preset in JUDGED:
        all_held, all_jumps = [], []
        for name in options.names:
            rows = [row for row in read(FILE) if row["name"].rpartition(",")[0] == name]
            if rows:
                line, is_held, jumps = judged(name, preset, rows)
                lines.append(line)
                all_held += is_held
                all_jumps += jumps
        statements.append(
            f"`{preset}` {sum(all_held)} of {len(all_held)} within the stated error, largest jump "
            f"{max(all_jumps):.2%}"
        )
        is_right &= bool(np.mean(all_held) >= MIN_HELD)
    return conclude("neighbours", f"{table(HEADS, lines)}\n\n{', '.join(statements)}", is_right)


if __name__ == "__main__":
    sys.exit(main())
