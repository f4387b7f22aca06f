"""Judge the linear rule for uncertain inputs by draws of all inputs through full simulations.

All inputs of a scene that act by simulations are drawn at once, lognormal with one relative
standard deviation, and each draw is simulated. The same draws give a linear change of ln(rise) by
the sensitivities. Both are compared: their standard deviations, and the probabilities that the rise
is above a limit, at limits up to one standard deviation away. Friction and temperatures, which act
in closed form, are left out.

    python -m tests.promises.inputs --draws 200    # an hour; continues results/inputs.jsonl
    python -m tests.promises.inputs --draws 20 --scenes flagship --sizes 0.2
"""

import argparse
import itertools
import sys
import tempfile
import time
from pathlib import Path

import numpy as np

import pipeline
from pipeline.quantities import in_unit
from tests.helpers.campaigns import compute, conclude, read, table
from tribo import TriboError

GEAR = "case-hardened 20MnCr5"
SCENES = {
    "flagship": ("irg_transition", {}, [(200.0, 3.5), (400.0, 2.25), (750.0, 1.25)]),
    "ball": ("ball_on_disk", {}, [(50.0, 1.35), (150.0, 0.6), (300.0, 0.35)]),
    "gear": (
        "gear_mesh",
        {
            "without": ["sweep.along", "sweep.load_factors"],
            f"materials.{GEAR}.like": GEAR,
            "pin.radius": "7.531 mm",
            "motion.slide_roll_ratio": 1.0627,
            "motion.pin_track_length": "69 mm",
            "motion.disk_track_length": "150.4 mm",
            "sweep.loads": ["4 kN", "9 kN"],
            "sweep.velocities": ["3.7748 m/s"],
        },
        [(4463.5, 3.7748), (6695.0, 3.7748), (8927.0, 3.7748)],
    ),
}
"""Scenes by name: the shipped one, entries that differ, and points. The gear is at position D."""
PROMISED = 0.05, 0.1, 0.2
"""Relative standard deviations of the inputs up to which the linear rule is promised."""
SIZES = *PROMISED, 0.4
OFFSETS = -1.0, -0.5, 0.0, 0.5, 1.0  # of limits, in standard deviations
MAX_DEVIATION, MAX_PROBABILITY = 0.05, 0.02  # relative; absolute
HEADS = "scene", "point", "inputs", "draws", "sd simulated", "sd linear", "ratio", "ΔP"


def overrides_of(ds, factors):
    """Entries of a scene whose inputs, those of a dataset of sensitivities, have factors."""
    entries = {}
    for k, (path, factor) in enumerate(factors.items()):
        unit = str(ds["unit"].values[k])
        value = float(in_unit(ds["value"].values[k], unit)) * factor
        entries[path] = f"{value!r} {unit}" if unit else value
    return entries


def log_rise(sweep, load, velocity):
    """ln of the governing rise of a scene at a point."""
    return float(
        np.log(pipeline.run_point(sweep, load, velocity).verdict(sweep.conditions).contact_rise)
    )


def computed(task):
    """Changes of ln(rise) of all draws at a point, simulated and linear, as a row of the file."""
    name, number, size, draws = task
    began, (scene, entries, points) = time.monotonic(), SCENES[name]
    load, velocity = points[number]
    entries = {**entries, "sweep.steps": "end", "sweep.fields": False}
    sweep = pipeline.load_scene(scene, overrides=entries)
    with tempfile.TemporaryDirectory() as folder:
        store = Path(folder) / "inputs.zarr"
        ds = pipeline.sensitivity(sweep, load, velocity, store, workers=1)
    is_drawn = [not p.startswith(("friction", "temperature", "oil")) for p in ds["input"].values]
    ds = ds.isel(input=is_drawn).sortby("input")
    rng = np.random.default_rng([len(name), number])
    logs = size * rng.standard_normal((draws, ds.sizes["input"]))
    base, simulated, refused = log_rise(sweep, load, velocity), [], []
    for row in logs:
        factors = dict(zip(ds["input"].values.tolist(), np.exp(row).tolist(), strict=True))
        try:
            drawn = pipeline.load_scene(scene, overrides=entries | overrides_of(ds, factors))
            simulated.append(log_rise(drawn, load, velocity) - base)
        except TriboError as error:
            simulated.append(None)
            refused.append(str(error))
    linear = (logs @ ds["sensitivity"].values).tolist()
    return {
        "name": f"{name} {load:g} N {size:g}", "scene": name, "point": [load, velocity],
        "size": size, "draws": draws, "simulated": simulated, "linear": linear,
        "inputs": ds["input"].values.tolist(), "sensitivity": ds["sensitivity"].values.tolist(),
        "refused": refused, "seconds": round(time.monotonic() - began),
    }  # fmt: skip


def compared(row):
    """Standard deviations, simulated and linear on the same draws; largest ΔP, and its error.

    ΔP, by which the linear rule misses the probability that ln(rise) is above a limit, is the
    density of draws at the limit times the mean difference of both changes there. A parabola in the
    linear change fits the difference. Counts of 200 draws would err by 0.01, four times as much.
    """
    is_solved = [value is not None for value in row["simulated"]]
    simulated, linear = (np.array(row[key], float)[is_solved] for key in ("simulated", "linear"))
    changes, differences = linear / linear.std(), (simulated - linear) / linear.std()
    parabola, covariance = np.polyfit(changes, differences, 2, cov=True)
    powers = np.vander(OFFSETS, 3)
    densities = np.exp(-np.square(OFFSETS) / 2) / np.sqrt(2 * np.pi)
    errors = densities * np.abs(powers @ parabola)
    deviations = densities * np.sqrt((powers @ covariance * powers).sum(axis=1))
    worst = int(errors.argmax())
    return float(simulated.std()), float(linear.std()), errors[worst], deviations[worst]


def is_right(rows):
    """True if the linear rule holds wherever it is promised, ΔP within two standard errors."""
    return all(
        abs(linear / simulated - 1) <= MAX_DEVIATION and error <= MAX_PROBABILITY + 2 * chance
        for row in rows
        if row["size"] <= max(PROMISED)
        for simulated, linear, error, chance in [compared(row)]
    )


def report(rows):
    """The table of all rows, and a line with the worst of each size."""
    lines, worst = [], {}
    for row in sorted(rows, key=lambda row: (row["size"], row["scene"], row["point"])):
        simulated, linear, error, deviation = compared(row)
        ratio, load_velocity = linear / simulated, "{:g} N, {:g} m/s".format(*row["point"])
        count = sum(value is not None for value in row["simulated"])
        probability = f"{error:.3f} ± {deviation:.3f}"
        cells = f"{simulated:.4f}", f"{linear:.4f}", f"{ratio:.3f}", probability
        lines.append((row["scene"], load_velocity, f"{100 * row['size']:g} %", count, *cells))
        errors = abs(ratio - 1), (error, probability), row["scene"]
        worst.setdefault(row["size"], []).append(errors)
    texts = [
        f"{100 * size:g} %: {100 * max(ratios):.1f} % of the standard deviation, "
        f"{max(probabilities)[1]} of P at {len(ratios)} points of {', '.join(dict.fromkeys(names))}"
        for size, errors in worst.items()
        for ratios, probabilities, names in [zip(*errors, strict=True)]
    ]
    return "\n\n".join(
        [table(HEADS, lines), f"largest errors of the linear rule by inputs of {'; '.join(texts)}"]
    )


def main():
    parser = argparse.ArgumentParser(prog="python -m tests.promises.inputs", description=__doc__)
    parser.add_argument("--draws", type=int, default=200)
    parser.add_argument("--scenes", nargs="+", default=[*SCENES], choices=SCENES)
    parser.add_argument("--points", type=int, default=3, help="of each scene")
    parser.add_argument("--sizes", type=float, nargs="+", default=[*SIZES])
    parser.add_argument("--minutes", type=float, default=120)
    parser.add_argument("--file", type=Path, default=Path("results/inputs.jsonl"))
    options = parser.parse_args()
    sizes = sorted(options.sizes, key=lambda size: abs(size - 0.2))
    wanted = [
        (name, number, size, options.draws)
        for size, name, number in itertools.product(sizes, options.scenes, range(options.points))
    ]
    done = {(row["scene"], *row["point"], row["size"], row["draws"]) for row in read(options.file)}
    tasks = [t for t in wanted if (t[0], *SCENES[t[0]][2][t[1]], *t[2:]) not in done]
    compute(computed, tasks, options.file, options.minutes)
    rows = [row for row in read(options.file) if row["draws"] == options.draws]
    rows = [row for row in rows if row["scene"] in options.scenes and row["size"] in options.sizes]
    return conclude("inputs", report(rows), is_right(rows))


if __name__ == "__main__":
    sys.exit(main())
