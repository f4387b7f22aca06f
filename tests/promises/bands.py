"""Share of direct simulations that the emulator's 90 % bands hold, by its number of contacts.

    python -m tests.promises.bands
    python -m tests.promises.bands --scene scene.toml --samples 32 64 --direct 160

Half of the simulations are at loads of the samples, half at any load between; all are at any
velocity, with inputs that no sample has. Prints a JSON document; the exit code is 1 if samples
that are said to suffice hold fewer than 90 %, by more than chance.
"""

import argparse
import json
import math
import os
import sys
import tempfile
from dataclasses import replace
from pathlib import Path

import numpy as np

import pipeline
from tests.helpers.campaigns import conclude
from tests.helpers.entries import changed
from tests.promises.risk import SEED, WORKFLOWS, drawn_anew, excess


def places(ensemble, count):
    """Loads and velocities of so many simulations."""
    chance = np.random.default_rng(SEED)
    loads, velocities = ensemble.loads, ensemble.velocities
    anywhere = np.exp(chance.uniform(*np.log(loads[[0, -1]]), count))
    anywhere[::2] = chance.choice(loads, len(anywhere[::2]))
    return anywhere, np.exp(chance.uniform(*np.log(velocities), count))


def of_first(ensemble, count):
    """The emulator of the first samples alone."""
    names = ("inputs", "sample_velocities", "contacts", "rises")
    return replace(
        ensemble, **{name: getattr(ensemble, name)[:count] for name in names}, keeper=None
    )


def held(ensemble, values, at, excesses):
    """Contacts of an emulator, and the shares of left-out and direct runs that its bands hold."""
    found = [
        ensemble.excess(row[None], load, velocity)
        for row, load, velocity in zip(values, *at, strict=True)
    ]
    missed = np.array([one.values[0] for one in found]) - excesses
    errors = np.array([one.error[0] for one in found])
    left_out = ensemble.left_out
    return {
        "samples": len(ensemble.inputs),
        "contacts": left_out.contacts,
        "left_out": left_out.held,
        "suffices": left_out.is_right,
        "direct": float(np.mean(np.abs(missed) < 1.645 * errors)),
        "rise_error": float(np.median(errors)),
    }


def main():
    parser = argparse.ArgumentParser(prog="python -m tests.promises.bands", description=__doc__)
    parser.add_argument("--scene", type=Path, default=WORKFLOWS / "uncertain.toml")
    parser.add_argument("--preset", default="draft")
    parser.add_argument("--samples", nargs="+", type=int, default=[16, 32, 64, 128])
    parser.add_argument("--direct", type=int, default=160)
    options = parser.parse_args()
    np.seterr(all="raise", under="ignore")
    overrides = {"fidelity.preset": options.preset, "sweep.samples": max(options.samples)}
    sweep = changed(pipeline.load_scene(options.scene, overrides=overrides), fields=False)
    with tempfile.TemporaryDirectory() as folder:
        store = Path(folder) / "samples.zarr"
        pipeline.run_sweep(sweep, store, workers=os.cpu_count())
        ensemble = pipeline.Ensemble.of(pipeline.open_sweep(store))
    values, entries = drawn_anew(ensemble, options.direct)
    at = places(ensemble, options.direct)
    without = {
        "fidelity.preset": options.preset,
        "without": ["unknown", "sweep.samples"],
    }
    excesses = np.array(
        [
            excess(options.scene, without, inputs, float(load), float(velocity))
            for inputs, load, velocity in zip(entries, *at, strict=True)
        ]
    )
    report = [held(of_first(ensemble, count), values, at, excesses) for count in options.samples]
    # A share of so many runs, within three of its standard errors.
    allowed = 3 * math.sqrt(0.9 * 0.1 / options.direct)
    sufficient = [row for row in report if row["suffices"]]
    is_right = bool(sufficient) and all(row["direct"] >= 0.9 - allowed for row in sufficient)
    return conclude("bands", json.dumps(report, indent=1), is_right)


if __name__ == "__main__":
    sys.exit(main())
