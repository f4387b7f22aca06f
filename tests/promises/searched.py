"""Judge the stated error by points left out: searches of a first patch beside its whole plane.

Scenes of all families whose loads are free have ten loads. At each load the critical velocity of a
search differs from that of the whole plane by less than the search states for points left out: at
loads that it searched and at those that it left out. Constants are found on scenes of half 0.
Points are kept in files, so that a constant is tried anew in a minute.

    python -m tests.promises.searched
"""

import argparse
import math
import sys
import time
from dataclasses import replace
from pathlib import Path

import numpy as np
import pandas as pd

from pipeline.analysis.rise_error import INTERPOLATION
from pipeline.run.search import Goal, Search
from tests.helpers.campaigns import compute, conclude, read, table
from tests.promises.families import case_of, cases
from tests.promises.goals import Planes, scene
from tribo import TriboError

NUMBERS = range(2, 8)
LOADS = np.linspace(0.25, 1.0, 10)  # over the highest
WITHOUT = "stages", "record"  # whose loads are those of the test
ACCURACIES = 0.05, 0.02, 0.01
HELD = 0.95
_NEVER = Goal(1.0, 0.0, 1, counts_surface=False)


def drawn(count):
    """`count` scenes, drawn from the families; small windows first."""
    scenes = [case for case in cases(NUMBERS) if case.family not in WITHOUT]
    order = np.random.default_rng(1).permutation(len(scenes))[:count]
    found = [scenes[place] for place in order]
    return sorted(found, key=lambda case: math.prod(case.entries["window.pixels"]))


def planes_of(case, folder=Path("results/searched")):
    """Points of a scene with ten loads."""
    highest, unit = case.loads[-1].split()
    loads = [f"{float(highest) * share:.5g} {unit}" for share in LOADS]
    wide = replace(case, entries=case.entries | {"sweep.loads": loads})
    return Planes(scene(wide, falls=case.number % 4 == 3), folder / f"{case.digest}.json")


def computed(task):
    """Row of a scene, whose points are then in its file."""
    np.seterr(all="raise", under="ignore")
    case = case_of(*task)
    began, row = time.process_time(), {"name": case.name}
    try:
        planes = planes_of(case)
        planes.whole(planes.conditions)
        planes.keep()
    except TriboError as error:
        row["failed"] = str(error)
    return row | {"seconds": round(time.process_time() - began)}


def found(case):
    """True and stated errors at each load of a scene, by accuracy."""
    planes, rows = planes_of(case), []
    whole = planes.whole(planes.conditions)
    for accuracy in ACCURACIES:
        goal = _NEVER._replace(accuracy=accuracy)
        search = Search(planes.loads, planes.velocities, planes.conditions, goal)
        while batch := search.ask():
            planes.tell(search, batch)
        errors = pd.DataFrame(
            {
                "accuracy": accuracy,
                "scene": case.name,
                "half": case.number % 2,
                "is_searched": search.asked[0].any(axis=1),
                "error": search.critical / whole.critical - 1,
                "stated": search.errors[INTERPOLATION],
            }
        )
        rows.append(errors[np.isfinite(whole.critical)])
    return pd.concat(rows)


def summary(errors):
    """Table rows by accuracy, kind of load and half, and the least share held."""
    rows, least = [], 1.0
    for key, group in errors.groupby(["is_searched", "accuracy", "half"]):
        known = group.dropna()
        ratio = (known["error"] / known["stated"]).abs()
        held = np.mean(ratio <= 1)
        least = min(least, held)
        kind = "searched" if key[0] else "left out"
        sizes = known["error"].abs().quantile(HELD), known["stated"].median()
        cells = kind, f"{key[1]:.0%}", key[2], known["scene"].nunique(), len(known)
        told = f"{ratio.quantile(HELD):.2f}", f"{held:.1%}", len(group) - len(known)
        rows.append((*cells, *(f"{size:.2%}" for size in sizes), *told))
    return rows, least


HEADS = (
    "loads", "accuracy", "half", "scenes", "number", "95 % within", "stated", "over stated",
    "held", "not known",
)  # fmt: skip


def main():
    parser = argparse.ArgumentParser(prog="python -m tests.promises.searched", description=__doc__)
    parser.add_argument("--scenes", type=int, default=40, help="so many, drawn from all families")
    parser.add_argument("--minutes", type=float, default=30.0, help="begin no scene later")
    options = parser.parse_args()
    path, scenes = Path("results/searched.jsonl"), drawn(options.scenes)
    done = {row["name"] for row in read(path)}
    tasks = [(case.family, case.number) for case in scenes if case.name not in done]
    compute(computed, tasks, path, options.minutes)
    done = {row["name"] for row in read(path) if "failed" not in row}
    errors = pd.concat([found(case) for case in scenes if case.name in done])
    rows, least = summary(errors)
    return conclude("searched", table(HEADS, rows), least >= HELD)


if __name__ == "__main__":
    sys.exit(main())
