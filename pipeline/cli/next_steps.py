"""The next command after a result, in one line, where there is one worth running."""

from __future__ import annotations

import math
import shlex
from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import asdict
from pathlib import Path
from typing import TYPE_CHECKING, Any

from pipeline.analysis.dataset import asked, attributes_of
from pipeline.analysis.transition import ENTRIES
from pipeline.store.schema import DONE, FAILED
from pipeline.sweep.model import Point
from pipeline.sweep.selection import velocity_error

if TYPE_CHECKING:
    import xarray as xr

    from pipeline.analysis.margin import Margin
    from pipeline.sweep.model import Sweep

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
    ds: xr.Dataset, store: Path | str, undecided: Iterable[Margin], judged: Mapping[str, Any]
) -> list[str]:
    """Commands that decide margins within their error, each once; none where nothing is known to.

    A point that was asked for and is not done is run. Any other place that is not computed is
    computed by itself; where it is, or interpolation counts less, a better accuracy decides.
    """
    attributes, undecided = attributes_of(ds), list(undecided)
    words_of = {id(one): _words_of(attributes, one.entries) for one in undecided}
    if None in words_of.values():
        return [*dict.fromkeys(map(_in_python, undecided))]
    commands, sharpest, bound = dict[str, None](), math.inf, velocity_error(attributes)
    for margin in undecided:
        interpolation = margin.error.interpolation
        accuracy = _accuracy_for(bound, margin.distance, margin.error.preset)
        if interpolation is not None and interpolation <= (margin.error.preset or 0.0):
            sharpest = min(sharpest, accuracy or math.inf)
        elif _is_missing(ds, margin):
            commands[more_of_boundary(ds, store, {})] = None
        else:
            # A point does not know how its rise grows, and takes the bound for its own error.
            alone = None if bound is None else bound * _rise_of(margin, judged)
            accuracy = _accuracy_for(bound, margin.distance, alone)
            place = margin.load, margin.velocity, accuracy
            words = {"arguments": words_of[id(margin)]}
            commands[_point(attributes | words, *place, judged, _on(margin.realization))] = None
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
    settings = [] if missing else _settings(attributes.get("conditions") or {}, conditions)
    replaced = tuple(setting[: setting.rindex("=") + 1] for setting in settings)
    words = [word for word in _scene_of(attributes) if not (replaced and word.startswith(replaced))]
    words += [*_accuracy_of(attributes), "-o", str(store)]
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


def _settings(stored: Mapping[str, Any], conditions: Mapping[str, Any]) -> list[str]:
    """Settings of the conditions that differ from those of a store."""
    entries = ENTRIES
    if "disk_temperature" in stored:
        entries = entries | _BULKS
        conditions = {"disk_temperature": conditions["bulk_temperature"], **conditions}
    stored = {"criterion": "share", **stored}
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
    """Accuracy that decides at a distance from severe wear [K]; None if none is better.

    By the error that the bound of the boundary velocity makes of the temperature [K].
    """
    if bound is None or error is None:
        return _ACCURACIES[1]
    enough = bound * abs(distance) / error if error else bound
    better = [accuracy for accuracy in _ACCURACIES if accuracy < bound]
    finest = better[-1] if better else None
    return next((accuracy for accuracy in better if accuracy < enough), finest)


def _rise_of(margin: Margin, judged: Mapping[str, Any]) -> float:
    """Rise of the deciding temperature above the colder body [K]."""
    bulks = (judged.get(name) for name in _BULKS)
    return margin.decisive_temperature - float(min(bulk for bulk in bulks if bulk is not None))


def fidelity_of(sweep: Sweep) -> dict[str, Any]:
    """What `velocity_error` takes of the attributes of a store, of a sweep that has none yet."""
    selection = sweep.about.selection
    return {
        "preset": sweep.about.preset,
        "selection": selection.as_dict() if selection else None,
        "scene": {"fidelity": asdict(sweep.scene.fidelity)},
    }


def point_that_decides(
    sweep: Sweep,
    load: float,
    velocity: float,
    realization: int | None,
    distance: float,
    rise: float,
    given: Iterable[str],
) -> list[str]:
    """Command that computes a point that is not decided more accurately; none if nothing is.

    Its distance from severe wear and its rise are in K; ``given`` are the names of conditions that
    are not the scene's own.
    """
    bound = velocity_error(fidelity_of(sweep))
    accuracy = _accuracy_for(bound, distance, None if bound is None else bound * rise)
    if accuracy is None:
        return []
    conditions = sweep.conditions.as_dict()
    others = {*given, *(["disk_temperature"] if "bulk_temperature" in given else [])}
    names = {"failing_share": "share"}
    own = {name: value for name, value in conditions.items() if names.get(name, name) not in others}
    about = {"arguments": list(sweep.about.arguments), "name": sweep.about.name, "conditions": own}
    return [_point(about, load, velocity, accuracy, conditions, _on(realization))]


def _is_missing(ds: xr.Dataset, margin: Margin) -> bool:
    """An operating point of the grid that the store was asked for, and that is not done."""
    waits = asked(ds) & (ds["status"] != DONE)
    here = (ds["load"] == margin.load) & (ds["velocity"] == margin.velocity)
    return bool((waits & here).any())


def _point(
    attributes: Mapping[str, Any],
    load: float,
    velocity: float,
    accuracy: float | None,
    judged: Mapping[str, Any],
    surface: Iterable[str] = (),
) -> str:
    """Command that computes an operating point by itself."""
    place = [f"--load={load:.6g} N", f"--velocity={velocity:.6g} m/s"]
    settings = _settings(attributes.get("conditions") or {}, judged)
    scene = _scene_of(attributes)
    if accuracy is not None:
        scene, place = _without_preset(scene), [*place, f"--accuracy={100 * accuracy:g}%"]
    return shlex.join(["irg", "point", *scene, *surface, *place, *settings])


def _on(seed: int | None) -> list[str]:
    """Option of a random surface."""
    return [] if seed is None else [f"--realization={seed}"]


def _words_of(
    attributes: Mapping[str, Any], entries: Mapping[str, float | str]
) -> list[str] | None:
    """Arguments that read the scene of a row of a table; None where none do, as of one by hand."""
    rows, own = attributes.get("scenes") or (), dict[str, Any]()
    for row in rows:
        if row["values"] == [*entries.values()]:
            own = row["attributes"]
    words = _scene_of({**attributes, **own})
    return words if "arguments" in own or not entries else None


def _in_python(margin: Margin) -> str:
    """What decides at a row that no scene file has."""
    place = Point(margin.load, margin.velocity, tuple(margin.entries.items()))
    return f"{place}, more accurately, in Python, since no scene file has this row"


def _scene_of(attributes: Mapping[str, Any]) -> list[str]:
    """Arguments that read the scene of a store, but for a permission that it might give itself."""
    words = attributes.get("arguments") or [f"{attributes.get('name')}.toml"]
    return [word for word in words if not word.startswith("--own")]


def _accuracy_of(attributes: Mapping[str, Any]) -> list[str]:
    """Option with the accuracy that the fidelity of a store was picked for, if it was."""
    selection = attributes.get("selection")
    return [f"--accuracy={selection['accuracy']:g}"] if selection else []


def _without_preset(words: Iterable[str]) -> list[str]:
    return [word for word in words if not word.startswith(("--preset=", "--set=preset="))]


def _more_accurate(attributes: Mapping[str, Any], store: Path | str, accuracy: float) -> str:
    out = str(store).removesuffix(".zarr") + "_accurate.zarr"
    words = _without_preset(_scene_of(attributes))
    return shlex.join(["irg", "run", *words, f"--accuracy={100 * accuracy:g}%", "-o", out])
