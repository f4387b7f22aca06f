"""Judge promises on random scenes, one after the other, until the time is up.

Truth is the reference, twice as fine in everything; for `--accuracy` with the heat of all the past.

What was found is kept in a file, a line for each scene, and the next run goes on from there.
"""

import argparse
import json
import math
import time
from pathlib import Path

import numpy as np

from pipeline.tradeoff.choose import choose_fidelity
from tests.promises.judge import largest_error, true_boundary
from tests.promises.scenes import random_sweep
from tribo import PRESETS, TriboError

ACCURACIES = (0.05, 0.02, 0.01)
PROMISED = {"draft": 0.08, "standard": 0.03, "fine": 0.01}


def judged(seed):
    """True errors of the presets and of what is picked for each accuracy, on one scene."""
    sweep, began = random_sweep(seed), time.perf_counter()
    true, with_past = true_boundary(sweep)
    row = {
        "seed": seed,
        "wear": sweep.wear and [sweep.wear.pattern, sweep.wear.specific_wear_rate],
        "velocities": [float(velocity) for velocity in true.values()],
        "columns": len(sweep.velocities),
        "heat_model": max(abs(math.log(with_past[load] / true[load])) for load in true),
        "presets": {},
        "promises": {},
    }

    for name in PROMISED:
        error, kinds = largest_error(sweep, PRESETS[name], true)
        row["presets"][name] = {"error": error, "warnings": kinds}
    row["seconds"] = time.perf_counter() - began
    known = {}
    for accuracy in ACCURACIES:
        began = time.perf_counter()
        selection = choose_fidelity(sweep, accuracy)
        took = time.perf_counter() - began
        if selection.fidelity not in known:
            error, _ = largest_error(sweep, selection.fidelity, with_past)
            known[selection.fidelity] = error
        row["promises"][f"{accuracy:g}"] = {
            "name": selection.name,
            "heat_model": selection.fidelity.heat_model,
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
