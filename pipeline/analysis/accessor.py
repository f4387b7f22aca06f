"""Answers as ``ds.irg`` of a dataset of a sweep, by the same words as those of `pipeline`."""

from __future__ import annotations

import functools
from collections.abc import Callable
from typing import Any

import xarray as xr

from pipeline import extras

_ANSWERS = "at", "boundary", "margin", "temperatures", "warned", "end_of_point", "plot", "explore"


@xr.register_dataset_accessor("irg")  # type: ignore[no-untyped-call]
class Answers:
    """Answers of a sweep, each the function of `pipeline` of that name with this dataset.

    Examples
    --------
    >>> import pipeline
    >>> ds = pipeline.open_sweep("results/first_try.zarr")
    >>> ds.irg.at(friction=0.12).irg.margin("400 N", "1.4 m/s").verdict
    'not decided'
    """

    def __init__(self, ds: xr.Dataset) -> None:
        self._ds = ds

    def __dir__(self) -> list[str]:
        return [name for name in _ANSWERS if name not in extras.absent()]

    def __getattr__(self, name: str) -> Callable[..., Any]:
        if name not in _ANSWERS:
            raise AttributeError(f"a sweep has no {name}; it has {', '.join(_ANSWERS)}")
        import pipeline  # which loads each answer when it is used

        return functools.partial(getattr(pipeline, name), self._ds)
