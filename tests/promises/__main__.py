"""Judge `--accuracy` on random scenes, one after the other, until the time is up.

Truth is nearly exact steps on the pixels.

What was found is kept in a file, a line for each part of each scene, with the commit that it
belongs to, and the next run goes on from there. The true boundaries hold as long as the physics
does; what is judged against them can be judged anew. The exit code is 1 where too few promises are
kept, or too many broken in silence.
"""

import argparse
import functools
import json
import sys
import time
from pathlib import Path

import pipeline
from tests.helpers.campaigns import commit
from tests.promises.judge import boundaries, exponents, largest_error, places, true_boundary
from tests.promises.report import ACCURACIES, report
from tests.promises.scenes import random_sweep
from tests.promises.wide import random_wide_sweep
from tribo import TriboError

PARTS = ("truth", "accuracies")
FAMILIES = {"cylinders": random_sweep, "wide": random_wide_sweep}


def truth(sweep, parts):
    """True boundary velocity at each place of a sweep."""
    return {"velocities": [*true_boundary(sweep).values()]}


def _slow(slopes):
    """["slow rise"] if the rise grows slowly with velocity, so that errors count more; else []."""
    return ["slow rise"] if min(slopes.values()) < 0.4 else []


def accuracies(sweep, parts):
    """For each accuracy: the choice of `--accuracy`, its stated and true error, and its time.

    The table of choices is measured once, and each accuracy takes its row.
    """
    true = dict(zip(places(sweep), parts["truth"]["velocities"], strict=True))
    slopes = exponents(sweep, true)

    @functools.cache
    def judged(fidelity):
        velocities, kinds = boundaries(sweep, fidelity, true, slopes)
        return largest_error(velocities, true), kinds + _slow(slopes)

    rows, measured = {}, pipeline.trade(sweep)
    for accuracy in ACCURACIES:
        choice = measured.cheapest(accuracy)
        error, kinds = judged(choice.fidelity)
        within = [one for one in measured.choices if one.error_at_any_load <= accuracy]
        rows[f"{accuracy:g}"] = {
            "name": choice.name,
            "error": error,
            "warnings": kinds,
            "stated": choice.error_at_any_load,
            "dearer": choice.seconds / min(one.seconds for one in [*within, choice]),
        }
    return rows


def read(path):
    """Results of each scene by seed and part; later lines of the file replace earlier ones."""
    rows_by_seed = {}
    for line in path.read_text().splitlines() if path.exists() else ():
        row = json.loads(line)
        rows_by_seed.setdefault(row["seed"], {})[row["part"]] = row
    return rows_by_seed


def main():
    """Continue the campaign, then report."""
    parser = argparse.ArgumentParser(prog="python -m tests.promises", description=__doc__)
    parser.add_argument("--family", choices=FAMILIES, default="cylinders")
    parser.add_argument("--first", type=int, default=0, help="seed to begin with")
    parser.add_argument("--scenes", type=int, default=300, help="seeds below this one")
    parser.add_argument("--minutes", type=float, default=60.0, help="begin no scene later")
    parser.add_argument("--file", type=Path, help="results/promises_FAMILY.jsonl")
    parser.add_argument("--anew", action="store_true", help="what another commit has judged")
    options = parser.parse_args()
    path = options.file or Path(f"results/promises_{options.family}.jsonl")
    path.parent.mkdir(parents=True, exist_ok=True)
    rows_by_seed, began, now = read(path), time.monotonic(), commit()
    for seed in range(options.first, options.scenes):
        rows = rows_by_seed.setdefault(seed, {})
        for part in PARTS:
            stale = options.anew and part != "truth" and rows.get(part, {}).get("commit") != now
            if part in rows and not stale:
                continue
            if time.monotonic() - began > 60 * options.minutes or "failed" in rows.get("truth", {}):
                break
            row = {"seed": seed, "part": part, "commit": now}
            started = time.process_time()
            try:
                row |= globals()[part](FAMILIES[options.family](seed), rows)
            except TriboError as error:
                row["failed"] = f"{type(error).__name__}: {error}"
            row["seconds"] = time.process_time() - started
            rows[part] = row
            with path.open("a") as file:
                file.write(json.dumps(row) + "\n")
    return report(rows_by_seed, options.family)


if __name__ == "__main__":
    sys.exit(main())
