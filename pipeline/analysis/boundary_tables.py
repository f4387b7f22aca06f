"""Boundary as data frames: critical velocities by load, and critical loads by velocity."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np
import pandas as pd
import xarray as xr

from pipeline.analysis.dataset import entry_dims, variant_of
from pipeline.analysis.scenes import entry_heads
from pipeline.analysis.tables import frame_of
from pipeline.analysis.transition import CROSSES, UNITS, in_words, outcomes

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
    """Frames of `pipeline.boundary`: critical velocities by load, and critical loads by velocity.

    A row is for one load or velocity at one friction, with the conditions that it was judged by.
    Over several surfaces it has the median, the band, and how many of them cross.
    """
    return tuple(_along(boundaries, *ends) for ends in BOUNDARIES)


def _along(boundaries: xr.Dataset, name: str, axis: str) -> pd.DataFrame:
    """Frame along one axis."""
    variant = variant_of(boundaries)
    columns = _crossings if variant is None else _band
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
    heads = entry_heads(boundaries[name]) | {axis: f"{axis} [{UNITS[axis]}]"} | JUDGED
    names = [*dict.fromkeys([*dims[:-1], "friction", axis, *values, *JUDGED])]
    rows = frame[names].itertuples(index=False, name=None)
    return frame_of([heads.get(column, column) for column in names], rows)


def _crossings(boundaries: xr.Dataset, name: str, axis: str) -> Iterator[tuple[str, xr.DataArray]]:
    """Crossings of one surface, by their heads."""
    other = name.removeprefix("critical_")
    codes, *ends = (boundaries[f"{part}_at_{axis}"] for part in _OUTCOME)
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


_OUTCOME = "outcome", "computed_from", "computed_to"


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
