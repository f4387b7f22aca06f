"""Answers as methods of ``ds.irg`` on the dataset of a sweep, named as functions of `pipeline`."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any, Unpack, overload

import pandas as pd
import xarray as xr

import pipeline  # each function is imported on first use

if TYPE_CHECKING:
    from pathlib import Path

    from matplotlib.figure import Figure

    from pipeline.analysis.at import ConditionKeywords
    from pipeline.analysis.margin import Margin
    from pipeline.analysis.margin_frame import Points
    from pipeline.analysis.warned_points import Warned
    from pipeline.figures.plot import Kind, PlotOptions


@xr.register_dataset_accessor("irg")  # type: ignore[no-untyped-call]
class Answers:
    """Accessor ``ds.irg``: functions of `pipeline` as methods of the dataset.

    Type checkers take ``ds.irg`` for anything; ``answers: pipeline.Answers = ds.irg`` tells them.

    Examples
    --------
    >>> import pipeline
    >>> ds = pipeline.open_sweep("results/first_try.zarr")
    >>> ds.irg
    ds.irg: at, boundary, end_of_point, margin, plot, temperatures, warned
    >>> ds.irg.at(friction=0.12).irg.margin("400 N", "1.4 m/s").verdict
    'not decided'
    """

    def __init__(self, ds: xr.Dataset) -> None:
        self._ds = ds

    def __dir__(self) -> list[str]:
        return [name for name in vars(Answers) if not name.startswith("_")]

    def __repr__(self) -> str:
        return f"ds.irg: {', '.join(sorted(self.__dir__()))}"

    def at(self, **conditions: Any) -> xr.Dataset:
        """Judge under other conditions or values; see `pipeline.at`."""
        return pipeline.at(self._ds, **conditions)

    def boundary(self, **conditions: Unpack[ConditionKeywords]) -> xr.Dataset:
        """Find critical velocities and loads; see `pipeline.boundary`."""
        return pipeline.boundary(self._ds, **conditions)

    @overload
    def margin(
        self, load: float | str, velocity: float | str, **conditions: Unpack[ConditionKeywords]
    ) -> Margin: ...

    @overload
    def margin(
        self, load: Points | None = None, **conditions: Unpack[ConditionKeywords]
    ) -> pd.DataFrame: ...

    def margin(self, *place: Any, **options: Any) -> Margin | pd.DataFrame:
        """Judge an operating point, or a table of them; see `pipeline.margin`."""
        return pipeline.margin(self._ds, *place, **options)

    def temperatures(self, **conditions: Unpack[ConditionKeywords]) -> xr.Dataset:
        """Temperatures of the contact; see `pipeline.temperatures`."""
        return pipeline.temperatures(self._ds, **conditions)

    def warned(self) -> Warned:
        """Points that carry a warning; see `pipeline.warned`."""
        return pipeline.warned(self._ds)

    def end_of_point(self) -> xr.Dataset:
        """Variables at the end of each point; see `pipeline.end_of_point`."""
        return pipeline.end_of_point(self._ds)

    def plot(
        self,
        kind: Kind | None = None,
        out: str | Path | None = None,
        **options: Unpack[PlotOptions],
    ) -> Figure | Path:
        """Draw a figure; see `pipeline.plot`."""
        return pipeline.plot(self._ds, kind, out, **options)
