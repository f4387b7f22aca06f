"""A boundary as a document and in words, as ``irg boundary`` prints it."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator
from typing import Any

import numpy as np
import xarray as xr

import pipeline
from pipeline.analysis.attributes import attributes_of
from pipeline.analysis.boundary_tables import BOUNDARIES, by_friction, frictions_of, readable
from pipeline.analysis.transition import (
    BEYOND,
    OUTCOMES,
    UNKNOWN,
    command_of,
)
from tribo import lubrication_regime
from tribo.lubricant import BOUNDARY, FULL_FILM

SLOW = 0.4  # exponent of the rise over the velocity, below which its errors are said to count more


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
    """The command that computes transitions beyond what was computed; None where there are none."""
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
    """Lines of text on `pipeline.boundary`.

    The command computes points that it lacks, if any.
    """
    frictions = ", ".join(f"{value:g}" for value in frictions_of(crossings))
    if "sample" in crossings.sizes:
        yield "each sample under its own inputs as drawn, the others as here:"
    yield (
        f"friction {frictions}, "
        f"bulk {_bulk(crossings)}, "
        f"critical {pipeline.display(crossings.attrs['critical_temperature'], '°C')}, "
        + (
            f"failing share {crossings.attrs['failing_share']:g}"
            if crossings.attrs["criterion"] == "share"
            else f"criterion {crossings.attrs['criterion']}"
        )
        + (
            f", wear rate {pipeline.display(crossings.attrs['wear_rate'], 'mm³/(N m)')}"
            if "wear_rate" in crossings.attrs
            else ""
        )
    )
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
    """Say where the rise grows so slowly that an error of it moves the boundary by much more."""
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


def _bulk(crossings: xr.Dataset) -> str:
    """The bulk temperature, or that of each body."""
    pin = pipeline.display(crossings.attrs["bulk_temperature"], "°C")
    if "disk_temperature" not in crossings.attrs:
        return pin
    return f"{pin} (pin) and {pipeline.display(crossings.attrs['disk_temperature'], '°C')} (disk)"
