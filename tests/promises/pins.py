"""Whether the stated errors of presets hold for pins that are computed with their ends.

The rise errs by the preset, and at random by the positions of the disk at which the pin wears. A
rise is right if it is within both errors, as one realization states them; 95 % of the rises must.

Short pins are compared with `reference`. Pins of the length of `whole_pin` are too large for it:
they are compared with `fine` at a contact tolerance of 0.01. Short pins have pixels of a fifth of
the correlation length, as the shipped scene has, and every other one has a lay or relieved ends. A
short pin takes up to 40 s of CPU time and 0.3 GB of memory, and a long one up to 3 min and 1.5 GB.
Short pins that wear locally, or not at all, have no error by positions.

    python -m tests.promises.pins [--short N] [--local N] [--unworn N] [--long N] [--minutes M]
"""

import argparse
import sys
import time
from dataclasses import replace
from pathlib import Path

import numpy as np
from scipy.special import stdtrit

import pipeline
from pipeline.answers.error import position_limit
from pipeline.constants import POSITION_SHARE, PRESET_BOUNDS, RISE_EXPONENT
from tests.helpers.campaigns import commit, compute, conclude, read, table
from tests.promises.moving_disk import decisive
from tribo import PRESETS, QUANTILES, TriboError, simulate, warnings
from tribo.simulation import fit_elements, heat

JUDGED = "standard", "fine"
_STEP = 0.1  # of ln(velocity), for the exponent of the rise
MIN_HELD = 0.95  # the level of all bounds
HEADS = (
    "pins", "N", "m/s", *(f"error of `{name}` [%]" for name in JUDGED),
    *(f"stated by `{name}` [%]" for name in JUDGED), "exponent", "warnings",
)  # fmt: skip
FILE = Path("results/pins.jsonl")


def short_pin(number):
    """Entries of a pin of 1 mm of a number, its load [N] and velocity [m/s]."""
    rng = np.random.default_rng(26000 + number)
    line_load, length = np.exp(rng.uniform(np.log(200), np.log(750))), rng.uniform(10, 16)
    velocity = 2.25 * (line_load / 400) ** -0.85 * rng.uniform(0.8, 1.2)
    lay = rng.uniform(4, 12) if number % 2 else 1.0
    wear = 1.2e-6 * np.exp(rng.uniform(np.log(0.1), np.log(2)))
    entries = {
        "pin.length": "1 mm",
        "disk.roughness.correlation_length": [f"{length:.4g} um", f"{lay * length:.4g} um"],
        "disk.roughness.seed": number,
        "window.pixels": [192, 240],
        "window.pixel_size": [f"{length / 4.9:.4g} um", f"{length / 4.2:.4g} um"],
        "wear.specific_wear_rate": f"{wear:.4g} mm^3/(N m)",
        "loading.rate": f"{150 / 3.4:.5g} N/s",
        "loading.reference_load": f"{750 / 3.4:.5g} N",
        "sweep.loads": ["50 N", "200 N"],
    }
    return entries | _relief(number), line_load / 3.4, velocity


def long_pin(number):
    """Entries of a pin of 3.4 mm of a number, its load [N] and velocity [m/s]."""
    load, velocity = ((400.0, 2.25), (200.0, 3.5), (750.0, 1.25))[number % 3]
    return {"disk.roughness.seed": number} | _relief(number + 1), load, velocity


def local_pin(number):
    """Like `short_pin`, worn locally."""
    entries, load, velocity = short_pin(number)
    return entries | {"wear.pattern": "local"}, load, velocity


def unworn_pin(number):
    """Like `short_pin`, without wear."""
    entries, load, velocity = short_pin(number)
    entries.pop("wear.specific_wear_rate")
    return entries | {"without": ["wear"]}, load, velocity


def _relief(number):
    relieved = {"pin.relief.depth": "2 um", "pin.relief.length": "0.3 mm"}
    return relieved if number // 2 % 2 else {}


KINDS = {
    "1 mm": (short_pin, PRESETS["reference"]),
    "1 mm, local wear": (local_pin, PRESETS["reference"]),
    "1 mm, no wear": (unworn_pin, PRESETS["reference"]),
    "3.4 mm": (long_pin, replace(PRESETS["fine"], contact_tolerance=0.01)),
}
"""Entries of a pin of a number, and the fidelity that it is compared with, by length."""


def rise(scene, fidelity, load, velocity):
    """Rise Θ₁₀ [K] of a scene with a fidelity, and its last state."""
    *_, state = simulate(replace(scene, fidelity=fidelity), load, velocity)
    return decisive(state.heat), state


def stated(sweep, state, velocity):
    """Errors of the rise that one realization states with each preset."""
    scene = sweep.scene
    sampling = heat(fit_elements(scene, state.normal_load), state, velocity, True).sampling
    freedom, deviation = (
        sampling["rise_realization_freedom"],
        sampling["rise_realization_std"][QUANTILES.index(0.9)],
    )
    positions = position_limit(sweep)
    if freedom:
        positions = min(POSITION_SHARE * stdtrit(freedom, 0.975) * deviation, positions)
    return [float(np.hypot(RISE_EXPONENT * PRESET_BOUNDS[name], positions)) for name in JUDGED]


def computed(task):
    """Row of the file of a pin: errors of rises by the presets, stated errors, and warnings."""
    kind, number = task
    began, (entries_of, truth) = time.process_time(), KINDS[kind]
    entries, load, velocity = entries_of(number)
    row = {"name": f"{kind}, {number}", "load": load, "velocity": velocity, "commit": commit()}
    try:
        sweep = pipeline.load_scene("whole_pin", "standard", entries)
        scene = sweep.scene
        results = [rise(scene, PRESETS[name], load, velocity) for name in JUDGED]
        rises, states = zip(*results, strict=True)
        faster, _ = rise(scene, PRESETS["standard"], load, velocity * np.exp(_STEP))
        exponent = float(np.log(faster / rises[0]) / _STEP)
        true, _ = rise(scene, truth, load, velocity)
        row["errors"] = np.log(np.array(rises) / true).tolist()
        row["stated"] = stated(sweep, states[0], velocity)
        row |= {"exponent": exponent, "warnings": _labels(scene, states)}
    except TriboError as error:
        row["failed"] = str(error)
    return row | {"seconds": time.process_time() - began}


def _labels(scene, states):
    fidelities = (PRESETS[name] for name in JUDGED)
    kinds = [
        warning.kind.label
        for fidelity, state in zip(fidelities, states, strict=True)
        for warning in warnings(replace(scene, fidelity=fidelity), state)
    ]
    return sorted({*kinds})


def main():
    parser = argparse.ArgumentParser(prog="python -m tests.promises.pins", description=__doc__)
    parser.add_argument("--short", type=int, default=16, help="pins of 1 mm")
    parser.add_argument("--local", type=int, default=6, help="short pins that wear locally")
    parser.add_argument("--unworn", type=int, default=6, help="short pins without wear")
    parser.add_argument("--long", type=int, default=3, help="pins of 3.4 mm")
    parser.add_argument("--minutes", type=float, default=120.0, help="begin no pin later")
    options = parser.parse_args()
    counts = [options.short, options.local, options.unworn, options.long]
    counts = dict(zip(KINDS, counts, strict=True))
    tasks = [(kind, number) for kind, count in counts.items() for number in range(count)]
    done = {row["name"] for row in read(FILE)}
    missing = [task for task in tasks if f"{task[0]}, {task[1]}" not in done]
    compute(computed, missing, FILE, options.minutes)
    names = {f"{kind}, {number}" for kind, number in tasks}
    rows = [row for row in read(FILE) if row["name"] in names and "failed" not in row]
    lines = [
        (
            row["name"], f"{row['load']:.0f}", f"{row['velocity']:.2f}",
            *(f"{100 * error:+.2f}" for error in row["errors"]),
            *(f"{100 * error:.2f}" for error in row["stated"]),
            f"{row['exponent']:.2f}", ", ".join(row["warnings"]),
        )
        for row in rows
    ]  # fmt: skip
    errors, bounds = (np.array([row[key] for row in rows]) for key in ("errors", "stated"))
    is_held = np.abs(errors) <= bounds
    statement = ", ".join(
        f"`{name}` {is_held[:, k].sum()} of {len(rows)}, at most {np.abs(errors[:, k]).max():.2%}, "
        f"root mean square {np.sqrt(np.square(errors[:, k]).mean()):.2%}"
        for k, name in enumerate(JUDGED)
    )
    text = f"{table(HEADS, lines)}\n\nrises within their stated errors: {statement}"
    return conclude("pins", text, bool(is_held.mean() >= MIN_HELD))


if __name__ == "__main__":
    sys.exit(main())
