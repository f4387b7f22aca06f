"""Whether the stated error by positions of the disk holds, on pins that wear under its strips.

Each scene is computed with its strips at several other positions. A rise may differ from their mean
by the error that one realization states; 95 % of the rises must. Half of the scenes have a lay.

    python -m tests.promises.positions [--scenes N] [--preset NAME ...]
"""

import argparse
import sys
from dataclasses import replace
from unittest import mock

import numpy as np
from scipy.special import stdtrit

import pipeline
from pipeline.constants import POSITION_LIMIT, POSITION_SHARE
from tests.helpers.campaigns import conclude, table
from tests.promises.moving_disk import decisive, oblique_heights
from tribo import PRESETS, QUANTILES, Grid, MeasuredRoughness, Wear, simulate
from tribo.simulation import disk_positions, fit_elements, heat

SHIFTS, STAGES = 6, 1000  # other positions of the strips, and stages between two of them
MIN_HELD = 0.95  # the level of all bounds
HEADS = "lengths [µm]", "angle", "N", "wear [m²/N]", "random [%]", "stated [%]", "held"


def drawn(number, preset):
    """Scene, load [N], velocity [m/s] and description of the scene of a number, odd with a lay."""
    rng, has_lay = np.random.default_rng(17000 + number), number % 2
    across = np.exp(rng.uniform(np.log(3), np.log(6 if has_lay else 12)))
    along = np.exp(rng.uniform(np.log(20), np.log(300))) if has_lay else across
    angle = float(rng.choice([0, 0, 20, 45, 90])) if has_lay else 0.0
    load = np.exp(rng.uniform(np.log(100), np.log(750)))
    velocity = 2.25 * (load / 400) ** -0.85 * rng.uniform(0.8, 1.2)
    ra, wear_rate = np.exp(rng.uniform(np.log([1e-7, 2e-16]), np.log([6e-7, 4e-15])))
    pixels = Grid((400, int(rng.choice([64, 96, 160, 240]))), (1.632e-6, 1.9e-6), (False, True))
    lengths = 1e-6 * across, 1e-6 * along
    heights = oblique_heights(pixels, angle, 19000 + number, lengths, ra)
    scene = pipeline.load_scene("first_try", preset).scene
    material = replace(scene.disk, hardness=rng.uniform(3e9, 9e9))
    scene = replace(
        scene, pixels=pixels, roughness=MeasuredRoughness(heights), wear=Wear(wear_rate),
        disk=material, pin=replace(scene.pin, material=material),
    )  # fmt: skip
    text = f"{across:.1f} × {along:.0f}", f"{angle:g}°", f"{load:.0f}", f"{wear_rate:.1e}"
    return scene, load, velocity, text


def rises_at_shifts(scene, load, velocity):
    """ln of the rises Θ₁₀ with the strips at other positions, and the last state."""
    shifts, rises = disk_positions._strip_shifts, []
    for number in range(SHIFTS):
        offset = STAGES * number

        def shifted(scene, stage, velocity, offset=offset):
            return shifts(scene, stage + offset, velocity)

        with mock.patch.object(disk_positions, "_strip_shifts", shifted):
            *_, state = simulate(scene, load, velocity)
        rises.append(decisive(state.heat))
    return np.log(rises), state


def stated(scene, state, velocity):
    """Error by positions that one realization states."""
    sampling = heat(fit_elements(scene, state.normal_load), state, velocity, True).sampling
    freedom, limit = sampling["rise_realization_freedom"], POSITION_LIMIT
    if not freedom:
        return limit
    deviation = sampling["rise_realization_std"][QUANTILES.index(0.9)]
    return min(POSITION_SHARE * stdtrit(freedom, 0.975) * deviation, limit)


def judged(preset, count):
    """Table rows of `count` scenes by a preset, and whether the stated error held at each rise."""
    rows, is_held = [], []
    for number in range(count):
        scene, load, velocity, text = drawn(number, preset)
        rises, state = rises_at_shifts(scene, load, velocity)
        # The mean includes each rise, so that its distance is too short by this factor.
        errors = np.abs(rises - rises.mean()) * np.sqrt(SHIFTS / (SHIFTS - 1))
        bound = stated(scene, state, velocity)
        is_held += (errors <= bound).tolist()
        random = f"{100 * rises.std(ddof=1):.2f}", f"{100 * bound:.2f}"
        rows.append((*text, *random, f"{(errors <= bound).sum()} of {SHIFTS}"))
    return rows, is_held


def main():
    parser = argparse.ArgumentParser(prog="python -m tests.promises.positions", description=__doc__)
    parser.add_argument("--scenes", type=int, default=30)
    parser.add_argument("--preset", nargs="*", default=["standard", "fine"], choices=PRESETS)
    options = parser.parse_args()
    tables, statements, is_right = [], [], True
    for preset in options.preset:
        rows, is_held = judged(preset, options.scenes)
        tables.append(table(HEADS, rows))
        statements.append(f"`{preset}` {np.mean(is_held):.1%} of {len(is_held)} rises")
        is_right &= bool(np.mean(is_held) >= MIN_HELD)
    statement = f"{', '.join(statements)}, on {options.scenes} scenes, half of them with a lay"
    return conclude("positions", "\n\n".join([*tables, statement]), is_right)


if __name__ == "__main__":
    sys.exit(main())
