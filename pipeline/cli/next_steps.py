"""The next command after a result, in one line, where there is one worth running."""

from __future__ import annotations

import math
import shlex
from collections.abc import Iterable, Iterator, Mapping, Sequence
from pathlib import Path
from typing import Any

import xarray as xr

from pipeline.analysis.dataset import asked, attributes_of
from pipeline.analysis.margin import Margin
from pipeline.analysis.transition import ENTRIES
from pipeline.store.schema import DONE, FAILED
from pipeline.sweep.model import Point
from pipeline.sweep.selection import velocity_error

_COARSE = 0.05  # error of the boundary velocity from which a table is no more than a first look
_ACCURACIES = (0.05, 0.02, 0.01)  # that are suggested, of the boundary velocity
_MOST = 5  # commands that are printed
_BULKS = {
    "bulk_temperature": "temperature.bulk.pin",
    "disk_temperature": "temperature.bulk.disk",
}


def after_boundary(attributes: Mapping[str, Any], store: Path | str) -> Iterator[str]:
    """Command for a boundary of a higher accuracy, where that of the preset is low."""
    bound = velocity_error(attributes)
    if bound and bound > _COARSE and not attributes.get("selection"):
        yield (
            f"preset {attributes['preset']}: velocities may err by up to {100 * bound:g} %, "
            f"as irg trade measures on a scene; next: {_more_accurate(attributes, store, 0.02)}"
        )


def commands_that_decide(
    ds: xr.Dataset, store: Path | str, undecided: Sequence[Margin], judged: Mapping[str, Any]
) -> list[str]:
    """Commands that decide margins within their error, each once; none where nothing is known to.

    A point that was asked for and is not done is run. Any other place that is not computed is
    computed by itself; where it is, or interpolation counts less, a better accuracy decides.
    """
    attributes = attributes_of(ds)
    scenes = [_scene_of_row(attributes, margin.entries) for margin in undecided]
    if None in scenes:
        places = (Point(one.load, one.velocity, tuple(one.entries.items())) for one in undecided)
        reason = "more accurately, in Python, since no scene file has this row"
        return [*dict.fromkeys(f"{place}, {reason}" for place in places)]
    waits = asked(ds) & (ds["status"] != DONE)
    commands, sharpest, bound = dict[str, None](), math.inf, velocity_error(attributes)
    for scene, margin in zip(scenes, undecided, strict=True):
        interpolation, preset = margin.error.interpolation, margin.error.preset
        here = (ds["load"] == margin.load) & (ds["velocity"] == margin.velocity)
        if interpolation is not None and interpolation <= (preset or 0.0):
            sharpest = min(sharpest, _accuracy_for(bound, margin.distance, preset) or math.inf)
        elif (waits & here).any():
            commands[more_of_boundary(ds, store, {})] = None
        else:
            # A point does not know how its rise grows, and takes the bound for its own error.
            bulks = [bulk for name in _BULKS if (bulk := judged.get(name)) is not None]
            rise = margin.decisive_temperature - float(min(bulks))
            alone = None if bound is None else bound * rise
            accuracy = _accuracy_for(bound, margin.distance, alone)
            about = attributes | {"arguments": scene}
            commands[_point(about, margin, margin.realization, accuracy, judged)] = None
    if math.isfinite(sharpest):
        commands[_more_accurate(attributes, store, sharpest)] = None
    return list(commands)


def lines_on(commands: Sequence[str]) -> Iterator[str]:
    """Lines on the commands that decide what is not decided."""
    for command in commands[:_MOST]:
        yield f"not decided; next: {command}"
    if more := len(commands[_MOST:]):
        yield f"and {more} more commands, which --json lists"
    if not commands:
        yield "not decided by any accuracy: the point is nearer to the boundary than its error"


def more_of_boundary(ds: xr.Dataset, store: Path | str, conditions: Mapping[str, Any]) -> str:
    """Command that computes more of a boundary under some conditions: first its missing points."""
    attributes = attributes_of(ds)
    missing = {int(status) for status in ds["status"].values[asked(ds).values]} - {DONE}
    settings = [] if missing else _settings(attributes, conditions)
    replaced = tuple(setting[: setting.rindex("=") + 1] for setting in settings)
    words = [word for word in _scene_of(attributes) if not (replaced and word.startswith(replaced))]
    if accuracy := (attributes.get("selection") or {}).get("accuracy"):
        words.append(f"--accuracy={accuracy:g}")
    words += ["-o", str(store)]
    if attributes.get("boundary_only") or not missing:
        words.append("--boundary-only")
    if FAILED in missing:
        words.append("--retry-failed")
    return shlex.join(["irg", "run", *words, *settings])


def next_tests(
    stores: Iterable[Path | str],
    scatter: float | None,
    at: Mapping[str, Any],
    target: str | None = None,
) -> str:
    """Command that ranks tests, of samples weighed in the same way, with the same inputs fixed."""
    words = ["irg", "infer", *map(str, stores), "--next"]
    words += ["--for", target] if target else []
    words += [f"--at={path}={value}" for path, value in at.items()]
    return shlex.join(words if scatter is None else [*words, f"--scatter={scatter:g}"])


def point_that_decides(
    attributes: Mapping[str, Any],
    place: Point,
    seed: int | None,
    distance: float,
    rise: float,
    given: Iterable[str],
) -> list[str]:
    """Command that computes a point of a scene more accurately to decide it; none if nothing does.

    Its distance from severe wear and its rise are in K; ``given`` are the names of conditions that
    are not the scene's own.
    """
    bound, conditions = velocity_error(attributes), attributes["conditions"]
    accuracy = _accuracy_for(bound, distance, None if bound is None else bound * rise)
    entries = {"share": ("failing_share",), "bulk_temperature": tuple(_BULKS)}
    others = {entry for name in given for entry in entries.get(name, (name,))}
    own = {name: value for name, value in conditions.items() if name not in others}
    scene = {**attributes, "conditions": own}
    return [] if accuracy is None else [_point(scene, place, seed, accuracy, conditions)]


def _settings(attributes: Mapping[str, Any], conditions: Mapping[str, Any]) -> list[str]:
    """Settings of the conditions that differ from those of a store."""
    stored, entries = {"criterion": "share", **(attributes.get("conditions") or {})}, ENTRIES
    if "disk_temperature" in stored:
        entries = entries | _BULKS
        conditions = {"disk_temperature": conditions["bulk_temperature"], **conditions}
    settings = []
    for name, entry in entries.items():
        value = conditions.get(name)
        if value is not None and stored.get(name) != value:
            text = value if isinstance(value, str) else repr(float(value))
            if name.endswith("temperature"):
                text = f"{value - 273.15:.6g} degC"
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
    attributes: Mapping[str, Any],
    place: Margin | Point,
    seed: int | None,
    accuracy: float | None,
    judged: Mapping[str, Any],
) -> str:
    """Command that computes an operating point by itself."""
    words = _scene_of(attributes) if accuracy is None else _without_preset(attributes)
    words += [] if seed is None else [f"--realization={seed}"]
    words += [f"--load={place.load:.6g} N", f"--velocity={place.velocity:.6g} m/s"]
    words += [] if accuracy is None else [f"--accuracy={100 * accuracy:g}%"]
    return shlex.join(["irg", "point", *words, *_settings(attributes, judged)])


def _more_accurate(attributes: Mapping[str, Any], store: Path | str, accuracy: float) -> str:
    """Command that computes a sweep anew to an accuracy, beside its store."""
    out = str(store).removesuffix(".zarr") + "_accurate.zarr"
    words = [*_without_preset(attributes), f"--accuracy={100 * accuracy:g}%", "-o", out]
    return shlex.join(["irg", "run", *words])


def _scene_of(attributes: Mapping[str, Any]) -> list[str]:
    """Arguments that read the scene of a store, but for a permission that it might give itself."""
    words = attributes.get("arguments") or [f"{attributes.get('name')}.toml"]
    return [word for word in words if not word.startswith("--own")]


def _without_preset(attributes: Mapping[str, Any]) -> list[str]:
    flags = "--preset=", "--set=preset="
    return [word for word in _scene_of(attributes) if not word.startswith(flags)]


def _scene_of_row(
    attributes: Mapping[str, Any], entries: Mapping[str, float | str]
) -> list[str] | None:
    """Arguments that read the scene of a row of a table; None where none do, as of one by hand."""
    own: Mapping[str, Any] = {}
    for row in attributes.get("scenes") or ():
        if row["values"] == [*entries.values()]:
            own = row["attributes"]
    words = _scene_of({**attributes, **own})
    return words if "arguments" in own or not entries else None
