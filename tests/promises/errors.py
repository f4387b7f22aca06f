"""Judge the stated errors of rises by `fine` at points of a plane and at places between them.

Each scene of the families is computed by `standard` on a plane of 4 or 5 loads and 5 to 7
velocities, and by `fine` there and between; `fine` itself is judged by `reference`, where that is
cheap. Constants are found on scenes of an even number (half 0), and judged on the others. What was
computed is kept in a file, a line for each scene, and the next run goes on from there.
"""

import argparse
import math
import sys
import tempfile
import time
from dataclasses import replace
from pathlib import Path

import numpy as np
import pandas as pd
from scipy.stats import binom

from pipeline.answers.error import INTERPOLATION, preset_bound, rise_errors, total
from pipeline.answers.specimen import merge_realizations
from pipeline.constants import PRESET_BOUNDS
from pipeline.sweep.plan import choose_stored_steps, run_point
from pipeline.sweep.sweep import Point
from tests.helpers.campaigns import compute, conclude, read, table
from tests.helpers.entries import changed
from tests.promises import duhamel
from tests.promises.families import case_of
from tests.promises.front import drawn
from tribo import PRESETS, TriboError, WarningKind
from tribo.constants import SLOWEST
from tribo.simulation import RampCache
from tribo.simulation.verdict import worst_rises

CRITERIA = {f"share {share:g}": share for share in (0.0, 0.01, 0.1, 0.5)}
"""Critical area fractions by name; 0 is the highest temperature."""
USUAL = "share 0.1"


PRESETS_JUDGED = "standard", "fine"

SHIPPED = "shipped"
"""The family whose windows are too large for `reference`."""
LEFT_OUT = "stages"
"""The family whose loads are those of its specimen alone: there are no places between them."""
NUMBERS = range(12)


def axis(rng, low, high, count, gaps, spaced=np.geomspace):
    """Points of an axis; these points together with random positions in some of the gaps."""
    points = [float(f"{x:.5g}") for x in spaced(low, high, count)]
    between = []
    for gap in rng.choice(count - 1, gaps, replace=False):
        share = rng.uniform(0.25, 0.75)
        between.append(float(f"{points[gap] ** (1 - share) * points[gap + 1] ** share:.5g}"))
    return points, sorted(points + between)


def rises(sweep, fidelity, loads, velocities):
    """Deciding rises [K] by criterion, warning flags and durations [s], (load, velocity)."""
    sweep = changed(sweep, fidelity=fidelity)
    kinds = {
        name: replace(sweep.conditions, critical_area_fraction=fraction)
        for name, fraction in CRITERIA.items()
    }
    shape, stored_steps = (len(loads), len(velocities)), choose_stored_steps(sweep)
    values = {name: np.full(shape, np.nan) for name in CRITERIA}
    values |= {name: np.zeros(shape) for name in ("flags", "durations")}
    for column, velocity in enumerate(velocities):
        ramp_cache = RampCache()
        for row, load in enumerate(loads):
            point = run_point(sweep.scene, stored_steps, Point(load, velocity), ramp_cache)
            for name, conditions in kinds.items():
                values[name][row, column] = worst_rises(point.columns, load, conditions)
            values["flags"][row, column] = sum({int(warning.kind) for warning in point.warnings})
            values["durations"][row, column] = point.columns["time"].max()
    return {name: array.tolist() for name, array in values.items()}


def heat_excess(scene, load, velocity):
    """Relative excess of the rise by present heat only over that by all heat so far."""
    present, by_all = duhamel.rises(scene, load, velocity)
    return present / by_all - 1


def computed(task):
    """Rises of one scene with each preset as a row of the file, or why it failed."""
    np.seterr(all="raise", under="ignore")
    case = case_of(*task)
    began, row = time.monotonic(), {"name": case.name, "family": case.family}
    row |= {"number": case.number, "digest": case.digest}
    rng = np.random.default_rng([case.number, 161])
    try:
        with tempfile.TemporaryDirectory() as folder:
            sweep = changed(case.sweep(Path(folder)), fields=False, steps="end")
        middle = math.sqrt(min(sweep.velocities) * max(sweep.velocities))
        low, high = (middle * rng.uniform(2, 5) ** sign for sign in (-1, 1))
        ends = min(sweep.loads), max(sweep.loads)
        loads, all_loads = axis(rng, *ends, int(rng.integers(4, 6)), 1, np.linspace)
        spaced = np.linspace if rng.uniform() < 1 / 3 else np.geomspace
        velocities, all_velocities = axis(rng, low, high, int(rng.integers(5, 8)), 2, spaced)
        row |= {"loads": loads, "velocities": velocities}
        row |= {"all_loads": all_loads, "all_velocities": all_velocities}
        sweep = changed(sweep, loads=tuple(all_loads), velocities=tuple(all_velocities))
        row["standard"] = rises(sweep, PRESETS["standard"], loads, velocities)
        row["fine"] = rises(sweep, PRESETS["fine"], all_loads, all_velocities)
        warm = (np.array(row["standard"]["flags"], int) & WarningKind.PRESENT_HEAT).any(axis=0)
        few = [velocity for velocity, is_warm in zip(velocities, warm, strict=True) if is_warm][::3]
        row["few"] = few
        scene = replace(sweep.scene, fidelity=PRESETS["standard"])
        row["excess"] = [[heat_excess(scene, load, velocity) for velocity in few] for load in loads]
        if case.family != SHIPPED:
            row["reference"] = rises(sweep, PRESETS["reference"], loads[1::2], velocities[1::3])
    except TriboError as error:
        row["failed"] = str(error)
    return row | {"seconds": round(time.monotonic() - began)}


def plane_of(row, preset, name):
    """`Specimen` of a scene by a preset, as in answers; from `fine` only points of the plane."""
    at_points = np.ix_(
        *(np.isin(row[f"all_{axis}"], row[axis]) for axis in ("loads", "velocities"))
    )
    parts = (np.array(row[preset][key]) for key in (name, "flags", "durations"))
    rises, flags, durations = (x[at_points] if preset == "fine" else x for x in parts)
    velocities = np.array(row["velocities"])
    slopes = np.gradient(np.log(rises), np.log(velocities), axis=1)
    # `fine` has present heat only, too; its error is compared with the rise by all heat so far.
    flags = flags.astype(int) & ~int(WarningKind.PRESENT_HEAT)
    flags |= (slopes < SLOWEST) * int(WarningKind.SLOW_RISE)
    same = np.zeros(rises.shape)  # all presets have the same surface
    return merge_realizations(
        np.array(row["loads"]), velocities, np.log(rises)[None], same, flags, durations
    )


def flags_around(plane, loads, velocities):
    """Warnings (k,) of the points that surround k positions."""
    after = np.searchsorted(plane.field.velocities, velocities).clip(1, None)
    ends = after - 1, np.minimum(after, len(plane.field.velocities) - 1)
    is_node = np.isin(velocities, plane.field.velocities)
    columns = [
        np.where(is_node, np.searchsorted(plane.field.velocities, velocities), k) for k in ends
    ]
    rows = plane.field.at(loads, velocities).rows
    return np.bitwise_or.reduce([plane.flags[i, j] for i in rows for j in columns])


def position_errors(row, preset, name):
    """True errors (compared with `fine`) and stated errors of a preset's rises at each position."""
    plane, true = plane_of(row, preset, name), np.array(row["fine"][name])
    loads, velocities = (
        axis.ravel() for axis in np.meshgrid(row["all_loads"], row["all_velocities"], indexing="ij")
    )
    points = plane.field.at(loads, velocities)
    stated = rise_errors(plane, preset_bound(preset, CRITERIA[name]), points)
    frame = pd.DataFrame(
        {
            "preset": preset,
            "criterion": name,
            "at_load": np.isin(loads, plane.field.loads),
            "at_velocity": np.isin(velocities, plane.field.velocities),
            "flags": flags_around(plane, loads, velocities),
            "error": np.exp(points.values) / true.ravel() - 1,
            "between": stated[INTERPOLATION],
            "stated": total(stated),
            "scene": row["name"],
            "family": row["family"],
            "half": row["number"] % 2,
        }
    )
    return frame[~(frame["at_load"] & frame["at_velocity"])] if preset == "fine" else frame


def beyond(row):
    """Yield true over stated errors of extrapolation from the two points next to the boundary."""
    full_plane = plane_of(row, "fine", USUAL)
    field, log_rises = full_plane.field, full_plane.field.plane
    above = np.sum(log_rises < np.median(log_rises), axis=1)[:, None]
    columns = np.arange(len(field.velocities))
    is_kept = (columns == above) | (columns == above - 1)
    plane = full_plane._replace(field=replace(field, plane=np.where(is_kept, log_rises, np.nan)))
    for load, is_known, values in zip(field.loads, is_kept, log_rises, strict=True):
        if is_known.sum() < 2:
            continue
        points = plane.field.at(np.full((~is_known).sum(), load), field.velocities[~is_known])
        excess = np.exp(points.values - values[~is_known]) - 1
        yield from excess / rise_errors(plane, 0.0, points)[INTERPOLATION]


def rms(values):
    """Root mean square."""
    return float(np.sqrt(np.mean(np.square(values))))


def quantile_99(values):
    """99 % quantile of absolute values."""
    return float(np.quantile(np.abs(values), 0.99))


MIN_COVERED, MIN_PROBABILITY, MAX_OVER = 0.95, 0.05, 4
COVERED = ("places", "scenes", "number", "rms error", "99 % within", "stated, rms", "over", "held")


def covered(name, errors):
    """Table row that compares true with stated errors, without positions that state none."""
    known = errors.dropna(subset="stated")
    error, stated = known["error"], known["stated"].astype(float)
    sizes = (f"{size:.2%}" for size in (rms(error), quantile_99(error), rms(stated)))
    over, covered_share = rms(stated) / quantile_99(error), np.mean(error.abs() <= stated)
    return name, known["scene"].nunique(), len(known), *sizes, f"{over:.1f}", f"{covered_share:.1%}"


def are_covered(lines):
    """True if the stated errors may hold at 95 % of positions, and are not much too large.

    The test is binomial: it fails if so many misses have a probability below 5 % although stated
    errors hold at 95 % of positions. Without a warning, and for an area fraction of 10 %, stated
    errors are at most 4 times the 99 % quantile of true errors. The highest temperature has no such
    limit, because its bounds come from a few scenes, which a sample may not contain.
    """
    for name, _, count, *_, over, covered_share in lines:
        misses = round(count * (1 - float(covered_share.rstrip("%")) / 100))
        if binom.sf(misses - 1, count, 1 - MIN_COVERED) < MIN_PROBABILITY:
            return False
        if name.endswith(f"without a warning, {USUAL}") and float(over) > MAX_OVER:
            return False
    return True


def constants(rows, errors):
    """Yield the name of each constant that this judges, and ratios of true errors to its bound."""
    points = errors[errors["at_load"] & errors["at_velocity"]]
    for (preset, name), group in points[points["flags"] == 0].groupby(["preset", "criterion"]):
        bound = preset_bound(preset, CRITERIA[name])
        yield f"RISE_EXPONENT, {preset}, {name}", group["error"] / bound
    usual = points[points["criterion"] == USUAL]
    if apart := [fine_apart(row) / PRESET_BOUNDS["fine"] for row in rows if "reference" in row]:
        yield "RISE_EXPONENT, fine by reference", np.concatenate(apart)
    fine = errors[(errors["preset"] == "fine") & (errors["criterion"] == USUAL)]
    for name, along, factor in (
        ("BENT_ALONG_LOAD, over stated", "at_velocity", 1.0),
        ("BENT, over stated", "at_load", 1.0),
    ):
        group = fine[fine[along] & (fine["between"] > 0)]
        yield name, factor * group["error"] / group["between"]
    yield "BENT beyond, over stated", [error for row in rows for error in beyond(row)]
    for kind in WarningKind:
        for preset, group in usual[usual["flags"] & int(kind) != 0].groupby("preset"):
            yield f"{kind.label}, {preset}", group["error"]
    if heat := [excess for row in rows for excess in too_warm(row)]:
        yield "present heat", heat


def fine_apart(row):
    """Relative differences of `fine` from `reference`, at points where `fine` has no warning."""
    names = ("loads", 2), ("velocities", 3)
    at = np.ix_(*(np.isin(row[f"all_{name}"], row[name][1::step]) for name, step in names))
    apart = np.array(row["fine"][USUAL])[at] / np.array(row["reference"][USUAL]) - 1
    is_clean = np.array(row["fine"]["flags"], int)[at] & ~int(WarningKind.PRESENT_HEAT) == 0
    return apart[is_clean]


def too_warm(row):
    """Relative excess of rises with present heat only, at points with that warning."""
    flags = np.array(row["standard"]["flags"], int)[:, np.isin(row["velocities"], row["few"])]
    return np.array(row["excess"])[flags & WarningKind.PRESENT_HEAT != 0]


def main():
    """Compute missing scenes, then report."""
    parser = argparse.ArgumentParser(prog="python -m tests.promises.errors", description=__doc__)
    parser.add_argument("--scenes", type=int, default=48, help="so many, drawn")
    parser.add_argument("--minutes", type=float, default=30.0, help="begin no scene later")
    parser.add_argument("--file", type=Path, default=Path("results/errors.jsonl"))
    options = parser.parse_args()
    done = {row["digest"] for row in read(options.file)}
    cases = [case for case in drawn(NUMBERS, options.scenes) if case.family != LEFT_OUT]
    tasks = [(case.family, case.number) for case in cases if case.digest not in done]
    compute(computed, tasks, options.file, options.minutes)
    rows = [row for row in read(options.file) if "failed" not in row]
    kinds = [(preset, name) for preset in PRESETS_JUDGED for name in CRITERIA]
    every = pd.concat([position_errors(row, *kind) for row in rows for kind in kinds])
    every["place"] = np.where(every["at_load"], "velocities", "loads")
    every.loc[every["at_load"] & every["at_velocity"], "place"] = "points"
    every.loc[~every["at_load"] & ~every["at_velocity"], "place"] = "both"
    usual, clean = every[every["criterion"] == USUAL], every[every["flags"] == 0]
    judged = [covered(preset, group) for preset, group in usual.groupby("preset")]
    judged += [
        covered(f"{preset}, without a warning, {name}", group)
        for (name, preset), group in clean.groupby(["criterion", "preset"])
    ]
    lines = [
        covered(f"{preset}, without a warning, {column} {name}", group)
        for column in ("half", "family", "place")
        for (name, preset), group in clean.groupby([column, "preset"])
    ]
    tables = {"all": constants(rows, every)} | {
        f"half {number}": constants([row for row in rows if row["number"] % 2 == number], group)
        for number, group in every.groupby("half")
    }
    frame = pd.DataFrame(
        {name: {label: quantile_99(x) for label, x in kind} for name, kind in tables.items()}
    )
    by_constant = [(label, *(f"{x:.3g}" for x in row)) for label, *row in frame.itertuples()]
    report = table(COVERED, judged + lines), table(("99 % within", *tables), by_constant)
    return conclude("errors", "\n\n".join(report), are_covered(judged))


if __name__ == "__main__":
    sys.exit(main())
