"""Data frames of a boundary, and of a laboratory's tests beside it."""

from __future__ import annotations

import functools
from collections import Counter
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import replace
from typing import Any

import numpy as np
import pandas as pd
import xarray as xr

from pipeline.analysis.dataset import entry_dims, plane_of, stored_sweep, variant_of
from pipeline.analysis.decisive import conditions_of
from pipeline.analysis.margin import NOT_DECIDED, Margin
from pipeline.analysis.margins import notes_of, rows_under
from pipeline.analysis.scenes import frame_by_scene, heads_of, parts_of, planes
from pipeline.analysis.tables import frame_of, short
from pipeline.analysis.transition import CROSSES, UNITS, in_words, outcomes
from pipeline.sweep.conditions import Conditions
from tribo import InputError
from tribo.material import BOUNDARY, FULL_FILM

BOUNDARIES = (("critical_velocity", "load"), ("critical_load", "velocity"))
"""Variables of a boundary, each with the axis that it is found along."""
JUDGED = {
    "bulk_temperature": "bulk temperature [°C]",
    "disk_temperature": "disk temperature [°C]",
    "critical_temperature": "critical temperature [°C]",
    "failing_share": "failing share",
    "criterion": "criterion",
}
"""Heads of the conditions that wear is judged by."""


def frames_of(boundaries: xr.Dataset) -> tuple[pd.DataFrame, ...]:
    """Frames of `pipeline.boundary`: critical velocities by load, critical loads by velocity."""
    return tuple(_along(boundaries, *ends) for ends in BOUNDARIES)


def on_boundary(boundaries: xr.Dataset) -> Iterator[str | pd.DataFrame]:
    """The frames of a boundary, what its film means, and how many points it lacks."""
    alone = ["friction"] if len(frictions_of(boundaries)) == 1 else []
    for frame in frames_of(boundaries):
        yield short(frame, [*alone, *JUDGED.values()])
    if "film_parameter_at_load" in boundaries:
        yield (
            "Λ is the minimum film over Rq, at the bulk temperature and the unworn radius: below "
            f"{BOUNDARY:g} boundary lubrication, below {FULL_FILM:g} mixed, above it a full film, "
            "which the model does not have"
        )
    if missing := missing_points(boundaries):
        yield f"{missing} points are pending or failed and were left out"


def missing_points(boundaries: xr.Dataset) -> int:
    """Number of pending and failed points, of all scenes."""
    return sum(part.attrs["missing_points"] for _, part in parts_of(boundaries))


def _along(boundaries: xr.Dataset, name: str, axis: str) -> pd.DataFrame:
    """Frame along one axis."""
    variant = variant_of(boundaries)
    columns = _surface if variant is None else _band
    values = dict(columns(boundaries, name, axis))
    if (film := f"film_parameter_at_{axis}") in boundaries:
        over = boundaries[film]
        values["film parameter Λ"] = over.median(variant) if variant else over
    frictions = ["friction"] if "friction" in boundaries.sizes else []
    dims = [*entry_dims(boundaries[name]), *frictions, axis]
    crossings = xr.Dataset({head: held.drop_attrs() for head, held in values.items()})
    frame = crossings.to_dataframe(dims).reset_index()
    for judged in ("friction", *JUDGED):
        if judged not in frame:
            frame[judged] = boundaries.attrs.get(judged)
    heads = heads_of(boundaries[name]) | {axis: f"{axis} [{UNITS[axis]}]"} | JUDGED
    names = [*dict.fromkeys([*dims[:-1], "friction", axis, *values, *JUDGED])]
    rows = frame[names].itertuples(index=False, name=None)
    return frame_of([heads.get(column, column) for column in names], rows)


def _surface(boundaries: xr.Dataset, name: str, axis: str) -> Iterator[tuple[str, xr.DataArray]]:
    """Crossings of one surface, by their heads."""
    other = name.removeprefix("critical_")
    parts = "outcome", "computed_from", "computed_to"
    codes, *ends = (boundaries[f"{part}_at_{axis}"] for part in parts)
    worded = np.vectorize(
        lambda code, *ends: in_words(outcomes(other)[code], ends, other), otypes=[object]
    )
    bridged = boundaries[f"bridged_at_{axis}"]
    yield f"critical {other} [{UNITS[other]}]", boundaries[name]
    yield "outcome", xr.apply_ufunc(worded, codes, *ends)
    yield "points not done beside it", bridged.where(bridged > 0)


def _band(boundaries: xr.Dataset, name: str, axis: str) -> Iterator[tuple[str, xr.DataArray]]:
    """Median, ends of the band, mean and spread of several surfaces, and how many of them cross."""
    other, variant = name.removeprefix("critical_"), str(variant_of(boundaries))
    unit, codes = UNITS[other], boundaries[f"outcome_at_{axis}"]
    band = boundaries[f"{name}_quantile"]
    heads = [f"{100 * share:g} %" for share in band["quantile"].values]
    heads[1] = f"critical {other}, median"
    for place in (1, 0, 2):
        yield f"{heads[place]} [{unit}]", band.isel(quantile=place, drop=True)
    for moment in ("mean", "spread"):
        yield f"{moment} [{unit}]", boundaries[f"{name}_{moment}"]
    yield "surfaces", xr.full_like(codes, 1).sum(variant)
    for code, words in outcomes(other).items():
        if code == CROSSES or (codes == code).any():
            yield "cross" if code == CROSSES else words, (codes == code).sum(variant)
    bridged = (boundaries[f"bridged_at_{axis}"] > 0).sum(variant)
    yield "of them across points not done", bridged.where(bridged > 0)


def frictions_of(boundaries: xr.Dataset) -> list[float]:
    """Frictions that a boundary was found at, in the order in which they were given."""
    if "friction" in boundaries.attrs:
        return [boundaries.attrs["friction"]]
    return list(dict.fromkeys(boundaries["friction"].values.ravel().tolist()))


def by_friction(boundaries: xr.Dataset) -> Iterator[tuple[float, xr.Dataset]]:
    """The boundary at each friction."""
    if "friction" not in boundaries.sizes:
        yield boundaries.attrs["friction"], boundaries
        return
    for place, value in enumerate(boundaries["friction"].values.tolist()):
        yield value, boundaries.isel(friction=place)


NOT_KNOWN = "not known"
USUAL_SCATTER = 0.05
"""Relative standard deviation of the velocity of a transition that gives none."""
_DEVIATIONS = 2.0  # of a measured velocity, within which a transition agrees
_HEADS = (
    "test", "load [N]", "velocity [m/s]", "friction", "bulk temperature [°C]", "hold [s]",
    "computed", "decisive temperature [°C]", "agrees", "note",
)  # fmt: skip


def laboratory_tests(ds: xr.Dataset) -> list[dict[str, Any]]:
    """Measured transitions of a sweep, and then its tests."""
    about = stored_sweep(ds).about
    return [test.as_dict() for test in (*about.measured, *about.tested)]


def own_conditions(ds: xr.Dataset, conditions: Conditions, test: Mapping[str, Any]) -> Conditions:
    """Conditions of a test: friction and bulk of its own or the scene, not those judged by."""
    stored = stored_sweep(ds).conditions
    bulks: dict[str, Any] = {
        body: getattr(stored, body) for body in ("bulk_temperature", "disk_temperature")
    }
    if test.get("bulk_temperature") is not None:
        bulks = {"bulk_temperature": test["bulk_temperature"], "disk_temperature": None}
    own = replace(conditions, friction=stored.friction, **bulks)
    return own.at_friction(test.get("friction"))


def compared(ds: xr.Dataset, **conditions: Any) -> pd.DataFrame | None:
    """Frame of tests beside what is computed at their own conditions; None if there are none."""
    tests = laboratory_tests(ds)
    if not (tests and planes(ds)):
        return None
    return frame_by_scene(ds, lambda scene: frame_of(_HEADS, _rows(scene, conditions)))


def agreement(frame: pd.DataFrame) -> str:
    """Count of tests that agree, in a sentence."""
    counts = Counter(frame["agrees"])
    words = {
        "yes": ("agrees", "agree"),
        "no": ("does not", "do not"),
        NOT_DECIDED: ("is not decided", "are not decided"),
        NOT_KNOWN: ("is not known", "are not known"),
    }
    said = (f"{counts[key]} {pair[counts[key] > 1]}" for key, pair in words.items() if counts[key])
    return f"Of {len(frame)} tests {', '.join(said)}."


def on_tests(frame: pd.DataFrame) -> Iterator[str | pd.DataFrame]:
    """The count of tests that agree, their frame, and why others are not known."""
    yield agreement(frame)
    yield short(frame, ["note"])
    yield from notes_of(frame)
    yield (
        f"each at its own friction and bulk; a transition agrees within {_DEVIATIONS:g} "
        f"standard deviations of its velocity, {100 * USUAL_SCATTER:g} % each if it gives none, a "
        "test if its outcome is the computed one beyond the error of the temperature"
    )


def _rows(ds: xr.Dataset, changed: Mapping[str, Any]) -> Iterator[tuple[Any, ...]]:
    """Rows of one scene."""
    plane, conditions = plane_of(ds), conditions_of(ds, **changed)
    rows_by = functools.cache(lambda judged: tuple(rows_under(plane, judged)))
    held = getattr(stored_sweep(ds).scene.loading, "hold", 0.0)
    for test in laboratory_tests(ds):
        place = test["normal_load"], test["velocity"]
        hold = test.get("hold")
        note = "" if hold in (None, held) else f"computed with the hold of the scene, {held:g} s"
        at = test.get("friction"), test.get("bulk_temperature")
        try:
            own = own_conditions(ds, conditions, test)
            at = own.friction, own.bulk_temperature
            margins = [row.at(*place) for row in rows_by(own)]
            computed, temperature, agrees = _answer(test, margins)
        except InputError as error:
            computed, temperature, agrees, note = NOT_KNOWN, None, NOT_KNOWN, str(error)
        kind = test.get("outcome") or "transition"
        yield (kind, *place, *at, hold, computed, temperature, agrees, note)


def _answer(test: Mapping[str, Any], margins: Sequence[Margin]) -> tuple[str, float, str]:
    """What is computed at a test, the deciding temperature [K], and whether it agrees."""
    temperature = float(np.median([margin.decisive_temperature for margin in margins]))
    verdicts = Counter(margin.verdict for margin in margins)
    verdict = next(iter(verdicts)) if len(verdicts) == 1 else NOT_DECIDED
    if outcome := test.get("outcome"):
        said = verdict
        if len(verdicts) > 1:
            said = f"severe on {verdicts['severe']} of {len(margins)} surfaces"
        agrees = NOT_DECIDED if verdict == NOT_DECIDED else "yes" if verdict == outcome else "no"
        return said, temperature, agrees
    critical = float(np.median([margin.critical_velocity for margin in margins]))
    scatter = test.get("velocity_scatter") or USUAL_SCATTER * test["velocity"]
    near = abs(critical - test["velocity"]) <= _DEVIATIONS * scatter
    said = f"at {critical:.3g} m/s" if np.isfinite(critical) else verdict
    if any(margin.temperature_error is None for margin in margins):
        return said, temperature, NOT_DECIDED
    away = NOT_DECIDED if verdict == NOT_DECIDED else "no"
    return said, temperature, "yes" if near else away
