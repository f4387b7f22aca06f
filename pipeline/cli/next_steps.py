"""The next command after a result, in one line, where there is one worth running."""

from __future__ import annotations

import shlex
from collections.abc import Collection, Iterable, Iterator, Mapping, Sequence
from pathlib import Path
from typing import Any

import xarray as xr

from pipeline.analysis.dataset import asked, scene_sweep
from pipeline.analysis.margin import Margin
from pipeline.quantities import display
from pipeline.store.schema import DONE, FAILED
from pipeline.sweep.accuracy import velocity_error
from pipeline.sweep.conditions import FIELDS
from pipeline.sweep.model import Point, Sweep

_COARSE = 0.05  # error of the boundary velocity from which a table is no more than a first look
_ACCURACIES = (0.05, 0.02, 0.01)  # that are suggested, of the boundary velocity
_MOST = 5  # commands that are printed
_BULKS = {
    "bulk_temperature": "temperature.bulk.pin",
    "disk_temperature": "temperature.bulk.disk",
}


def after_boundary(sweep: Sweep, store: Path | str) -> Iterator[str]:
    """Command for a boundary of a higher accuracy, where that of the preset is low."""
    bound = velocity_error(sweep)
    if bound and bound > _COARSE and not sweep.about.selection:
        yield (
            f"preset {sweep.about.preset}: velocities may err by up to {100 * bound:g} %, "
            f"as irg trade measures on a scene; next: {_more_accurate(sweep, store, 0.02)}"
        )


def command_that_decides(
    ds: xr.Dataset, store: Path | str, margin: Margin, judged: Mapping[str, Any]
) -> str | None:
    """Command that decides a margin within its error; None if none is known to.

    A point that was asked for and is not done is run. Any other place that is not computed is
    computed by itself; where it is, or interpolation counts less, a better accuracy decides.
    """
    sweep = scene_sweep(ds)
    bound = velocity_error(sweep)
    if sweep.variants.draw:
        better = [accuracy for accuracy in _ACCURACIES if bound is None or accuracy < bound]
        return _more_accurate(sweep, store, better[0]) if better else None
    row = _row_sweep(sweep, margin.entries)
    if row is None:
        place = Point(margin.load, margin.velocity, tuple(margin.entries.items()))
        return f"{place}, more accurately, in Python, since no scene file has this row"
    interpolation, preset = margin.error.interpolation, margin.error.preset
    if interpolation is not None and interpolation <= (preset or 0.0):
        accuracy = _accuracy_for(bound, margin.distance, preset)
        return _more_accurate(sweep, store, accuracy) if accuracy else None
    here = (ds["load"] == margin.load) & (ds["velocity"] == margin.velocity)
    if (asked(ds) & (ds["status"] != DONE) & here).any():
        return more_of_boundary(ds, store, {})
    # A point does not know how its rise grows, and takes the bound for its own error.
    bulks = [bulk for name in _BULKS if (bulk := judged.get(name)) is not None]
    rise = margin.decisive_temperature - float(min(bulks))
    accuracy = _accuracy_for(bound, margin.distance, None if bound is None else bound * rise)
    return _point(row, margin, None, accuracy, judged)


def lines_on(commands: Sequence[str], by_model: bool) -> Iterator[str]:
    """Lines on the commands that decide what is not decided, if not the model leaves it open."""
    if by_model:
        yield (
            "no computation decides this, because of the model's own error: test there, or state "
            "that error by [model] scatter"
        )
        return
    for command in commands[:_MOST]:
        yield f"not decided; next: {command}"
    if more := len(commands[_MOST:]):
        yield f"and {more} more commands, which --json lists"
    if not commands:
        yield "no accuracy decides this: the point is within its error of the boundary"


def more_of_boundary(ds: xr.Dataset, store: Path | str, conditions: Mapping[str, Any]) -> str:
    """Command that computes more of a boundary under some conditions: first its missing points."""
    sweep = scene_sweep(ds)
    missing = {int(status) for status in ds["status"].values[asked(ds).values]} - {DONE}
    settings = [] if missing else _settings(sweep, conditions)
    replaced = tuple(f"{setting.rpartition('=')[0]}=" for setting in settings if "=" in setting)
    words = [word for word in _arguments(sweep) if not word.startswith(replaced)]
    if sweep.about.selection and (accuracy := sweep.about.selection.accuracy):
        words.append(f"--accuracy={accuracy:g}")
    words += ["-o", str(store)]
    if sweep.plane.chosen is not None or not missing:
        words.append("--boundary-only")
    if FAILED in missing:
        words.append("--retry-failed")
    return shlex.join(["irg", "run", *words, *settings])


def point_that_decides(
    sweep: Sweep, place: Point, seed: int | None, distance: float, rise: float, given: Iterable[str]
) -> list[str]:
    """Command that computes a point of a scene more accurately to decide it; none if nothing does.

    Its distance from severe wear and its rise are in K; ``given`` are the names of conditions that
    are not the scene's own.
    """
    bound, conditions = velocity_error(sweep), sweep.conditions.as_dict()
    accuracy = _accuracy_for(bound, distance, None if bound is None else bound * rise)
    entries = {"share": ("failing_share",), "bulk_temperature": tuple(_BULKS)}
    others = {entry for name in given for entry in entries.get(name, (name,))}
    return [] if accuracy is None else [_point(sweep, place, seed, accuracy, conditions, others)]


def _settings(
    sweep: Sweep, conditions: Mapping[str, Any], given: Collection[str] = ()
) -> list[str]:
    """Settings of the conditions that differ from those of a sweep, or are given anew."""
    stored, entries = sweep.conditions.as_dict(), FIELDS
    stored = {name: value for name, value in stored.items() if name not in given}
    if "disk_temperature" in stored:
        entries = entries | _BULKS
        conditions = {"disk_temperature": conditions["bulk_temperature"], **conditions}
    settings = []
    for name, entry in entries.items():
        value = conditions.get(name)
        if value is not None and stored.get(name) != value:
            text = value if isinstance(value, str) else repr(float(value))
            if name.endswith("temperature"):
                text = display(value, "degC")
            settings.append(f"--set={entry}={text}")
            if name == "criterion" and ":" in text:
                settings.append("--own-laws")
    return settings


def _accuracy_for(bound: float | None, distance: float, error: float | None) -> float | None:
    """Accuracy that decides at a distance [K], by the error [K] of the bound; None if none."""
    if bound is None or error is None:
        return _ACCURACIES[1]
    enough = bound * abs(distance) / error if error else bound
    better = [accuracy for accuracy in _ACCURACIES if accuracy < bound]
    finest = better[-1] if better else None
    return next((accuracy for accuracy in better if accuracy < enough), finest)


def _point(
    sweep: Sweep,
    place: Margin | Point,
    seed: int | None,
    accuracy: float | None,
    judged: Mapping[str, Any],
    given: Collection[str] = (),
) -> str:
    """Command that computes an operating point by itself."""
    words = _arguments(sweep) if accuracy is None else _dropped_preset(sweep)
    words += [] if seed is None else [f"--realization={seed}"]
    words += [f"--load={place.load:.6g} N", f"--velocity={place.velocity:.6g} m/s"]
    words += [] if accuracy is None else [f"--accuracy={100 * accuracy:g}%"]
    return shlex.join(["irg", "point", *words, *_settings(sweep, judged, given)])


def _more_accurate(sweep: Sweep, store: Path | str, accuracy: float) -> str:
    """Command that computes a sweep anew to an accuracy, beside its store."""
    out = str(store).removesuffix(".zarr") + "_accurate.zarr"
    words = [*_dropped_preset(sweep), f"--accuracy={100 * accuracy:g}%", "-o", out]
    return shlex.join(["irg", "run", *words])


def _arguments(sweep: Sweep) -> list[str]:
    """Arguments that read the scene of a store, without `--own-laws`."""
    words = sweep.about.arguments or (f"{sweep.about.name}.toml",)
    return [word for word in words if not word.startswith("--own")]


def _dropped_preset(sweep: Sweep) -> list[str]:
    flags = "--preset=", "--set=preset="
    return [word for word in _arguments(sweep) if not word.startswith(flags)]


def _row_sweep(sweep: Sweep, entries: Mapping[str, float | str]) -> Sweep | None:
    """The sweep of a row of a table; None where no scene file has the row, as one by hand."""
    name = tuple(entries.items())
    if name not in sweep.variants.given or not name:
        return sweep
    return sweep.below(name) if "arguments" in dict(sweep.variants.part(name)) else None
