"""Whether the stated error by surface sampling holds, by counts of surface realizations.

Each scene is computed at two loads on 20 realizations. Sets of one, two, four and eight of them are
compared with the mean of all others: the two may differ by √(e₁² + e₂²), where e are the stated
errors, bounds at 95 %. Of further sets of eight, the second load has two realizations, so that its
mean also rests on those of the first load.

The two loads of a scene share their realizations and count as one set. The bounds are right if 95 %
lies within the interval of the count of all sets, for each size; if single realizations fail on no
more scenes than by chance; and if the median of what they state is at least as large as 0.8 of the
bound by all realizations, and at most 5 times as large. Under local wear a realization states more.

    python -m tests.promises.realizations [--realizations N] [NAME ...]
"""

import argparse
import sys
import tempfile
from pathlib import Path

import numpy as np
import xarray as xr
from scipy.stats import beta, binom

import pipeline
from pipeline.answers.error import SURFACE, rise_errors
from pipeline.answers.results import cases_of
from pipeline.answers.verdict_model import verdict_model
from pipeline.store.schema import PENDING
from tests.helpers.campaigns import conclude, table
from tests.promises.moving_disk import oblique_heights
from tribo import Grid

LINE = {"window.pixels": [288, 240], "window.pixel_size": ["1.632 um", "1.9 um"]}
DISCS = {"window.pixels": [720, 160], "window.pixel_size": ["1.632 um", "1.9 um"]}
BALL = {"window.pixels": [320, 320], "window.pixel_size": ["1.5 um", "1.5 um"], "without": ["oil"]}
SMALL_BALL = BALL | {"window.pixels": [160, 160], "window.pixel_size": ["2.6 um", "2.6 um"]}
CROWNED = BALL | {"pin.shape": "crowned", "pin.crown_radius": "12 mm", "pin.radius": "4 mm"}
CONTRA = DISCS | {"motion.slide_roll_ratio": -5, "window.pixels": [480, 160]}
CONTRA["without"] = ["oil", "pin.diameter", "pin.width", "disk.diameter", "disk.width"]
KINDS = {
    "line": ("first_try", LINE, ("200 N", "700 N"), "1.5 m/s"),
    "local wear": ("first_try", LINE | {"wear.pattern": "local"}, ("200 N", "700 N"), "1.5 m/s"),
    "discs": ("twin_disc", DISCS | {"without": ["oil"]}, ("2.5 kN", "7 kN"), "2 m/s"),
    "contra discs": ("twin_disc", CONTRA, ("1 kN", "4 kN"), "2 m/s"),
    "ball": ("ball_on_disk", BALL, ("60 N", "200 N"), "1 m/s"),
    "small ball": ("ball_on_disk", SMALL_BALL, ("40 N", "150 N"), "1.5 m/s"),
    "crowned": ("ball_on_disk", CROWNED, ("60 N", "200 N"), "1 m/s"),
}
"""Scene, changed entries, loads and velocity, by kind of contact."""
SCENES = {
    "line": {},
    "line, Ra 0.1 µm": {"ra": 0.1},
    "line, 12 µm": {"lengths": (12, 12)},
    "line, across 30 µm": {"lengths": (5, 30)},
    "line, across 100 µm": {"lengths": (4, 100), "hurst": 0.6},
    "line, across 180 µm": {"lengths": (4, 180)},
    "line, across 400 µm": {"lengths": (4, 400)},
    "line, along 60 µm": {"lengths": (60, 6)},
    "line, oblique": {"lengths": (4, 60), "angle": 30.0},
    "line, scan of worn peaks": {"lengths": (6, 40), "angle": 0.0, "peaks": 0.6, "ra": 0.35},
    "local wear": {},
    "local wear, across 40 µm": {"lengths": (5, 40)},
    "discs": {"lengths": (6, 6)},
    "discs, across 60 µm": {"lengths": (4, 60)},
    "discs, along 60 µm": {"lengths": (60, 5)},
    "contra discs, across 50 µm": {"lengths": (5, 50), "hurst": 0.7},
    "ball": {},
    "ball, across 30 µm": {"lengths": (5, 30)},
    "small ball, across 45 µm": {"lengths": (6, 45), "ra": 0.15},
    "crowned": {"lengths": (6, 6), "ra": 0.15},
    "crowned, across 60 µm": {"lengths": (5, 60), "ra": 0.2},
    "crowned, oblique scan": {"lengths": (5, 30), "angle": -40.0, "ra": 0.2},
}
"""Roughness by scene: Ra and correlation lengths [µm]; of a scan, angle of its grooves to y [°]."""
SIZES = {"1": (1, 1), "2": (2, 2), "4": (4, 4), "8": (8, 8), "8 and 2": (8, 2)}
"""Realizations of a set at the first load and at the second, by name."""
MIN_HELD, MIN_STATED, MAX_STATED = 0.95, 0.8, 5.0
HEADS = (
    "contact", "N", "realizations differ by", "one states", "from", "to", "over their bound",
    *(f"held by {name}" for name in SIZES),
)  # fmt: skip


def results_of(name, count, **changes):
    """Dataset of a scene at its two points, with `count` realizations."""
    scene, entries, loads, velocity = KINDS[name.partition(",")[0]]
    overrides = entries | {"sweep.loads": list(loads), "sweep.velocities": [velocity]}
    overrides |= {"sweep.fields": False, "sweep.steps": "end", "fidelity.preset": "standard"}
    overrides |= {"sweep.realizations": count} | changes
    with tempfile.TemporaryDirectory() as folder:
        rough = roughness(SCENES[name], overrides, Path(folder) / "scan.npy", count)
        without = [*overrides.get("without", ()), *rough.pop("without", ())]
        rough |= {"without": without} if without else {}
        sweep = pipeline.load_scene(scene, overrides=overrides | rough)
        path = Path(folder) / "realizations.zarr"
        pipeline.run_sweep(sweep, path)
        return pipeline.open_sweep(path).load()


def roughness(surface, window, path, count):
    """Entries of the roughness of a scene; a scan is written to `path`."""
    ra, lengths = surface.get("ra", 0.27), surface.get("lengths", (4, 4))
    if "angle" not in surface:
        return {
            "disk.roughness.ra": f"{ra} um",
            "disk.roughness.correlation_length": [f"{length} um" for length in lengths],
            "disk.roughness.hurst_exponent": surface.get("hurst", 0.8),
        }
    nx, ny = window["window.pixels"]
    sides = window["window.pixel_size"]
    spacing = tuple(1e-6 * float(side.split()[0]) for side in sides)
    # Areas of the scan are cut from a larger surface, so that they do not repeat themselves.
    grid = Grid((nx * count + nx // 2, ny + ny // 2), spacing)
    lengths = tuple(1e-6 * length for length in lengths)
    heights = oblique_heights(grid, surface["angle"], 0, lengths, 1e-6 * ra)[: nx * count, :ny]
    heights = np.where(heights > 0, surface.get("peaks", 1.0) * heights, heights)
    np.save(path, 1e6 * heights.T)
    return {
        "without": ["disk.roughness"], "disk.roughness.file": str(path),
        "disk.roughness.height_unit": "um",
    }  # fmt: skip


def stated(ds):
    """ln(rise) of a specimen at each load, and the error that it states for surface sampling."""
    (case,) = cases_of(ds)
    model = verdict_model(case, case.sweep.conditions)
    velocities = np.repeat(ds["velocity"].values, ds.sizes["load"])
    points = model.field.at(ds["load"].values, velocities)
    return points.values, rise_errors(model.specimen, model.preset_error, points)[SURFACE]


def parts(ds, first, sizes):
    """Datasets of a set of realizations from number `first` on, and of all others."""
    number = np.arange(ds.sizes["realization"])
    is_own = (first <= number) & (number < first + sizes[0])
    own, others = ds.isel(realization=is_own), ds.isel(realization=~is_own)
    position = xr.DataArray(np.arange(sizes[0]), dims="realization")
    limits = xr.DataArray(list(sizes), dims="load")
    return own.assign(status=own["status"].where(position < limits, PENDING)), others


def sets_held(ds, sizes):
    """True for each set of realizations and load where it agrees with the others (sets, loads).

    It is NaN where the set states no error.
    """
    held = []
    for first in range(0, ds.sizes["realization"] - sizes[0] + 1, sizes[0]):
        (level, error), (other_level, other_error) = map(stated, parts(ds, first, sizes))
        allowed = np.hypot(error, other_error)
        is_held = np.abs(level - other_level) <= allowed
        held.append(np.where(np.isfinite(allowed), is_held, np.nan))
    return np.array(held)


def judge_scene(name, count=20, **changes):
    """Table rows of a scene, held sets by size, and the ratio of stated to actual bounds."""
    ds = results_of(name, count, **changes)
    (case,) = cases_of(ds)
    levels = case.log_rises(case.sweep.conditions)[..., 0]
    errors = np.array([stated(ds.isel(realization=[k]))[1] for k in range(count)])
    held = {key: sets_held(ds, sizes) for key, sizes in SIZES.items() if 2 * sizes[0] <= count}
    deviations = levels.std(axis=0, ddof=1)
    ratios = np.median(errors, axis=0) / (1.96 * deviations)
    rows = []
    for k, load in enumerate(ds["load"].values):
        percents = (deviations[k], np.median(errors[:, k]), errors[:, k].min(), errors[:, k].max())
        cells = [f"{value:.1%}" if np.isfinite(value) else "unknown" for value in percents]
        counts = [_count(held[key][:, k]) if key in held else "–" for key in SIZES]
        rows.append((name, f"{load:g}", *cells, f"{ratios[k]:.2f}", *counts))
    return rows, held, ratios


def _count(is_held):
    known = is_held[np.isfinite(is_held)]
    return f"{known.sum():.0f} of {known.size}"


def highest_share(held, total):
    """Upper end of the 95 % interval of a share, by a count."""
    return beta.ppf(0.975, held + 1, total - held) if held < total else 1.0


def are_right(held_by_scene):
    """True if bounds may hold at 95 % of sets, from the share and number of sets of each scene.

    At 95 %, a scene fails by chance with the probability that its count is that low.
    """
    held = sum(share * total for share, total in held_by_scene)
    if highest_share(held, sum(total for _, total in held_by_scene)) < MIN_HELD:
        return False
    failing = sum(highest_share(share * total, total) < MIN_HELD for share, total in held_by_scene)
    chance = max(
        (binom.cdf(n, total, MIN_HELD) for _, total in held_by_scene for n in range(total)
         if highest_share(n, total) < MIN_HELD), default=0.0,
    )  # fmt: skip
    return failing <= binom.ppf(0.975, len(held_by_scene), chance)


def main():
    """Judge the errors of all scenes."""
    parser = argparse.ArgumentParser(description=__doc__, allow_abbrev=False)
    parser.add_argument("names", nargs="*", metavar="NAME", help="scenes; all if not given")
    parser.add_argument("--realizations", type=int, default=20)
    options = parser.parse_args()
    rows, shares, ratios = [], {key: [] for key in SIZES}, []
    for name in options.names or SCENES:
        scene_rows, held, scene_ratios = judge_scene(name, options.realizations)
        rows += scene_rows
        print(*scene_rows, sep="\n", file=sys.stderr, flush=True)
        ratios += (
            [] if name.startswith("local") else scene_ratios[np.isfinite(scene_ratios)].tolist()
        )
        for key, is_held in held.items():
            is_known = np.isfinite(is_held).all(axis=1)
            if is_known.any():
                shares[key].append((is_held[is_known].mean(), int(is_known.sum())))
    counts = {
        key: (sum(share * total for share, total in scenes), sum(total for _, total in scenes))
        for key, scenes in shares.items() if scenes
    }  # fmt: skip
    texts = ", ".join(
        f"{held / total:.1%} of {total} sets of {key}" for key, (held, total) in counts.items()
    )
    least = min(share for share, _ in shares["1"])
    statement = (
        f"{texts}; at least {least:.0%} of single realizations of each of {len(shares['1'])} "
        f"scenes, which state {min(ratios):.2g} to {max(ratios):.2g} times the bound by all"
    )
    is_right = all(map(are_right, filter(None, shares.values())))
    is_right = is_right and min(ratios) >= MIN_STATED and max(ratios) <= MAX_STATED
    return conclude("realizations", f"{table(HEADS, rows)}\n\n{statement}", bool(is_right))


if __name__ == "__main__":
    sys.exit(main())
