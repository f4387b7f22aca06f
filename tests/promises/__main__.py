"""Judge promises on random scenes, one after the other, until the time is up.

What was found is kept in a file, a line for each scene, and the next run goes on from there.
"""

import argparse
import json
import math
import time
from dataclasses import replace
from pathlib import Path

import numpy as np

from pipeline.sweep.criterion import decisive_rise, rise_limit
from pipeline.tradeoff.choose import choose_fidelity
from tests.promises.scenes import random_sweep
from tribo import PRESETS, TriboError, simulate, warnings

ACCURACIES = (0.05, 0.02, 0.01)
PROMISED = {"draft": 0.08, "standard": 0.03, "fine": 0.01}
# The reference, twice as fine in everything.
TRUTH = replace(
    PRESETS["reference"], increments=400, contact_tolerance=5e-6, heat_tolerance=5e-9
)
_CLOSE = 5e-4  # relative, of a boundary velocity


def boundary_velocity(sweep, fidelity, load, velocity):
    """Where the decisive rise reaches its limit, by secants from a velocity; and its warnings."""
    scene = replace(sweep, fidelity=fidelity)
    limit, exponent, before = rise_limit(sweep.conditions), 0.6, None
    for _ in range(12):
        *_, state = simulate(scene, load, velocity)
        short = math.log(decisive_rise(state.heat.rise_quantile, sweep.conditions) / limit)
        if before is not None and abs(math.log(velocity / before[0])) > 1e-6:
            slope = (short - before[1]) / math.log(velocity / before[0])
            exponent = min(max(slope, 0.2), 2.0)
        before = velocity, short
        if abs(short / exponent) < _CLOSE:
            break
        velocity *= math.exp(-short / exponent)
    kinds = {warning.kind.label for warning in warnings(scene, state)}
    return velocity, sorted(kinds)


def judged(seed):
    """True errors of the presets and of what is picked for each accuracy, on one scene."""
    sweep, began = random_sweep(seed), time.perf_counter()
    middle = math.sqrt(sweep.velocities[0] * sweep.velocities[-1])
    true, starts = {}, {}
    for load in sweep.loads:
        starts[load], _ = boundary_velocity(sweep, PRESETS["standard"], load, middle)
        true[load], _ = boundary_velocity(sweep, TRUTH, load, starts[load])
    row = {
        "seed": seed,
        "wear": sweep.wear and [sweep.wear.pattern, sweep.wear.specific_wear_rate],
        "velocities": [float(velocity) for velocity in true.values()],
        "columns": len(sweep.velocities),
        "presets": {},
        "promises": {},
    }

    def errors(fidelity):
        found = [boundary_velocity(sweep, fidelity, load, true[load]) for load in true]
        off = [abs(math.log(one / of)) for (one, _), of in zip(found, true.values(), strict=True)]
        return max(off), sorted({kind for _, kinds in found for kind in kinds})

    for name in PROMISED:
        error, kinds = errors(PRESETS[name])
        row["presets"][name] = {"error": error, "warnings": kinds}
    row["seconds"] = time.perf_counter() - began
    known = {}
    for accuracy in ACCURACIES:
        began = time.perf_counter()
        selection = choose_fidelity(sweep, accuracy)
        took = time.perf_counter() - began
        if selection.fidelity not in known:
            known[selection.fidelity] = errors(selection.fidelity)[0]
        row["promises"][f"{accuracy:g}"] = {
            "name": selection.name,
            "error": known[selection.fidelity],
            "foretold": selection.error,
            "saving": selection.saving,
            "seconds": took,
        }
    return row


def report(rows):
    """How many promises were kept."""
    good = [row for row in rows if "failed" not in row]
    print(f"{len(good)} scenes judged, {len(rows) - len(good)} came to no result")
    for name, bound in PROMISED.items():
        found = [row["presets"][name] for row in good]
        errors = np.array([each["error"] for each in found])
        silent = sum(each["error"] > bound and not each["warnings"] for each in found)
        print(
            f"{name:10} {np.mean(errors <= bound):6.1%} within {bound:.0%}; median "
            f"{np.median(errors):.2%}, 90 % below {np.quantile(errors, 0.9):.2%}, largest "
            f"{errors.max():.1%}; {silent} beyond it without a warning"
        )
    for accuracy in ACCURACIES:
        found = [row["promises"][f"{accuracy:g}"] for row in good]
        errors = np.array([each["error"] for each in found])
        foretold = np.array([each["foretold"] for each in found])
        print(
            f"{accuracy:.0%}: kept {np.sum(errors <= accuracy)} of {len(found)}, foretold error "
            f"exceeds the true one in {np.mean(foretold >= errors):.1%}; largest error "
            f"{errors.max():.2%}; missed: "
            + (
                ", ".join(
                    f"scene {row['seed']} {error:.2%} ({each['name']})"
                    for row, each, error in zip(good, found, errors, strict=True)
                    if error > accuracy
                )
                or "none"
            )
        )


def main():
    """Go on with the campaign, then report."""
    parser = argparse.ArgumentParser(prog="python -m tests.promises", description=__doc__)
    parser.add_argument("--scenes", type=int, default=300)
    parser.add_argument("--minutes", type=float, default=60.0, help="begin no scene later")
    parser.add_argument("--file", type=Path, default=Path("results/promises.jsonl"))
    options = parser.parse_args()
    options.file.parent.mkdir(parents=True, exist_ok=True)
    rows = []
    if options.file.exists():
        rows = [json.loads(line) for line in options.file.read_text().splitlines()]
    done, began = {row["seed"] for row in rows}, time.monotonic()
    for seed in range(options.scenes):
        if seed in done:
            continue
        if time.monotonic() - began > 60 * options.minutes:
            break
        try:
            row = judged(seed)
        except TriboError as error:
            row = {"seed": seed, "failed": f"{type(error).__name__}: {error}"}
        rows.append(row)
        with options.file.open("a") as file:
            file.write(json.dumps(row) + "\n")
    report(rows)


if __name__ == "__main__":
    main()
