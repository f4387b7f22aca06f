"""A boundary as a document and in words, as ``irg boundary`` prints it."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator
from typing import Any

import numpy as np
import xarray as xr

import pipeline
from pipeline.analysis.attributes import attributes_of
from pipeline.analysis.band import BAND
from pipeline.analysis.transition import (
    BEYOND,
    CROSSES,
    OUTCOMES,
    UNKNOWN,
    command_of,
    in_words,
)
from tribo import lubrication_regime
from tribo.lubricant import BOUNDARY, FULL_FILM
from tribo.types import Array

_BOUNDARIES = (
    ("critical_velocity", "load", "  load [N]   critical velocity [m/s]"),
    ("critical_load", "velocity", "  velocity [m/s]   critical load [N]"),
)
_ENDS = ("from", "to")
_SLOW = 0.4  # exponent of the rise over the velocity, below which its errors are said to count more
_KINDS = {"realization": "surfaces", "sample": "samples"}


def document_of(found: xr.Dataset) -> dict[str, Any]:
    """Plain data of `pipeline.boundary`, under its names; outcomes and regimes in words."""
    names = ("bulk_temperature", "disk_temperature", "critical_temperature", "failing_share")
    conditions = {name: found.attrs[name] for name in names if name in found.attrs}
    frictions = _frictions(found)
    conditions["criterion"] = found.attrs["criterion"]
    conditions["friction"] = frictions if "friction" in found.sizes else frictions[0]
    document = {str(name): values.values.tolist() for name, values in found.variables.items()}
    for _, axis, _ in _BOUNDARIES:
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


def _variant(found: xr.Dataset) -> str | None:
    """Dimension of the surfaces or samples, if there are several."""
    return next((name for name in _KINDS if name in found.sizes), None)


def rows_of(found: xr.Dataset) -> Iterator[dict[str, Any]]:
    """Rows of a table on `pipeline.boundary`: one for each load and velocity, at each friction."""
    judged = {
        "bulk [°C]": found.attrs["bulk_temperature"] - 273.15,
        **(
            {"disk bulk [°C]": found.attrs["disk_temperature"] - 273.15}
            if "disk_temperature" in found.attrs
            else {}
        ),
        "critical [°C]": found.attrs["critical_temperature"] - 273.15,
        "failing share": found.attrs["failing_share"],
        "criterion": found.attrs["criterion"],
    }
    units = {"load": "load [N]", "velocity": "velocity [m/s]"}
    for name, axis, _ in _BOUNDARIES:
        other = units[name.removeprefix("critical_")]
        for friction, (_, part) in zip(_frictions(found), _by_friction(found), strict=True):
            for place in range(found.sizes[axis]):
                at = part.isel({axis: place})
                row = {"at each": axis, "friction": friction, units[axis]: float(at[axis])}
                yield row | _crossing(at, name, axis, other) | judged


def _crossing(at: xr.Dataset, name: str, axis: str, other: str) -> dict[str, Any]:
    """Crossing at one load or velocity, or those of the surfaces."""
    found: dict[str, Any] = {}
    if variant := _variant(at):
        kind_of = _KINDS[variant]
        outcomes = at[f"outcome_at_{axis}"].values.tolist()
        shares = [f"{100 * share:g} %" for share in at["quantile"].values]
        found = dict(zip(shares, at[f"{name}_quantile"].values.tolist(), strict=True))
        found |= {kind: float(at[f"{name}_{kind}"]) for kind in ("mean", "spread")}
        found |= {f"{kind_of} that cross": outcomes.count(CROSSES), kind_of: len(outcomes)}
        found = {other: float(at[f"{name}_quantile"][BAND.index(0.5)])} | found
    else:
        found = {other: float(at[name]), "outcome": OUTCOMES[int(at[f"outcome_at_{axis}"])]}
        found |= {f"computed {end}": float(at[f"computed_{end}_at_{axis}"]) for end in _ENDS}
    if f"film_parameter_at_{axis}" in at:
        found["film parameter"] = _middle(at[f"film_parameter_at_{axis}"].values)
    return found


def _middle(film: Array) -> float | None:
    """Median film parameter of the surfaces that cross; None if none does."""
    return float(np.nanmedian(film)) if not np.isnan(film).all() else None


def command_for(found: xr.Dataset, store: Any, ds: xr.Dataset) -> str | None:
    """The command that computes transitions beyond what was computed; None where there are none."""
    frictions = zip(_frictions(found), _by_friction(found), strict=True)
    beyond = [
        friction
        for friction, (_, part) in frictions
        if part["outcome_at_load"].isin((*BEYOND, UNKNOWN)).any()
    ]
    if not beyond:
        return None
    is_pending = bool(found.attrs["missing_points"])
    return command_of(store, attributes_of(ds), found.attrs | {"friction": beyond[0]}, is_pending)


def text_of(found: xr.Dataset, command: str | None = None) -> Iterator[str]:
    """Lines of text on `pipeline.boundary`; a column or block for each friction.

    The command computes points that it lacks, if any.
    """
    frictions = ", ".join(f"{value:g}" for value in _frictions(found))
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
    )
    several = _variant(found) is not None
    parts = _by_friction(found) if several else [("", found)]
    for name, axis, heading in _BOUNDARIES:
        for friction, part in parts:
            yield ""
            yield heading + friction
            yield from (_band if several else _columns)(part, name, axis)
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
        if not np.isnan(row).all() and np.nanmedian(row) < _SLOW
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


def _frictions(found: xr.Dataset) -> list[float]:
    if "friction" not in found.sizes:
        return [found.attrs["friction"]]
    return [float(value) for value in found["friction"].values]


def _by_friction(found: xr.Dataset) -> list[tuple[str, xr.Dataset]]:
    if "friction" not in found.sizes:
        return [("", found)]
    return [
        (f" at friction {value:g}", found.isel(friction=place))
        for place, value in enumerate(_frictions(found))
    ]


def _columns(found: xr.Dataset, name: str, axis: str) -> Iterator[str]:
    """Crossings of one surface, a column for each friction."""
    rows = [
        [f"{float(found[axis][place]):10g}", *_cells(found, place, name, axis)]
        for place in range(found.sizes[axis])
    ]
    if "friction" in found.sizes:
        rows.insert(0, [f"{'friction':>10}", *(f"{value:g}" for value in _frictions(found))])
    widths = [max(map(len, column)) for column in zip(*rows, strict=True)]
    for row in rows:
        cells = (f"{cell:<{width}}" for cell, width in zip(row, widths, strict=True))
        yield "   ".join(cells).rstrip()


def _cells(found: xr.Dataset, place: int, name: str, axis: str) -> Iterator[str]:
    """Crossing or outcome at one load or velocity, by friction."""
    for _, part in _by_friction(found):
        at = part.isel({axis: place})
        outcome = int(at[f"outcome_at_{axis}"])
        computed = float(at[f"computed_from_at_{axis}"]), float(at[f"computed_to_at_{axis}"])
        if outcome == CROSSES:
            yield f"{float(at[name]):.4g}{_film(at, axis)}"
        else:
            yield in_words(OUTCOMES[outcome], computed, name.removeprefix("critical_"))


def _band(found: xr.Dataset, name: str, axis: str) -> Iterator[str]:
    """Median, lower and upper end of the band, mean and spread, and how many surfaces cross."""
    ends = [f"{100 * share:g} %" for share in found["quantile"].values]
    heads = ("median", ends[0], ends[-1], "mean", "spread")
    yield f"{'':10}   {' '.join(f'{head:>8}' for head in heads)}   {_KINDS[str(_variant(found))]}"
    for place in range(found.sizes[axis]):
        at = found.isel({axis: place})
        low, middle, high = at[f"{name}_quantile"].values
        values = (middle, low, high, float(at[f"{name}_mean"]), float(at[f"{name}_spread"]))
        cells = (f"{value:.4g}" if math.isfinite(value) else "-" for value in values)
        outcomes = at[f"outcome_at_{axis}"].values.tolist()
        counts = [f"{outcomes.count(CROSSES)} of {len(outcomes)} cross"]
        counts += [
            f"{outcomes.count(why)} {meaning}"
            for why, meaning in OUTCOMES.items()
            if why in outcomes and why != CROSSES
        ]
        row = " ".join(f"{cell:>8}" for cell in cells)
        yield f"{float(at[axis]):10g}   {row}   {', '.join(counts)}{_film(at, axis)}"


def _film(at: xr.Dataset, axis: str) -> str:
    """Film parameter at a crossing, the median over surfaces; empty without an oil."""
    name = f"film_parameter_at_{axis}"
    middle = _middle(at[name].values) if name in at else None
    if middle is None:
        return ""
    return f"  film Λ {middle:.2f}"
