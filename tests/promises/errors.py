"""Judge the stated errors of rises by `fine` at points of a plane and at places between them.

Each scene is computed by `standard` on a plane of 4 or 5 loads and 5 to 7 velocities, and by `fine`
there and between; `fine` itself is judged by `reference`, where that is cheap. What was computed is
kept in a file, a line for each scene, and the next run goes on from there.
"""

import argparse
import json
import math
import multiprocessing
import os
import sys
import time
from concurrent.futures import FIRST_COMPLETED, ProcessPoolExecutor, wait
from dataclasses import replace
from itertools import islice
from pathlib import Path

import numpy as np
import pandas as pd
from scipy.interpolate import PchipInterpolator

import pipeline
from pipeline.analysis.rise_error import RiseError, rise_errors
from pipeline.analysis.rises import Rises
from pipeline.analysis.warned_points import exponents
from pipeline.constants import BETWEEN, PRESET_BOUNDS
from pipeline.sweep.conditions import Conditions
from pipeline.sweep.model import Point
from pipeline.sweep.plan import choose_stations, run_point
from pipeline.sweep.severity import worst_rises
from pipeline.sweep.variants import Variants
from tests.helpers.campaigns import conclude, table
from tests.helpers.entries import changed
from tests.promises.scenes import random_sweep
from tests.promises.wide import random_wide_sweep
from tribo import PRESETS, Criterion, TriboError, WarningKind
from tribo.constants import SLOWEST
from tribo.simulation import Trunks

WORKFLOWS = Path(__file__).parents[2] / "workflows"
SHIPPED = ("first_try", "oil_a", "ball_on_disk", "twin_disc")
SHARES = (0.0, 0.1, 0.5)  # failing shares by which wear is judged


def shipped(seed):
    """A shipped scene; for seeds from 4 on, a similar random scene in a narrower window."""
    name, rng = SHIPPED[seed % 4], np.random.default_rng([seed, 61])
    path = WORKFLOWS / f"{name}.toml"
    if seed < 4:
        return pipeline.load_scene(path)

    def around(value, most):
        return float(f"{value * math.exp(rng.uniform(-1, 1) * math.log(most)):.3g}")

    scene = pipeline.load_scene(path).scene
    roughness, radius = scene.roughness, around(1e3 * scene.pin.radius, 1.5)
    own = {
        "ball_on_disk": {"window.pixels": [300, 300], "window.pixel_size": ["2 um", "2 um"]},
        "twin_disc": {
            "window.pixels": [1440, 96],
            "pin.diameter": f"{4 * radius} mm",
            "pin.width": "10 mm",
        },
        "oil_a": {"window.pixels": [720, 160]},
        "first_try": {"window.pixels": [576, 160]},
    }
    rate = around(1e15 * scene.wear.specific_wear_rate, 4.0)
    return pipeline.load_scene(
        path,
        overrides={
            "pin.radius": f"{radius} mm",
            "disk.roughness.seed": seed,
            "disk.roughness.ra": f"{around(1e6 * roughness.ra, 2.5)} um",
            "disk.roughness.hurst_exponent": around(0.75, 1.2),
            "disk.roughness.correlation_length": f"{around(5, 1.25)} um",
            "wear.specific_wear_rate": f"{rate}e-6 mm^3/(N m)",
            "wear.pattern": "local" if rng.uniform() < 1 / 3 else "swept",
        }
        | own[name],
    )


PROMISED = {name: PRESET_BOUNDS[name] for name in ("standard", "fine")}

FAMILIES = {"shipped": shipped, "cylinders": random_sweep, "wide": random_wide_sweep}
EVERY = {"shipped": 1, "cylinders": 2, "wide": 3}  # one scene in so many, by their cost
FIRST = 1000  # first seed of random scenes, other than those that the presets were chosen by


def axis(rng, low, high, count, gaps, spaced=np.geomspace):
    """Points of an axis, and all places: the points and one random place in each of some gaps."""
    points = [float(f"{x:.5g}") for x in spaced(low, high, count)]
    places = []
    for gap in rng.choice(count - 1, gaps, replace=False):
        share = rng.uniform(0.25, 0.75)
        places.append(float(f"{points[gap] ** (1 - share) * points[gap + 1] ** share:.5g}"))
    return points, sorted(points + places)


def rises(sweep, fidelity, loads, velocities):
    """Deciding rises [K] by failing share, warning flags and durations [s], (load, velocity)."""
    sweep = changed(sweep, fidelity=fidelity)
    kinds = [replace(sweep.conditions, criterion=Criterion(share=one)) for one in SHARES]
    shape, stations = (len(loads), len(velocities)), choose_stations(sweep)
    found = {str(share): np.full(shape, np.nan) for share in SHARES}
    found |= {name: np.zeros(shape) for name in ("flags", "durations")}
    for column, velocity in enumerate(velocities):
        trunks = Trunks()
        for row, load in enumerate(loads):
            point = run_point(sweep.scene, stations, Point(load, velocity), trunks)
            for share, conditions in zip(SHARES, kinds, strict=True):
                found[str(share)][row, column] = worst_rises(point.columns, load, conditions)
            found["flags"][row, column] = sum({int(one.kind) for one in point.warnings})
            found["durations"][row, column] = point.columns["time"].max()
    return {name: values.tolist() for name, values in found.items()}


def computed(family, number):
    """Rises of one scene with each preset as a row of the file, or why it failed."""
    np.seterr(all="raise", under="ignore")
    began, row = time.monotonic(), {"family": family, "number": number}
    seed = number if family == "shipped" else FIRST + number
    rng = np.random.default_rng([seed, 161])
    try:
        sweep = changed(FAMILIES[family](seed), fields=False, steps="end", variants=Variants())
        velocities = [velocity for velocity in sweep.velocities if velocity]
        low, high = min(velocities), max(velocities)
        if family != "shipped":  # shipped scenes have distant velocities
            low, high = (math.sqrt(low * high) * rng.uniform(2, 5) ** sign for sign in (-1, 1))
        ends = min(sweep.loads), max(sweep.loads)
        loads, all_loads = axis(rng, *ends, int(rng.integers(4, 6)), 1, np.linspace)
        spaced = np.linspace if rng.uniform() < 1 / 3 else np.geomspace
        velocities, all_velocities = axis(rng, low, high, int(rng.integers(5, 8)), 2, spaced)
        row |= {"loads": loads, "velocities": velocities, "pixels": sweep.scene.pixels.shape}
        row |= {"all_loads": all_loads, "all_velocities": all_velocities}
        sweep = changed(sweep, loads=tuple(all_loads), velocities=tuple(all_velocities))
        row["standard"] = rises(sweep, PRESETS["standard"], loads, velocities)
        row["fine"] = rises(sweep, PRESETS["fine"], all_loads, all_velocities)
        warm = (np.array(row["standard"]["flags"], int) & WarningKind.PRESENT_HEAT).any(axis=0)
        few = [velocity for velocity, is_warm in zip(velocities, warm, strict=True) if is_warm][::3]
        row["few"] = few
        for heat in ("history", "elapsed"):
            fidelity = replace(PRESETS["standard"], heat_model=heat)
            row[heat] = rises(sweep, fidelity, loads, few)
        if family != "shipped":
            row["reference"] = rises(sweep, PRESETS["reference"], loads[1::2], velocities[1::3])
    except TriboError as error:
        row["failed"] = str(error)
    return row | {"seconds": round(time.monotonic() - began)}


def compute(path, scenes, minutes):
    """Compute scenes of all families in turn, on all cores, for `minutes`."""
    done = {(row["family"], row["number"]) for row in read(path)}
    tasks = iter(
        (family, number // every)
        for number in range(scenes)
        for family, every in EVERY.items()
        if number % every == 0 and (family, number // every) not in done
    )
    end, running = time.monotonic() + 60 * minutes, set()
    processes = len(os.sched_getaffinity(0))
    context = multiprocessing.get_context("spawn")
    with ProcessPoolExecutor(processes, context) as pool, path.open("a") as file:
        while True:
            free = processes - len(running) if time.monotonic() < end else 0
            running |= {pool.submit(computed, *task) for task in islice(tasks, free)}
            if not running:
                return
            ready, running = wait(running, return_when=FIRST_COMPLETED)
            for row in (one.result() for one in ready):
                print(json.dumps(row), file=file, flush=True)
                said = row["family"], row["number"], f"{row['seconds']} s", row.get("failed", "")
                print(*said, file=sys.stderr, flush=True)


def read(path):
    """Rows of a file of results."""
    return [json.loads(line) for line in path.read_text().splitlines()] if path.exists() else []


def plane_of(row, preset, share):
    """`Rises` of a scene by a preset, as answers have it; of `fine` only its own points."""
    here = np.ix_(*(np.isin(row[f"all_{name}"], row[name]) for name in ("loads", "velocities")))
    names = str(share), "flags", "durations"
    parts = (np.array(row[preset][name]) for name in names)
    rises, flags, durations = (x[here] if preset == "fine" else x for x in parts)
    velocities = np.array(row["velocities"])
    slow = [exponents(velocities, line) < SLOWEST for line in rises]
    return Rises(
        loads=np.array(row["loads"]),
        velocities=velocities,
        plane=rises,
        surface=np.zeros(rises.shape),  # all presets have the same surface
        # `fine` has present heat only, too; its error is judged against all the heat so far.
        flags=flags.astype(int) & ~int(WarningKind.PRESENT_HEAT)
        | np.array(slow) * int(WarningKind.SLOW_RISE),
        durations=durations,
        is_left_out=np.zeros(rises.shape, bool),
        is_made=np.zeros(rises.shape, bool),
        conditions=Conditions(1.0, 300.0, criterion=Criterion(share=float(share))),
        promised=PROMISED[preset],
        ends={},
        source=None,
    )


def error_at(plane, load, velocity):
    """Stated relative error of the rise at one load and velocity, as a `RiseError`."""
    errors = rise_errors(plane, np.array([load]), np.array([velocity]))
    return RiseError.of(errors[:, 0])


def interpolated(x, y, place):
    """Interpolation by a monotone cubic of logarithms, as in `pipeline.analysis`."""
    return np.exp(PchipInterpolator(np.log(x), np.log(y))(math.log(place)))


def places(row, preset, share):
    """Yield errors of a preset's rises, true (against `fine`) and stated, at each place."""
    plane, true = plane_of(row, preset, share), np.array(row["fine"][str(share)])
    if min(plane.plane.min(), true.min()) <= 0:  # far below the bulk of a warmer disk
        return
    for i, load in enumerate(row["all_loads"]):
        for j, velocity in enumerate(row["all_velocities"]):
            stated = error_at(plane, load, velocity)
            is_point = load in row["loads"] and velocity in row["velocities"]
            if is_point and preset == "fine":
                continue
            beneath = np.zeros(plane.plane.shape, bool)
            (rows,), (columns,) = plane.rests_on(np.array([load]), np.array([velocity]))
            beneath[rows[:, None], columns] = True
            column = interpolated(plane.velocities, plane.plane.T, velocity)
            yield {
                "scene": f"{row['family']} {row['number']}",
                "family": row["family"],
                "half": row["number"] % 2,
                "preset": preset,
                "share": share,
                "is_point": is_point,
                "flags": np.bitwise_or.reduce(plane.flags[beneath]),
                "error": float(interpolated(plane.loads, column, load)) / true[i, j] - 1,
                "between": (stated.interpolation or 0.0) / BETWEEN,
                "stated": stated.total,
            }


def beyond(row):
    """Yield true over stated errors of extrapolation from the two points beside the boundary."""
    whole = plane_of(row, "fine", 0.1)
    if whole.plane.min() <= 0:
        return
    above = np.sum(whole.plane < np.median(whole.plane), axis=1)[:, None]
    columns = np.arange(len(whole.velocities))
    is_kept = (columns == above) | (columns == above - 1)
    plane = replace(whole, plane=np.where(is_kept, whole.plane, np.nan))
    for load, known, rises in zip(whole.loads, is_kept, whole.plane, strict=True):
        if known.sum() < 2:
            continue
        x, y = np.log(whole.velocities), np.log(rises)
        (low, first), (high, last) = zip(x[known], y[known], strict=True)
        for place, true in zip(x[~known], y[~known], strict=True):
            found = first + (last - first) / (high - low) * (place - low)
            said = error_at(plane, load, math.exp(place)).interpolation
            yield math.expm1(found - true) / said


def rms(values):
    """Root mean square."""
    return float(np.sqrt(np.mean(np.square(values))))


def most(values):
    """99 % quantile of absolute values."""
    return float(np.quantile(np.abs(values), 0.99))


COVERED = ("places", "scenes", "number", "rms error", "99 % within", "stated, rms", "over", "held")


def covered(name, places):
    """Table row that compares true with stated errors at places; unknown errors are left out."""
    known = places.dropna(subset="stated")
    error, stated = known["error"], known["stated"].astype(float)
    sizes = (f"{size:.2%}" for size in (rms(error), most(error), rms(stated)))
    over, held = rms(stated) / most(error), np.mean(error.abs() <= stated)
    return name, known["scene"].nunique(), len(known), *sizes, f"{over:.1f}", f"{held:.1%}"


def are_covered(lines, clean):
    """True if the stated errors hold at 99 % of places, and are not stated much too large.

    Without a warning they are at most 4 times the 99 % quantile of true errors.
    """
    held = [float(line[-1].rstrip("%")) for line in [*lines, *clean]]
    return min(held) >= 99 and max(float(line[-2]) for line in clean) <= 4


def constants(rows, places):
    """Yield, for each constant of `pipeline.analysis.rise_error`, its name and errors it bounds."""
    points = places[places["is_point"]]
    clean = points[points["flags"] == 0]
    for preset, group in clean.groupby("preset"):
        yield f"share, {preset}", group["error"] / PROMISED[preset]
    if apart := [fine_apart(row) / PROMISED["fine"] for row in rows if "reference" in row]:
        yield "share, fine", np.concatenate(apart)
    between = places[(places["preset"] == "fine") & (places["between"] > 0)]
    yield "BETWEEN", between["error"] / between["between"]
    yield "continuing, over stated", [error for row in rows for error in beyond(row)]
    for kind in WarningKind:
        for preset, group in points[points["flags"] & int(kind) != 0].groupby("preset"):
            yield f"{kind.label}, {preset}", group["error"]
    if heat := [excess for row in rows for excess in too_warm(row)]:
        yield "present heat", heat


def fine_apart(row):
    """Relative differences of rises by `fine` from those by `reference`, at some points."""
    names = ("loads", 2), ("velocities", 3)
    at = np.ix_(*(np.isin(row[f"all_{name}"], row[name][1::step]) for name, step in names))
    return (np.array(row["fine"]["0.1"])[at] / np.array(row["reference"]["0.1"]) - 1).ravel()


def too_warm(row):
    """Excess of the rise with present heat only over that with history, at points warned of it."""
    flags = np.array(row["standard"]["flags"], int)[:, np.isin(row["velocities"], row["few"])]
    excess = np.array(row["elapsed"]["0.1"]) / np.array(row["history"]["0.1"]) - 1
    return excess[flags & WarningKind.PRESENT_HEAT != 0]


def main():
    """Compute missing scenes, then report."""
    parser = argparse.ArgumentParser(prog="python -m tests.promises.errors", description=__doc__)
    parser.add_argument("--scenes", type=int, default=24, help="shipped ones and variations")
    parser.add_argument("--minutes", type=float, default=30.0, help="begin no scene later")
    parser.add_argument("--file", type=Path, default=Path("results/errors.jsonl"))
    options = parser.parse_args()
    options.file.parent.mkdir(parents=True, exist_ok=True)
    compute(options.file, options.scenes, options.minutes)
    rows = [row for row in read(options.file) if "failed" not in row]
    kinds = [(preset, share) for preset in PROMISED for share in SHARES]
    every = pd.DataFrame([place for row in rows for kind in kinds for place in places(row, *kind)])
    usual = every[every["share"] == 0.1]
    whole = [covered(preset, group) for preset, group in usual.groupby("preset")]
    clean = [
        covered(f"{preset}, without a warning", group)
        for preset, group in usual[usual["flags"] == 0].groupby("preset")
    ]
    lines = [
        covered(f"{column} {name}, {preset}", group)
        for column in ("half", "family")
        for (name, preset), group in usual.groupby([column, "preset"])
    ]
    lines += [
        covered(f"{share:.0%} decides, {preset}", group)
        for (share, preset), group in every.groupby(["share", "preset"])
    ]
    found = {"all": constants(rows, usual)} | {
        f"half {half}": constants([row for row in rows if row["number"] % 2 == half], group)
        for half, group in usual.groupby("half")
    }
    frame = pd.DataFrame(
        {name: {label: most(x) for label, x in kind} for name, kind in found.items()}
    )
    by_constant = [(label, *(f"{x:.3g}" for x in row)) for label, *row in frame.itertuples()]
    report = table(COVERED, whole + clean + lines), table(("99 % within", *found), by_constant)
    return conclude("errors", "\n\n".join(report), are_covered(whole, clean))


if __name__ == "__main__":
    sys.exit(main())
