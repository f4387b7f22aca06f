"""The command that finds the boundary: as a document and in words."""

from __future__ import annotations

import argparse
import math
from collections.abc import Callable, Iterator
from typing import Any

import numpy as np
import xarray as xr

import pipeline
from pipeline.analysis.attributes import attributes_of
from pipeline.analysis.boundary_tables import (
    BOUNDARIES,
    by_friction,
    frictions_of,
    readable,
    tables_of,
)
from pipeline.analysis.transition import BEYOND, OUTCOMES, UNKNOWN, command_of
from pipeline.cli.next_steps import after_boundary
from pipeline.cli.output import Result, to_table
from pipeline.cli.scenes import CONDITIONS, given, opened
from pipeline.cli.unknowns import boundary_of_samples
from tribo import lubrication_regime
from tribo.lubricant import BOUNDARY, FULL_FILM

SLOW = 0.4  # exponent of the rise over the velocity, below which its errors are said to count more


@to_table
def boundary(options: argparse.Namespace) -> Result:
    """Print critical velocities and loads."""
    ds, conditions = opened(options), given(options, *CONDITIONS)
    if "sample" in ds.dims:
        return boundary_of_samples(ds, conditions)
    crossings = pipeline.boundary(ds, **conditions)
    command = command_for(crossings, options.store, ds)
    text = [*text_of(crossings, command), *after_boundary(attributes_of(ds), options.store)]
    warned = pipeline.warned(ds, **conditions)
    document = document_of(crossings) | {"command": command}
    return Result(document, text, warned, tables_of(crossings))


def document_of(crossings: xr.Dataset) -> dict[str, Any]:
    """Plain data of `pipeline.boundary`, under its names; outcomes and regimes in words."""
    names = (
        "bulk_temperature", "disk_temperature", "critical_temperature", "failing_share",
        "wear_rate",
    )  # fmt: skip
    conditions = {name: crossings.attrs[name] for name in names if name in crossings.attrs}
    frictions = frictions_of(crossings)
    conditions["criterion"] = crossings.attrs["criterion"]
    conditions["friction"] = frictions if "friction" in crossings.sizes else frictions[0]
    document = {str(name): values.values.tolist() for name, values in crossings.variables.items()}
    for _, axis in BOUNDARIES:
        outcome, film = f"outcome_at_{axis}", f"film_parameter_at_{axis}"
        document[outcome] = _nested(OUTCOMES.__getitem__, document[outcome])
        if film in document:
            document[f"regime_at_{axis}"] = _nested(_regime, document[film])
    missing = crossings.attrs["missing_points"]
    return {"conditions": conditions, "missing_points": missing, **document}


def _nested(write: Callable[[Any], str], values: Any) -> Any:
    """Values in words, in lists as deep as theirs."""
    if isinstance(values, list):
        return [_nested(write, value) for value in values]
    return write(values)


def _regime(film_parameter: float) -> str:
    return lubrication_regime(film_parameter) if math.isfinite(film_parameter) else "no crossing"


def command_for(crossings: xr.Dataset, store: Any, ds: xr.Dataset) -> str | None:
    """The command that computes transitions beyond the computed points; None if there are none."""
    beyond = [
        friction
        for friction, part in by_friction(crossings)
        if part["outcome_at_load"].isin((*BEYOND, UNKNOWN)).any()
    ]
    if not beyond:
        return None
    is_pending = bool(crossings.attrs["missing_points"])
    return command_of(
        store, attributes_of(ds), crossings.attrs | {"friction": beyond[0]}, is_pending
    )


def text_of(crossings: xr.Dataset, command: str | None = None) -> Iterator[str]:
    """Lines of text on a boundary; the command computes points that it lacks, if any."""
    yield ", ".join(_conditions(crossings))
    for table in readable(crossings):
        yield ""
        yield from table.lines()
    yield from _slow_rise(crossings)
    if "film_parameter_at_load" in crossings:
        yield ""
        yield (
            "Λ is the minimum film over Rq, at the bulk temperature and the unworn radius: below "
            f"{BOUNDARY:g} boundary lubrication, below {FULL_FILM:g} mixed, above it a full film, "
            "which the model does not have"
        )
    if missing := crossings.attrs["missing_points"]:
        yield ""
        yield f"{missing} points are pending or failed and were left out"
    if command:
        yield ""
        yield f"compute more of the boundary with: {command}"


def _slow_rise(crossings: xr.Dataset) -> Iterator[str]:
    """Loads at which the rise grows so slowly that an error of it moves the boundary far more."""
    exponents = np.moveaxis(crossings["rise_exponent_at_load"].values, -1, 0).reshape(
        crossings.sizes["load"], -1
    )
    slow = {
        float(load): float(np.nanmedian(row))
        for load, row in zip(crossings["load"].values, exponents, strict=True)
        if not np.isnan(row).all() and np.nanmedian(row) < SLOW
    }
    if slow:
        yield ""
        yield (
            f"at {', '.join(f'{load:g}' for load in slow)} N the rise grows slowly with the "
            "velocity: an error of 1 % of it moves the critical velocity by up to "
            f"{1 / max(min(slow.values()), 0.01):.2g} %"
        )


def _conditions(crossings: xr.Dataset) -> Iterator[str]:
    """Conditions by which wear is judged, in words."""
    judged = crossings.attrs
    yield "friction " + ", ".join(f"{value:g}" for value in frictions_of(crossings))
    bulk = f"bulk {pipeline.display(judged['bulk_temperature'], '°C')}"
    if "disk_temperature" in judged:
        bulk += f" (pin) and {pipeline.display(judged['disk_temperature'], '°C')} (disk)"
    yield bulk
    yield f"critical {pipeline.display(judged['critical_temperature'], '°C')}"
    is_share = judged["criterion"] == "share"
    yield (
        f"failing share {judged['failing_share']:g}"
        if is_share
        else f"criterion {judged['criterion']}"
    )
    if "wear_rate" in judged:
        yield f"wear rate {pipeline.display(judged['wear_rate'], 'mm³/(N m)')}"
