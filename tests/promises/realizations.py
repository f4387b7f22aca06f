"""Whether the stated error by surface sampling holds: two sets of eight realizations, and each.

Each scene is computed on its first realization, and at one point a load on fifteen more. Of each
set of eight every second load has four, so that it takes from others what these tell. The rises of
two sets may differ by 2.4 √(e₁² + e₂²), where e are the errors that both state. What one
realization states must be half to three times of how the sixteen differ: between discs it is 2 to 3
times too large, elsewhere within a factor of 2. Where wear is local this is not judged: it counts
for little.
"""

import argparse
import math
import sys
import tempfile
from pathlib import Path

import numpy as np
import xarray as xr

import pipeline
from pipeline.answers.error import SURFACE, rise_errors
from pipeline.answers.results import cases_of
from pipeline.answers.verdict_model import JudgedCase
from pipeline.store.schema import PENDING
from tests.helpers.campaigns import conclude, table

SCENES = {
    "line": ("first_try", {}, ("200 N", "400 N", "600 N", "750 N")),
    "ball": ("ball_on_disk", {}, ("50 N", "100 N", "200 N", "300 N")),
    "crowned": (
        "ball_on_disk",
        {"pin.shape": "crowned", "pin.crown_radius": "6 mm"},
        ("50 N", "100 N", "200 N", "300 N"),
    ),
    "pin on disk": ("pin_on_disk", {}, ("50 N", "100 N", "150 N", "200 N")),
    "discs": ("twin_disc", {}, ("2 kN", "4 kN", "6 kN", "8 kN")),
    "local wear": ("first_try", {"wear.pattern": "local"}, ("200 N", "400 N", "600 N", "750 N")),
}
"""Scene, changed entries and loads, by kind of contact."""
ALLOWED, MIN_AGREEING = 2.4, 0.9  # of the difference of two sets, and share of points
MIN_RATIO, MAX_RATIO = 0.5, 3.0  # error that one realization states, over how they differ
HEADS = (
    "contact", "N", "m/s", "first eight", "last eight", "stated", "apart, of allowed",
    "realizations differ by", "one states", "from", "to",
)  # fmt: skip


def compare_halves(name, count=16, **changes):
    """Yield for each load the point, and what the two halves and all realizations state."""
    scene, entries, loads = SCENES[name]
    overrides = {"sweep.loads": list(loads), "sweep.fields": False, "sweep.steps": "end"}
    overrides |= {"sweep.realizations": list(range(count))} | entries | changes
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "realizations.zarr"
        pipeline.run_sweep(pipeline.load_scene(scene, overrides=overrides), path, accuracy=0.05)
        ds = pipeline.open_sweep(path).load()
    done = (ds["status"] == 1).all("realization")
    for load in ds["load"].values[done.any("velocity").values]:
        (velocity,) = ds["velocity"].values[done.sel(load=load).values]
        point = ds.sel(load=[load], velocity=[velocity])
        half = count // 2
        parts = slice(half), slice(half, None)
        halves = (thinned(ds.isel(realization=part)) for part in parts)
        rises, errors = zip(*(stated(half_ds, load, velocity) for half_ds in halves), strict=True)
        (case,) = cases_of(point)
        conditions = case.sweep.conditions
        levels, deviations = case.log_rises(conditions).ravel(), case.sampling(conditions).ravel()
        yield load, velocity, rises, errors, levels.std(ddof=1), deviations


def thinned(ds):
    """Dataset with only half of the realizations at every second load."""
    number = xr.DataArray(np.arange(ds.sizes["realization"]), dims="realization")
    is_second = xr.DataArray(np.arange(ds.sizes["load"]) % 2 == 1, dims="load")
    is_left_out = is_second & (number >= max(2, len(number) // 2))
    return ds.assign(status=ds["status"].where(~is_left_out, PENDING))


def stated(ds, load, velocity):
    """Rise of a specimen [K], and the relative error that it states for surface sampling."""
    (case,) = cases_of(ds)
    judge = JudgedCase(case).under(case.sweep.conditions)
    at = np.array([load]), np.array([velocity])
    errors = rise_errors(judge.specimen, judge.promised, *at)
    return np.exp(judge.field(*at)).item(), errors[SURFACE].item()


def scene_is_local(name):
    """True if wear of a scene is local."""
    return SCENES[name][1].get("wear.pattern") == "local"


def rows_of(name, **options):
    """Yield table row, difference over the allowed one, and ratio of stated to actual deviation."""
    for load, velocity, rises, errors, differ, deviations in compare_halves(name, **options):
        apart = abs(math.log(rises[0] / rises[1])) / (ALLOWED * math.hypot(*errors))
        typical = float(np.sqrt(np.mean(deviations**2)))
        percents = (
            f"{value:.1%}" for value in (differ, typical, deviations.min(), deviations.max())
        )
        row = name, f"{load:g}", f"{velocity:g}", *(f"{rise:.4g} K" for rise in rises)
        ratio = math.nan if scene_is_local(name) else typical / differ
        yield (*row, f"{max(errors):.1%}", f"{apart:.2f}", *percents), apart, ratio


def main():
    """Judge the errors of all scenes."""
    parser = argparse.ArgumentParser(description=__doc__, allow_abbrev=False)
    parser.add_argument("--realizations", type=int, default=16)
    options = parser.parse_args()
    rows = [row for name in SCENES for row in rows_of(name, count=options.realizations)]
    agreeing = np.mean([apart <= 1 for _, apart, _ in rows])
    ratios = [ratio for *_, ratio in rows if not math.isnan(ratio)]
    statement = (
        f"two halves of {options.realizations} realizations agree within the stated error at "
        f"{agreeing:.0%} of {len(rows)} positions; a single realization estimates "
        f"{min(ratios):.2g} to {max(ratios):.2g} times the actual standard deviation"
    )
    rows_text = table(HEADS, [row for row, *_ in rows])
    return conclude(
        "realizations",
        f"{rows_text}\n\n{statement}",
        agreeing >= MIN_AGREEING and min(ratios) >= MIN_RATIO and max(ratios) <= MAX_RATIO,
    )


if __name__ == "__main__":
    sys.exit(main())
