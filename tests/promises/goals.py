"""Judge `--accuracy`: how often the whole error of the boundary is below it, and what is missed.

Scenes of all families are searched on points that are computed once and kept in files, so that the
next accuracy has them. The truth at a load is the mean of 64 other realizations by `fine`, where a
surface has no others `reference`, at the velocity next to the crossing of the whole plane of the
first one. The error is that of the velocity at which wear turns. It may be as large as the accuracy
and as the truth is uncertain.

    python -m tests.promises.goals                          # 20 scenes, 5, 2 and 1 %
    python -m tests.promises.goals --scenes 8 --accuracy 3  # per cent
"""

import argparse
import json
import math
import sys
import tempfile
import time
from dataclasses import replace
from functools import cached_property
from pathlib import Path

import numpy as np
from scipy.stats import beta

from pipeline.answers.error import SURFACE, preset_error_of, presets_for, total
from pipeline.run.goal import reason_surface_is_fixed
from pipeline.run.search import MOST_REALIZATIONS, Goal, PointIndex
from pipeline.sweep.plan import choose_stored_steps, run_point
from pipeline.sweep.sweep import Point
from tests.helpers.campaigns import commit, compute, conclude, read, table
from tests.helpers.search_in_memory import Told
from tests.promises.families import cases
from tribo import TriboError
from tribo.simulation import jackknife_quality
from tribo.simulation.verdict import relative_sampling, worst_rises

POINTS = Path("results/goals")
REALIZATIONS = 64  # of the truth
MIN_HELD = 0.95  # share of loads; a sample of them may have fewer by chance
NUMBERS = range(3, 11, 2)  # of scenes; windows of the first shipped ones are large
VELOCITIES = np.geomspace(0.25, 4.0, 16)  # over that of a scene's middle
_NEARBY = 1.02  # ratio of velocities about a crossing, for its exponent
_FIRST = Goal(0.02, 1, counts_surface=False)
HEADS = "accuracy", "scenes", "out of reach", "loads", "held", "median", "largest", "points"


class Planes:
    """Points of a scene by preset, realization, load and velocity, cached in a file."""

    def __init__(self, sweep, path):
        self.fixed, self.conditions = reason_surface_is_fixed(sweep), sweep.conditions
        self.loads, self.velocities = np.array(sweep.loads), np.array(sweep.velocities)
        names = presets_for(sweep.scene, ["standard", "fine", "reference"])
        presets = {name: sweep.with_fidelity(preset, name) for name, preset in names.items()}
        self.promised = {name: preset_error_of(preset) for name, preset in presets.items()}
        self._realizations = {name: self._scenes(preset) for name, preset in presets.items()}
        self._stored_steps, self._path = choose_stored_steps(sweep), path
        rows = json.loads(path.read_text()) if path.exists() else []
        self._points = {tuple(key): tuple(values) for key, values in rows}

    def _scenes(self, sweep):
        """Scenes of the realizations of a sweep."""
        if self.fixed:
            return [sweep.scene]
        return [
            case.scene for case in sweep.with_realizations(MOST_REALIZATIONS + REALIZATIONS).cases
        ]

    def keep(self):
        """Write the points to the file."""
        self._path.parent.mkdir(parents=True, exist_ok=True)
        self._path.write_text(json.dumps([*self._points.items()]))

    def point(self, preset, realization, load, velocity):
        """Rise at friction 1 [K], its deviation, warning flags and duration; NaN if it fails."""
        key = preset, realization, float(load), float(velocity)
        if key not in self._points:
            try:
                record = run_point(
                    self._realizations[preset][realization], self._stored_steps, Point(*key[2:])
                )
            except TriboError:
                self._points[key] = np.nan, np.nan, 0, 0.0
                return self._points[key]
            rise = worst_rises(record.columns, np.array([record.least_load]), self.conditions)
            columns = {**record.columns, **record.sampling}
            self._points[key] = (
                rise.item(),
                float(relative_sampling(columns, self.conditions)),
                sum({int(warning.kind) for warning in record.warnings}),
                float(np.nanmax(record.columns["time"])),
            )
        return self._points[key]

    def tell(self, search, points, preset="standard"):
        """Give a search the results of the points that it has asked for."""
        every = [
            self.point(preset, realization, self.loads[load], search.velocities[velocity])
            for realization, load, velocity in points
        ]
        search.tell(points, *map(np.array, zip(*every, strict=True)))

    def search(self, accuracy, preset):
        """A search, run to its end."""
        realizations, freedom = (
            1 if self.fixed else MOST_REALIZATIONS,
            jackknife_quality(self._realizations[preset][0]).freedom,
        )
        goal = Goal(accuracy, realizations, not self.fixed)
        plane = self.loads, self.velocities, self.conditions
        search = Told(*plane, self.promised[preset], goal, freedom)
        while batch := search.ask():
            self.tell(search, batch, preset)
        return search

    @cached_property
    def _plane(self):
        """A search that has all points of the first realization."""
        search = Told(self.loads, self.velocities, self.conditions, 0.0, _FIRST)
        indices = np.ndindex(len(self.loads), len(self.velocities))
        self.tell(search, [PointIndex(0, *index) for index in indices])
        return search

    def true_y(self, load, velocity):
        """True ln(rise/limit) of the specimen at a velocity [m/s], and its standard error."""
        crossing = self._plane.critical[self.loads == load].item()
        distances = np.abs(np.log(self.velocities / (crossing if crossing > 0 else velocity)))
        nearest_velocity = self.velocities[np.argmin(distances)]
        if self.fixed:
            rises = [self.point("reference", 0, load, nearest_velocity)[0]]
        else:
            numbers = range(MOST_REALIZATIONS, MOST_REALIZATIONS + REALIZATIONS)
            rises = [
                self.point("fine", realization, load, nearest_velocity)[0]
                for realization in numbers
            ]
        logs = np.log(rises)
        level = logs.max() if self.conditions.critical_area_fraction == 0 else logs.mean()
        y_crossing, y_nearest = _y(self._plane, load, np.array([velocity, nearest_velocity]))
        deviation = 0.0 if self.fixed else logs.std(ddof=1) / np.sqrt(len(logs))
        return level - self._plane.limit + y_crossing - y_nearest, deviation

    def errors(self, accuracy):
        """Number of points of a search for an accuracy, and its true error at each load."""
        preset = next(name for name, error in self.promised.items() if (error or 0.0) < accuracy)
        search = self.search(accuracy, preset)
        parts = search.errors if not self.fixed else np.delete(search.errors, SURFACE, axis=0)
        best, errors = float(np.nanmax(total(parts), initial=0.0)), []
        for load, velocity in zip(self.loads, search.critical, strict=True):
            if np.isfinite(velocity) and best <= accuracy:
                y_nearby = _y(search, load, velocity * np.array([1 / _NEARBY, _NEARBY]))
                slope = np.diff(y_nearby).item() / (2 * np.log(_NEARBY))
                y, deviation = self.true_y(load, velocity)
                allowed = np.hypot(accuracy, 1.96 * deviation / slope)
                errors.append([load, velocity, float(np.expm1(y / slope)), float(allowed)])
        return {
            "preset": preset,
            "points": int(search.asked.sum()),
            "best": float(best),
            "errors": errors,
        }


def _y(search, load, velocities):
    """ln(rise/limit) at velocities of a load, from the points of a search."""
    return search.specimen.field(np.full(velocities.shape, load), velocities) - search.limit


def scene(case):
    """Sweep of a case of a family, with velocities about the crossing of its middle load."""
    middle = float(np.exp(np.mean([np.log(float(text.split()[0])) for text in case.velocities])))
    entries = case.entries | {
        "sweep.velocities": [f"{middle * ratio:.4g} m/s" for ratio in VELOCITIES],
        "sweep.fields": False,
        "sweep.steps": "end",
    }
    with tempfile.TemporaryDirectory() as folder:
        sweep = replace(case, entries=entries).sweep(Path(folder), "standard")
        load, conditions = sweep.loads[len(sweep.loads) // 2], sweep.conditions
        point = run_point(sweep.scene, choose_stored_steps(sweep), Point(load, middle))
        rise = worst_rises(point.columns, np.array([point.least_load]), conditions).item()
        hot = conditions.bulk_temperature + conditions.friction * rise
        entries["temperature.critical"] = f"{hot - 273.15:.5g} degC"
        return replace(case, entries=entries).sweep(Path(folder), "standard")


def computed(task):
    """Row of a scene: true errors by accuracy; or why it failed."""
    number, accuracies = task
    np.seterr(all="raise", under="ignore")
    case = cases(NUMBERS)[number]
    began, row = time.process_time(), {"name": case.name, "digest": case.digest}
    try:
        planes = Planes(scene(case), POINTS / f"{case.digest}.json")
        row["accuracy"] = {}
        for accuracy in accuracies:
            planes.keep()
            row["accuracy"][f"{accuracy:g}"] = planes.errors(accuracy / 100)
        planes.keep()
    except TriboError as error:
        row["failed"] = str(error)
    return row | {"seconds": round(time.process_time() - began), "commit": commit()}


def summary(rows, accuracy):
    """Table row of an accuracy [%], and True if it may hold at 95 % of all loads."""
    results = [row["accuracy"][accuracy] for row in rows if accuracy in row.get("accuracy", {})]
    reached = [row for row in results if row["best"] <= float(accuracy) / 100 and row["errors"]]
    sizes = [np.abs(np.array(row["errors"])[:, 2:]) for row in reached]
    errors, allowed = np.concatenate([np.empty((0, 2)), *sizes]).T
    is_held = errors <= allowed
    cells = [f"{is_held.sum()} of {len(errors)}"]
    cells += [f"{size(errors):.2%}" if len(errors) else "" for size in (np.median, np.max)]
    points = [row["points"] for row in reached]
    many = f"{np.median(points):.0f}, at most {max(points)}" if points else ""
    missing = len(results) - len(reached)
    row = (f"{accuracy} %", len(results), missing, len(errors), *cells, many)
    return row, is_held.all() or highest_share(is_held.mean(), len(reached)) >= MIN_HELD


def highest_share(share, scenes):
    """Upper end of the 95 % interval of a share; loads of a scene share realizations."""
    return beta.ppf(0.975, share * scenes + 1, (1 - share) * scenes)


def report(rows, accuracies):
    """Report as text, and True if all promises hold."""
    lines, are_held = zip(*(summary(rows, f"{accuracy:g}") for accuracy in accuracies), strict=True)
    failed = [f"{row['name']} failed: {row['failed']}" for row in rows if "failed" in row]
    return "\n".join([table(HEADS, lines), *failed]), all(are_held)


def drawn(count):
    """`count` scenes drawn from all families, each with its number; small windows first."""
    scenes = cases(NUMBERS)
    order = np.random.default_rng(0).permutation(len(scenes))[:count]
    pairs = [(int(number), scenes[number]) for number in order]
    return sorted(pairs, key=lambda pair: math.prod(pair[1].entries["window.pixels"]))


def main():
    parser = argparse.ArgumentParser(prog="python -m tests.promises.goals", description=__doc__)
    parser.add_argument("--scenes", type=int, default=20, help="scenes, drawn from all families")
    parser.add_argument(
        "--accuracy", type=float, nargs="+", default=[5.0, 2.0, 1.0], help="per cent"
    )
    parser.add_argument("--minutes", type=float, default=120.0, help="begin no scene later")
    options = parser.parse_args()
    name = "goals_" + "_".join(f"{accuracy:g}" for accuracy in options.accuracy)
    path = Path(f"results/{name}.jsonl")
    done = {row["digest"] for row in read(path)}
    tasks = [
        (number, options.accuracy)
        for number, case in drawn(options.scenes)
        if case.digest not in done
    ]
    compute(computed, tasks, path, options.minutes)
    rows = read(path)
    return conclude(name, *report(rows, options.accuracy))


if __name__ == "__main__":
    sys.exit(main())
