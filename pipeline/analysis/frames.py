"""Data frame of a boundary: critical velocities by load, or critical loads by velocity."""

from __future__ import annotations

import pandas as pd
import xarray as xr

from pipeline.analysis.dataset import entry_dims
from pipeline.analysis.scenes import heads_of
from pipeline.analysis.tables import frame_of
from pipeline.quantities import column_heads
from pipeline.sweep.conditions import FIELDS
from pipeline.sweep.variants import dimension_of

JUDGED = column_heads(
    "bulk_temperature", "disk_temperature", "critical_temperature", "failing_share", "criterion"
)
"""Column headings of the conditions that wear is judged by."""


WITH_TESTS = {
    "tested_velocity": "with tests [m/s]",
    "tested_velocity_low": "5 % [m/s]",
    "tested_velocity_high": "95 % [m/s]",
}
"""Column headings of the velocities at which severe wear is 50, 5 and 95 % likely."""
ERRORS = {"velocity_error": "error [%]", "surface_error": "by surface [%]"}
"""Column headings of the numerical error of critical velocities, and of its part by the surface."""


def boundary_frame(boundaries: xr.Dataset, axis: str = "load") -> pd.DataFrame:
    """Data frame of a boundary, with a row for each scene and each value of `axis`.

    `axis` is "load" for critical velocities at each load, or "velocity" for critical loads at each
    velocity.
    """
    name = "critical_velocity" if axis == "load" else "critical_load"
    values = {column_heads(name)[name]: boundaries[name]}
    if axis == "load":
        values |= {head: boundaries[name] for name, head in ERRORS.items()}
        values |= {head: boundaries[name] for name, head in WITH_TESTS.items()}
    values["outcome"] = boundaries[f"words_at_{axis}"]
    if (film := f"film_parameter_at_{axis}") in boundaries:
        values["film parameter Λ"] = boundaries[film]
    rows = next(iter(values.values()))
    dims = [*entry_dims(rows), axis]
    crossings = xr.Dataset({head: data.drop_attrs() for head, data in values.items()})
    frame = crossings.to_dataframe(dims).reset_index()
    names = ["friction", *JUDGED, "caveats"]
    judged = [one for one in names if dimension_of(FIELDS.get(one, "")) not in dims]
    for one in judged:
        if one not in frame:
            frame[one] = boundaries.attrs.get(one)
    heads = heads_of(boundaries, dims[:-1]) | column_heads(axis) | JUDGED | {"caveats": "notes"}
    # Friction leads even if it is a single value.
    front = [*dims[:-1], *{"friction"}.intersection(judged), axis]
    names = [*dict.fromkeys([*front, *values, *judged])]
    found = frame[names].itertuples(index=False, name=None)
    return frame_of([heads.get(column, column) for column in names], found)
