"""Answers as methods of ``ds.irg`` on the dataset of a sweep, named as functions of `pipeline`."""

from __future__ import annotations

import functools
from collections.abc import Callable
from typing import Any

import xarray as xr

from pipeline import extras

_ANSWERS = "at", "boundary", "margin", "temperatures", "warned", "end_of_point", "plot", "explore"


@xr.register_dataset_accessor("irg")  # type: ignore[no-untyped-call]
class Answers:
    """Accessor ``ds.irg``: functions of `pipeline` as methods of the dataset.

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
        import pipeline  # imports each function on first use

        return functools.partial(getattr(pipeline, name), self._ds)
