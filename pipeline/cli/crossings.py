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


def document_of(found: xr.Dataset) -> dict[str, Any]:
    """Plain data of `pipeline.boundary`, under its names; outcomes and regimes in words."""
    names = (
        "bulk_temperature", "disk_temperature", "critical_temperature", "failing_share",
        "wear_rate",
    )  # fmt: skip
    conditions = {name: found.attrs[name] for name in names if name in found.attrs}
    frictions = frictions_of(found)
    conditions["criterion"] = found.attrs["criterion"]
    conditions["friction"] = frictions if "friction" in found.sizes else frictions[0]
    document = {str(name): values.values.tolist() for name, values in found.variables.items()}
    for _, axis in BOUNDARIES:
        outcome, film = f"outcome_at_{axis}", f"film_parameter_at_{axis}"
        document[outcome] = _nested(OUTCOMES.__getitem__, document[outcome])
        if film in document:
            document[f"regime_at_{axis}"] = _nested(_regime, document[film])
    missing = found.attrs["missing_points"]
    return {"conditions": conditions, "missing_points": missing, **document}


def _nested(write: Callable[[Any], str], values: Any) -> Any:
    """Values in words, in lists as deep as theirs."""
    if isinstance(values, list):
        return [_nested(write, value) for value in values]
    return write(values)


def _regime(film_parameter: float) -> str:
    return lubrication_regime(film_parameter) if math.isfinite(film_parameter) else "no crossing"


def command_for(found: xr.Dataset, store: Any, ds: xr.Dataset) -> str | None:
    """The command that computes transitions beyond what was computed; None where there are none."""
    beyond = [
        friction
        for friction, part in by_friction(found)
        if part["outcome_at_load"].isin((*BEYOND, UNKNOWN)).any()
    ]
    if not beyond:
        return None
    is_pending = bool(found.attrs["missing_points"])
    return command_of(store, attributes_of(ds), found.attrs | {"friction": beyond[0]}, is_pending)


def text_of(found: xr.Dataset, command: str | None = None) -> Iterator[str]:
    """Lines of text on `pipeline.boundary`.

    The command computes points that it lacks, if any.
    """
    frictions = ", ".join(f"{value:g}" for value in frictions_of(found))
    if "sample" in found.sizes:
        yield "each sample under its own inputs as drawn, the others as here:"
    yield (
        f"friction {frictions}, "
        f"bulk {_bulk(found)}, "
        f"critical {pipeline.display(found.attrs['critical_temperature'], '°C')}, "
        + (
            f"failing share {found.attrs['failing_share']:g}"
            if found.attrs["criterion"] == "share"
            else f"criterion {found.attrs['criterion']}"
        )
        + (
            f", wear rate {pipeline.display(found.attrs['wear_rate'], 'mm³/(N m)')}"
            if "wear_rate" in found.attrs
            else ""
        )
    )
    for table in readable(found):
        yield ""
        yield from table.lines()
    yield from _slow_rise(found)
    if "film_parameter_at_load" in found:
        yield ""
        yield (
            "Λ is the minimum film over Rq, at the bulk temperature and the unworn radius: below "
            f"{BOUNDARY:g} boundary lubrication, below {FULL_FILM:g} mixed, above it a full film, "
            "which the model does not have"
        )
    if missing := found.attrs["missing_points"]:
        yield ""
        yield f"{missing} points are pending or failed and were left out"
    if command:
        yield ""
        yield f"compute more of the boundary with: {command}"


def _slow_rise(found: xr.Dataset) -> Iterator[str]:
    """Say where the rise grows so slowly that an error of it moves the boundary by much more."""
    exponents = np.moveaxis(found["rise_exponent_at_load"].values, -1, 0).reshape(
        found.sizes["load"], -1
    )
    slow = {
        float(load): float(np.nanmedian(row))
        for load, row in zip(found["load"].values, exponents, strict=True)
        if not np.isnan(row).all() and np.nanmedian(row) < SLOW
    }
    if slow:
        yield ""
        yield (
            f"at {', '.join(f'{load:g}' for load in slow)} N the rise grows slowly with the "
            "velocity: an error of 1 % of it moves the critical velocity by up to "
            f"{1 / max(min(slow.values()), 0.01):.2g} %"
        )


def _bulk(found: xr.Dataset) -> str:
    """The bulk temperature, or that of each body."""
    pin = pipeline.display(found.attrs["bulk_temperature"], "°C")
    if "disk_temperature" not in found.attrs:
        return pin
    return f"{pin} (pin) and {pipeline.display(found.attrs['disk_temperature'], '°C')} (disk)"
