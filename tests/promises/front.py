"""Judge the presets on scenes of twelve families, on which none was chosen.

The error at a place is that of the critical velocity, ln(rise/true rise) over the exponent with
which the rise grows with the velocity, against `reference` as `truth` has it. A preset promises a
bound of 99 % of its errors at places without a warning. Scenes of an odd number judge the presets;
all take over an hour.

A pin that wears under strips of the disk errs at random, too, since each stage of its wear has
other strips. The bound of such scenes contains the stated error by these positions, which
`positions` judges. `moving_disk` judges their mean errors, which realizations share.

    python -m tests.promises.front
    python -m tests.promises.front --scenes 8
"""

import argparse
import json
import math
import sys
import tempfile
import time
from dataclasses import asdict, replace
from pathlib import Path

import numpy as np

from pipeline.answers.error import preset_error_of, preset_of
from pipeline.constants import POSITION_LIMIT, PRESET_BOUNDS, RISE_EXPONENT
from tests.helpers.campaigns import commit, compute, conclude, read, table
from tests.promises.families import case_of, cases
from tests.promises.truth import deciding_rise, known, verdicts
from tribo import PRESETS, TriboError
from tribo.constants import SLOWEST
from tribo.simulation import forget_kernels

PROMISED = "standard", "fine"
NUMBERS = 16
_QUANTILE, _WARNED = 0.99, 0.06
_COLUMNS = "choice", "promise", "places", "warned", "median", "99 %", "largest", "CPU [s]"


def bound_of(preset, under_strips):
    """Bound of the critical velocities of a preset, with its part by positions of the strips."""
    positions = POSITION_LIMIT / RISE_EXPONENT if under_strips else 0.0
    return math.hypot(PRESET_BOUNDS[preset], positions)


def dividing(scene, fidelity):
    """Fidelity with the largest elements that divide the pixels of the scene evenly."""
    shape, max_block = scene.pixels.shape, fidelity.pixels_per_element
    block = next(n for n in range(max_block, 0, -1) if not any(size % n for size in shape))
    return replace(fidelity, pixels_per_element=block)


def errors(case, fidelity):
    """Velocity errors, warnings and CPU time of a fidelity on a scene; None without true rises.

    ``over`` is the preset's largest bound over its bound for the scene's area fraction, and
    ``under_strips`` says if the pin wears under strips of the disk.
    """
    true = known(case)
    with tempfile.TemporaryDirectory() as folder:
        sweep = case.sweep(Path(folder))
    velocities = sweep.velocities
    if any(f"{velocity:g}" not in true for velocity in velocities):
        return None
    true = np.array([true[f"{velocity:g}"] for velocity in velocities])
    sweep = sweep.with_fidelity(dividing(sweep.scene, fidelity), None)
    forget_kernels()
    began = time.process_time()
    points = [verdicts(sweep, velocity) for velocity in velocities]
    seconds = time.process_time() - began
    rises = np.array([[deciding_rise(point, sweep.conditions) for point in row] for row in points])
    exponents = np.gradient(np.log(true), np.log(velocities), axis=0)
    velocity_errors = np.expm1(-np.log(rises / true) / np.maximum(exponents, SLOWEST))
    is_warned = np.array([[bool(point.warnings) for point in row] for row in points])
    is_warned |= exponents < SLOWEST
    promised = preset_error_of(sweep)
    over = PRESET_BOUNDS[preset_of(sweep.scene)] / promised if promised else 1.0
    return {
        "errors": velocity_errors.tolist(),
        "warned": is_warned.tolist(),
        "over": over,
        "under_strips": sweep.scene.wears_by_strips,
        "seconds": seconds,
    }


def computed(task):
    """Row of the file of a choice on a scene."""
    name, fidelity, *scene = task
    np.seterr(all="raise", under="ignore")
    case = case_of(*scene)
    row = {"name": f"{case.name}, {name}", "choice": json.dumps(asdict(fidelity)), "seconds": 0.0}
    row |= {"digest": case.digest, "commit": commit()}
    try:
        return row | (errors(case, fidelity) or {"failed": "no true rises"})
    except TriboError as error:
        return row | {"failed": str(error)}


def known_rows(path):
    """Rows of the file by choice and scene."""
    return {(row["choice"], row["digest"]): row for row in read(path) if "failed" not in row}


def summary(name, bound, records):
    """Table row of a preset on scenes: bound, number of points, share warned, errors, CPU time."""
    errors = np.abs(np.concatenate([row["over"] * np.ravel(row["errors"]) for row in records]))
    is_warned = np.concatenate([np.ravel(row["warned"]) for row in records])
    unwarned = errors[~is_warned]
    quantiles = *np.quantile(unwarned, [0.5, _QUANTILE]), unwarned.max()
    seconds = sum(row["seconds"] for row in records)
    return name, bound, len(errors), is_warned.mean(), *quantiles, seconds


def worded(row):
    name, bound, count, share, *sizes, seconds = row
    quantiles = (f"{size:.2%}" for size in sizes)
    return name, f"{bound:.2g}", count, f"{share:.1%}", *quantiles, f"{seconds:.1f}"


def drawn(numbers, count):
    """`count` scenes with true rises, in random order, without repeats; all if None."""
    scenes = [*{case.digest: case for case in cases(numbers) if known(case)}.values()]
    return [scenes[number] for number in np.random.default_rng(0).permutation(len(scenes))[:count]]


def are_kept(rows):
    """True if each preset keeps its error bounds, and few points carry a warning."""
    return all(row[5] <= row[1] and row[3] <= _WARNED for row in rows)


def judged(path, scenes, minutes):
    """Table rows of the presets over scenes computed with all of them, and the number of these."""
    texts = {name: json.dumps(asdict(PRESETS[name])) for name in PROMISED}
    rows = known_rows(path)
    tasks = [
        (name, PRESETS[name], case.family, case.number)
        for case in scenes
        for name, text in texts.items()
        if (text, case.digest) not in rows
    ]
    compute(computed, tasks, path, minutes)
    rows = known_rows(path)
    digests = [case.digest for case in scenes]
    done = [digest for digest in digests if all((text, digest) in rows for text in texts.values())]
    summaries = []
    for name, text in texts.items():
        records = [rows[text, digest] for digest in done]
        at_rest = [record for record in records if record["under_strips"]]
        others = [record for record in records if not record["under_strips"]]
        if others:
            summaries.append(summary(name, PRESET_BOUNDS[name], others))
        if at_rest:
            summaries.append(summary(f"{name}, under strips", bound_of(name, True), at_rest))
    return summaries, len(done)


def main():
    parser = argparse.ArgumentParser(prog="python -m tests.promises.front", description=__doc__)
    parser.add_argument("--scenes", type=int, help="so many, drawn; all if not given")
    parser.add_argument("--minutes", type=float, default=120.0, help="begin no scene later")
    options = parser.parse_args()
    scenes = drawn(range(1, NUMBERS, 2), options.scenes)
    rows, count = judged(Path("results/front.jsonl"), scenes, options.minutes)
    lines = table(_COLUMNS, map(worded, rows)), "", f"{count} scenes"
    return conclude("front", "\n".join(lines), are_kept(rows))


if __name__ == "__main__":
    sys.exit(main())
