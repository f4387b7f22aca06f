"""Data frame of a boundary: critical velocities by load, or critical loads by velocity."""

from __future__ import annotations

from collections.abc import Iterator

import pandas as pd
import xarray as xr

from pipeline.analysis.dataset import entry_dims
from pipeline.analysis.scenes import heads_of
from pipeline.analysis.tables import frame_of
from pipeline.analysis.transition import CROSSES, outcomes
from pipeline.quantities import UNITS, column_heads
from pipeline.sweep.conditions import FIELDS

JUDGED = column_heads(
    "bulk_temperature", "disk_temperature", "critical_temperature", "failing_share", "criterion"
)
"""Column headings of the conditions that wear is judged by."""


def boundary_frame(boundaries: xr.Dataset, axis: str = "load") -> pd.DataFrame:
    """Data frame of a boundary, with a row for each scene and each value of `axis`.

    `axis` is "load" for critical velocities at each load, or "velocity" for critical loads at each
    velocity.
    """
    name = "critical_velocity" if axis == "load" else "critical_load"
    columns = _band if f"{name}_quantile" in boundaries else _surface
    values = dict(columns(boundaries, name, axis))
    if (film := f"film_parameter_at_{axis}") in boundaries:
        over = boundaries[film]
        surfaces = [name for name in over.dims if name == "realization"]
        values["film parameter Λ"] = over.median(surfaces) if surfaces else over
    if axis == "load":
        values["mild below [m/s]"] = boundaries["mild_below"]
        values["severe above [m/s]"] = boundaries["severe_above"]
    rows = next(iter(values.values()))
    dims = [*entry_dims(rows), axis]
    crossings = xr.Dataset({head: data.drop_attrs() for head, data in values.items()})
    frame = crossings.to_dataframe(dims).reset_index()
    judged = [one for one in ("friction", *JUDGED, "caveats") if FIELDS.get(one) not in dims]
    for one in judged:
        if one not in frame:
            frame[one] = boundaries.attrs.get(one)
    heads = heads_of(boundaries, dims[:-1]) | column_heads(axis) | JUDGED | {"caveats": "notes"}
    # Friction leads even if it is a single value.
    front = [*dims[:-1], *{"friction"}.intersection(judged), axis]
    names = [*dict.fromkeys([*front, *values, *judged])]
    found = frame[names].itertuples(index=False, name=None)
    return frame_of([heads.get(column, column) for column in names], found)


def _surface(boundaries: xr.Dataset, name: str, axis: str) -> Iterator[tuple[str, xr.DataArray]]:
    """Yield pairs (heading, column) for a single surface: critical value and outcome.

    `name` is "critical_velocity" or "critical_load". A column has a value for each load (`axis` is
    "load") or for each velocity ("velocity").
    """
    yield column_heads(name)[name], boundaries[name]
    yield "outcome", boundaries[f"words_at_{axis}"]


def _band(boundaries: xr.Dataset, name: str, axis: str) -> Iterator[tuple[str, xr.DataArray]]:
    """Yield pairs (heading, column) of a boundary for several surfaces.

    The columns are the median, the 10 and the 90 % quantile of the critical value, and the number
    of surfaces with each outcome that occurs.

    `name` is "critical_velocity" or "critical_load". A column has a value for each load (`axis` is
    "load") or for each velocity ("velocity").
    """
    other, surfaces = name.removeprefix("critical_"), "realization"
    unit, band = UNITS[other], boundaries[f"{name}_quantile"]
    heads = [f"{100 * share:g} %" for share in band["quantile"].values]
    heads[1] = f"critical {other}, median"
    for place in (1, 0, 2):
        yield f"{heads[place]} [{unit}]", band.isel(quantile=place, drop=True)
    codes = boundaries[f"outcome_at_{axis}"]
    for code, outcome in outcomes(other).items():
        if code == CROSSES or (codes == code).any():
            yield f"surfaces: {outcome}", (codes == code).sum(surfaces)
