"""The command that finds the boundary: as a document and in words."""

from __future__ import annotations

import argparse
import math
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd
import xarray as xr

import pipeline
from pipeline.analysis.boundary_tables import (
    BOUNDARIES,
    JUDGED,
    by_friction,
    frames_of,
    frictions_of,
)
from pipeline.analysis.compared import compared, on_tests
from pipeline.analysis.dataset import attributes_of
from pipeline.analysis.scenes import parts_of
from pipeline.analysis.tables import as_dict, short
from pipeline.analysis.transition import BEYOND, CROSSES, UNKNOWN, outcomes
from pipeline.analysis.warned_points import turns_left_out
from pipeline.cli.next_steps import after_boundary, more_of_boundary
from pipeline.cli.output import Result
from pipeline.cli.scenes import by_samples, conditions_in, opened
from pipeline.cli.unknowns import boundary_of_samples
from tribo import lubrication_regime
from tribo.material import BOUNDARY, FULL_FILM

SLOW = 0.4  # exponent of the rise over the velocity, below which its errors are said to count more


def boundary(options: argparse.Namespace) -> Result:
    """Print critical velocities and loads."""
    ds, conditions = opened(options), conditions_in(options)
    if by_samples(options, ds):
        return boundary_of_samples(options, ds, conditions)
    crossings = pipeline.boundary(ds, **conditions)
    command = _command(crossings, options.store, ds)
    cold = turns_left_out(ds, crossings, **conditions)
    not_counted = ["", f"warning: {cold}"] if cold else []
    one = {k: value for k, value in conditions.items() if not isinstance(value, tuple | list)}
    tests = compared(ds, **one)  # of several frictions none is that of a test which gives none
    text = [
        *text_of(crossings, command),
        *not_counted,
        *(["", *on_tests(tests)] if tests is not None else []),
        *after_boundary(attributes_of(ds), options.store),
    ]
    warned = pipeline.warned(ds, **conditions)
    document = document_of(crossings) | {"command": command, "not_counted": cold}
    if tests is not None:
        document["tests"] = as_dict(tests)
    return Result(document, text, warned, frames_of(crossings))


def document_of(crossings: xr.Dataset) -> dict[str, Any]:
    """Plain data of `pipeline.boundary`, under its names; outcomes and regimes in words."""
    document = {str(name): values.values.tolist() for name, values in crossings.variables.items()}
    for name, axis in BOUNDARIES:
        words = outcomes(name.removeprefix("critical_"))
        outcome, film = f"outcome_at_{axis}", f"film_parameter_at_{axis}"
        worded = np.vectorize(words.__getitem__, otypes=[object])(crossings[outcome])
        document[outcome] = worded.tolist()
        if film in document:
            regimes = np.vectorize(_regime, otypes=[object])(crossings[film], crossings[outcome])
            document[f"regime_at_{axis}"] = regimes.tolist()
    document.pop("missing_points", None)
    conditions, missing = _judged_by(crossings), _missing(crossings)
    return {"conditions": conditions, "missing_points": missing, **document}


def _judged_by(crossings: xr.Dataset) -> dict[str, Any]:
    """Conditions, each of which has several values where scenes differ in it."""
    names = (
        "bulk_temperature", "disk_temperature", "critical_temperature", "failing_share",
        "wear_rate", "criterion",
    )  # fmt: skip
    present = {*crossings.attrs, *crossings.coords}
    conditions = {name: _values(crossings, name) for name in names if name in present}
    frictions = frictions_of(crossings)
    return conditions | {"friction": frictions[0] if "friction" in crossings.attrs else frictions}


def _values(crossings: xr.Dataset, name: str) -> Any:
    """A condition: an attribute, or a coordinate where it differs from scene to scene."""
    return crossings.attrs[name] if name in crossings.attrs else crossings[name].values.tolist()


def _missing(crossings: xr.Dataset) -> int:
    """Number of pending and failed points, of all scenes."""
    return int(np.sum(_values(crossings, "missing_points")))


def _regime(film_parameter: float, outcome: int) -> str:
    if math.isfinite(film_parameter):
        return lubrication_regime(film_parameter)
    return "not known" if outcome == CROSSES else "no crossing"


def _command(crossings: xr.Dataset, store: Path | str, ds: xr.Dataset) -> str | None:
    """The command that computes points of the boundary that are missing; None if none are."""
    beyond = [
        scene.attrs | {"friction": friction}
        for _, scene in parts_of(crossings)
        for friction, part in by_friction(scene)
        if part["outcome_at_load"].isin((*BEYOND, UNKNOWN)).any() or part["bridged_at_load"].any()
    ]
    if not beyond:
        return None
    return more_of_boundary(ds, store, beyond[0])


def text_of(crossings: xr.Dataset, command: str | None = None) -> Iterator[str | pd.DataFrame]:
    """Lines of text on a boundary; the command computes points that it lacks, if any."""
    yield ", ".join(_conditions(crossings))
    alone = ["friction"] if len(frictions_of(crossings)) == 1 else []
    for frame in frames_of(crossings):
        yield ""
        yield short(frame, [*alone, *JUDGED.values()])
    yield from _slow_rise(crossings)
    if "film_parameter_at_load" in crossings:
        yield ""
        yield (
            "Λ is the minimum film over Rq, at the bulk temperature and the unworn radius: below "
            f"{BOUNDARY:g} boundary lubrication, below {FULL_FILM:g} mixed, above it a full film, "
            "which the model does not have"
        )
    if missing := _missing(crossings):
        yield ""
        yield f"{missing} points are pending or failed and were left out"
    if command:
        yield ""
        yield f"compute more of the boundary with: {command}"


def _slow_rise(crossings: xr.Dataset) -> Iterator[str]:
    """Loads at which the rise grows so slowly that an error of it moves the boundary far more."""
    exponents = crossings["rise_exponent_at_load"].to_series().groupby("load").median()
    slow = exponents[exponents < SLOW]
    if slow.size:
        yield ""
        yield (
            f"at {', '.join(f'{load:g}' for load in slow.index)} N the rise grows slowly with the "
            "velocity: an error of 1 % of it moves the critical velocity by up to "
            f"{1 / max(slow.min(), 0.01):.2g} %"
        )


def _conditions(crossings: xr.Dataset) -> Iterator[str]:
    """Conditions by which wear is judged, in words."""
    conditions = _judged_by(crossings)

    def worded(name: str, unit: str = "") -> str:
        values = np.unique(conditions[name]).tolist()
        if unit:
            return ", ".join(pipeline.display(value, unit) for value in values)
        return ", ".join(value if isinstance(value, str) else f"{value:g}" for value in values)

    yield "friction " + ", ".join(f"{value:g}" for value in frictions_of(crossings))
    disk = "disk_temperature"
    unequal = f" (pin) and {worded(disk, '°C')} (disk)" if disk in conditions else ""
    yield f"bulk {worded('bulk_temperature', '°C')}{unequal}"
    yield f"critical {worded('critical_temperature', '°C')}"
    criterion = worded("criterion")
    is_share = criterion == "share"
    yield f"failing share {worded('failing_share')}" if is_share else f"criterion {criterion}"
    if "wear_rate" in conditions:
        yield f"wear rate {worded('wear_rate', 'mm³/(N m)')}"
