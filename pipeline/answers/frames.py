"""Answers as data frames, in the units of people."""

from __future__ import annotations

import re

import numpy as np
import pandas as pd
import xarray as xr

from pipeline.answers.conditions import NAMES
from pipeline.answers.tables import frame_of, short
from pipeline.answers.units import usual_unit
from pipeline.answers.words import ABOUT, percent
from pipeline.store.schema import PLANE

_TOLD = ("conditions", "model_error", "notes")
_ROWS = (
    "verdict", "probability", "temperature", "temperature_error", "distance", "critical_velocity",
)  # fmt: skip


def answer_frame(found: xr.Dataset, *names: str) -> pd.DataFrame:
    """Rows of an answer: its dimensions, then the variables `names`, in the units of people.

    All variables if none are named. Headings are their names, with units. Columns of a user's own
    stand first.
    """
    dims = [str(dim) for dim in found.sizes]
    own = [str(name) for name, one in found.coords.items() if one.ndim and name not in dims]
    first = [name for name in own if name not in (*PLANE, *ABOUT) and name in (names or own)]
    first.sort(key=lambda name: name in NAMES)
    names = names or (*own, *map(str, found.data_vars))
    axes = [name for name in ("load", "velocity") if name not in dims and name not in names]
    places = [name for name in axes if {*found[name].dims} <= {*found[names[0]].dims}]
    wanted = [*dict.fromkeys([*first, *places, *names])]
    spread = xr.Dataset({name: found[name].variable for name in wanted})
    spread = spread.assign_coords({dim: found[dim] for dim in spread.dims if dim in found.coords})
    spread = spread if spread.sizes else spread.expand_dims("place")
    frame = spread.to_dataframe().reset_index()
    columns = [*(dim for dim in dims if dim in frame and dim != "place"), *wanted]
    heads = [_heading(name, found) for name in columns]
    return frame_of(heads, frame[columns].itertuples(index=False, name=None))


def whole_frame(found: xr.Dataset, *names: str) -> pd.DataFrame:
    """As `answer_frame`, with the conditions and notes that hold for all rows, for programs."""
    frame = answer_frame(found, *names)
    return frame.assign(**{name: found.attrs[name] for name in _TOLD if name in found.attrs})


def margin_frame(found: xr.Dataset) -> pd.DataFrame:
    """Rows of `pipeline.margin` to read: columns that decide, probabilities in words."""
    hidden = {*found.sizes, *PLANE, *ABOUT}
    own = [str(name) for name, one in found.coords.items() if one.ndim and name not in hidden]
    frame = short(answer_frame(found, *own, *_ROWS))
    frame["probability"] = [None if np.isnan(p) else percent(p) for p in frame["probability"]]
    return frame


def boundary_frame(found: xr.Dataset, by: str = "load") -> pd.DataFrame:
    """Rows of `pipeline.boundary` by load or by velocity, without the parts of the error."""
    names = dict.fromkeys(
        [
            f"critical_{'velocity' if by == 'load' else 'load'}",
            *(str(name) for name in found if found[name].dims[-1:] == (by,)),
        ]
    )
    left_out = re.compile("velocity_error_.*|.*_code")
    return answer_frame(found, *(name for name in names if not left_out.fullmatch(name)))


def _heading(name: str, found: xr.Dataset) -> str:
    unit = found[name].attrs.get("units", "") if name in found.variables else ""
    is_error = "error" in name or name == "distance"
    if name in found.dims and name not in PLANE and unit:
        unit = usual_unit(found[name])
    if unit == "K" and not is_error:
        unit = "°C"
    if unit == "1":
        unit = "%" if is_error else ""
    return name.replace("_", " ") + f" [{unit}]" * bool(unit)
