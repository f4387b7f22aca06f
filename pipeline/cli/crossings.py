"""A boundary as a document and in words, as ``irg boundary`` prints it."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator
from typing import Any

import numpy as np
import xarray as xr

import pipeline
from pipeline.analysis.attributes import attributes_of
from pipeline.analysis.tables import Column, Table
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

_BOUNDARIES = (("critical_velocity", "load"), ("critical_load", "velocity"))
_AXES = {"load": Column("load", "load", "N"), "velocity": Column("velocity", "velocity", "m/s")}
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
    for _, axis in _BOUNDARIES:
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


def tables_of(found: xr.Dataset) -> list[Table]:
    """Tables of `pipeline.boundary`: critical velocities by load, and critical loads by velocity.

    A row is for one load or velocity at one friction, with the conditions that it was judged by.
    """
    several = _variant(found) is not None
    return [(_band if several else _crossings)(found, *boundary) for boundary in _BOUNDARIES]


def _crossings(found: xr.Dataset, name: str, axis: str) -> Table:
    """Crossings of one surface."""
    other = name.removeprefix("critical_")
    unit = _AXES[other].unit
    columns = (
        Column(name, f"critical {other}", unit),
        Column(f"outcome_at_{axis}", "outcome"),
        Column(f"computed_from_at_{axis}", "computed from", unit),
        Column(f"computed_to_at_{axis}", "computed to", unit),
    )

    def values(at: xr.Dataset) -> tuple[Any, ...]:
        crossing, outcome, *ends = (at[column.name].item() for column in columns)
        return crossing, OUTCOMES[outcome], *ends

    return _by_place(found, axis, columns, values)


def _band(found: xr.Dataset, name: str, axis: str) -> Table:
    """Median, ends of the band, mean and spread of several surfaces, and how many of them cross."""
    other, kind = name.removeprefix("critical_"), _KINDS[str(_variant(found))]
    unit = _AXES[other].unit
    low, _, high = (f"{100 * share:g} %" for share in found["quantile"].values)
    heads = ("median", low, high, "mean", "spread")
    outcomes = {
        code: words
        for code, words in OUTCOMES.items()
        if code != CROSSES and (found[f"outcome_at_{axis}"] == code).any()
    }
    columns = (
        *(Column(f"{name}_{head}", head, unit) for head in heads),
        Column(kind, kind),
        Column("crosses", "cross"),
        *(Column(words, words) for words in outcomes.values()),
    )

    def values(at: xr.Dataset) -> tuple[Any, ...]:
        low, middle, high = at[f"{name}_quantile"].values.tolist()
        moments = (at[f"{name}_{moment}"].item() for moment in ("mean", "spread"))
        all_outcomes = at[f"outcome_at_{axis}"].values.tolist()
        counts = (all_outcomes.count(code) for code in (CROSSES, *outcomes))
        return middle, low, high, *moments, len(all_outcomes), *counts

    return _by_place(found, axis, columns, values)


def _by_place(
    found: xr.Dataset,
    axis: str,
    columns: tuple[Column, ...],
    values: Callable[[xr.Dataset], tuple[Any, ...]],
) -> Table:
    """Table with a row for each friction and each load or velocity."""
    attrs, film = found.attrs, f"film_parameter_at_{axis}"
    judged = {
        Column("bulk_temperature", "bulk", "°C"): attrs["bulk_temperature"],
        Column("disk_temperature", "disk bulk", "°C"): attrs.get("disk_temperature"),
        Column("critical_temperature", "critical", "°C"): attrs["critical_temperature"],
        Column("failing_share", "failing share"): attrs["failing_share"],
        Column("criterion", "criterion"): attrs["criterion"],
    }
    rows = []
    for friction, part in _by_friction(found):
        for place in range(found.sizes[axis]):
            at = part.isel({axis: place})
            parameter = _middle(at[film].values) if film in at else None
            own = (friction, at[axis].item(), *values(at), parameter)
            rows.append((*own, *judged.values()))
    heads = (Column("friction", "friction"), _AXES[axis], *columns)
    film_column = Column(film, "film parameter Λ", digits=3)
    return Table((*heads, film_column, *judged), tuple(rows))


def _middle(film: Array) -> float | None:
    """Median film parameter of the surfaces that cross; None if none does."""
    return float(np.nanmedian(film)) if not np.isnan(film).all() else None


def command_for(found: xr.Dataset, store: Any, ds: xr.Dataset) -> str | None:
    """The command that computes transitions beyond what was computed; None where there are none."""
    beyond = [
        friction
        for friction, part in _by_friction(found)
        if part["outcome_at_load"].isin((*BEYOND, UNKNOWN)).any()
    ]
    if not beyond:
        return None
    is_pending = bool(found.attrs["missing_points"])
    return command_of(store, attributes_of(ds), found.attrs | {"friction": beyond[0]}, is_pending)


def text_of(found: xr.Dataset, tables: list[Table], command: str | None = None) -> Iterator[str]:
    """Lines of text on `pipeline.boundary` and its tables.

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
    for (name, axis), table in zip(_BOUNDARIES, tables, strict=True):
        yield ""
        yield from (_without_conditions if several else _side_by_side)(table, name, axis).lines()
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


def _by_friction(found: xr.Dataset) -> Iterator[tuple[float, xr.Dataset]]:
    """The boundary at each friction."""
    if "friction" not in found.sizes:
        yield found.attrs["friction"], found
        return
    for place, value in enumerate(_frictions(found)):
        yield value, found.isel(friction=place)


def _side_by_side(table: Table, name: str, axis: str) -> Table:
    """Crossings of one surface, or outcomes in words, with a column for each friction."""
    values, other = table.as_dict(), name.removeprefix("critical_")
    frictions = list(dict.fromkeys(values["friction"]))
    crossing = next(column for column in table.columns if column.name == name)
    rows: dict[float, dict[float, str]] = {}
    for row in range(len(table.rows)):
        at = {key: column[row] for key, column in values.items()}
        computed = at[f"computed_from_at_{axis}"], at[f"computed_to_at_{axis}"]
        cell = f"{crossing.text(at[name])}{_film(at[f'film_parameter_at_{axis}'])}"
        if not math.isfinite(at[name]):
            cell = in_words(at[f"outcome_at_{axis}"], computed, other)
        rows.setdefault(at[axis], {})[at["friction"]] = cell
    heads = [Column(name, crossing.head)]
    if len(frictions) > 1:
        heads = [Column(str(value), f"at friction {value:g}") for value in frictions]
        heads[0] = heads[0]._replace(title=f"{crossing.head} {heads[0].title}")
    shown = ((place, *cells.values()) for place, cells in rows.items())
    return Table((_AXES[axis], *heads), tuple(shown))


def _without_conditions(table: Table, name: str, axis: str) -> Table:
    """The band of several surfaces, with the friction only where there are several."""
    left_out = {"bulk_temperature", "disk_temperature", "critical_temperature", "failing_share"}
    left_out |= {"criterion"}
    if len(set(table.as_dict()["friction"])) == 1:
        left_out.add("friction")
    title = f"critical {name.removeprefix('critical_')}, median"
    shown = table.without(left_out).without_empty()
    columns = tuple(
        column._replace(title=title) if column.name == f"{name}_median" else column
        for column in shown.columns
    )
    return Table(columns, shown.rows)


def _film(parameter: float | None) -> str:
    """Film parameter at a crossing; empty without an oil."""
    return "" if parameter is None else f"  film Λ {parameter:.2f}"
