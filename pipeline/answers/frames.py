"""Answers as data frames, in the units of people."""

from __future__ import annotations

import re

import numpy as np
import pandas as pd
import xarray as xr

from pipeline.answers import words
from pipeline.answers.conditions import NAMES
from pipeline.answers.scene_words import usual_unit
from pipeline.answers.words import ABOUT, probability_text
from pipeline.frames import frame_of, without_columns
from pipeline.store.schema import PLANE
from pipeline.sweep.case_table import CASE

_TOLD = ("conditions", "model_error", "not_included", "notes")
_ROWS = (
    "verdict", "probability", "governing_temperature", "temperature_error", "temperature_margin",
    "critical_velocity",
)  # fmt: skip


_HEADINGS = {
    "critical_velocity_p50": "with tests, 50 %", "critical_velocity_p05": "5 %",
    "critical_velocity_p95": "95 %", "velocity_error": "numerical error",
    "velocity_error_surface": "surface sampling error", "outcome_along_velocity": "outcome",
    "outcome_along_load": "outcome", "film_parameter_at_load": "film parameter Λ",
    "film_parameter_at_velocity": "film parameter Λ",
    "loo_probability": "leave-one-out probability",
}  # fmt: skip


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
    spread = xr.Dataset({name: _shown(found[name]) for name in wanted})
    spread = spread.assign_coords({dim: found[dim] for dim in spread.dims if dim in found.coords})
    spread = spread if spread.sizes else spread.expand_dims("place")
    frame = spread.to_dataframe().reset_index()
    columns = [*(dim for dim in dims if dim in frame and dim != "place"), *wanted]
    short_heads = [_heading(name, found) for name in columns]
    heads = [  # both outcomes of a point are in one row
        head if short_heads.count(head) == 1 else name.replace("_", " ")
        for name, head in zip(columns, short_heads, strict=True)
    ]
    return frame_of(heads, frame[columns].itertuples(index=False, name=None))


def _shown(one: xr.DataArray) -> xr.Variable:
    """A variable with text for its codes and flags."""
    if "flag_values" in one.attrs:
        return one.copy(data=words.code_text(one)).variable
    if "flag_masks" in one.attrs:
        texts = [", ".join(words.flag_names(one, k)) for k in one.values.ravel().tolist()]
        return one.copy(data=np.array(texts, object).reshape(one.shape)).variable
    return one.variable


def whole_frame(found: xr.Dataset, *names: str) -> pd.DataFrame:
    """As `answer_frame`, with the conditions and notes that hold for all rows, for programs."""
    frame = answer_frame(found, *names)
    return frame.assign(**{name: found.attrs[name] for name in _TOLD if name in found.attrs})


def margin_frame(found: xr.Dataset) -> pd.DataFrame:
    """Rows of `pipeline.margin` to read: columns that decide, probabilities in words."""
    hidden = {*found.sizes, *PLANE, *ABOUT}
    own = [str(name) for name, one in found.coords.items() if one.ndim and name not in hidden]
    frame = without_columns(
        answer_frame(found, *own, *_ROWS), [CASE] * bool(own and CASE in found.sizes)
    )
    frame["probability"] = [
        None if np.isnan(p) else probability_text(p) for p in frame["probability"]
    ]
    return frame


def boundary_frame(found: xr.Dataset, by: str = "load") -> pd.DataFrame:
    """Rows of `pipeline.boundary` by load or by velocity, without the parts of the error."""
    names = dict.fromkeys(
        [
            f"critical_{'velocity' if by == 'load' else 'load'}",
            *(str(name) for name in found if found[name].dims[-1:] == (by,)),
        ]
    )
    left_out = re.compile("velocity_error_.*")
    return answer_frame(found, *(name for name in names if not left_out.fullmatch(name)))


def _heading(name: str, found: xr.Dataset) -> str:
    unit = found[name].attrs.get("units", "") if name in found.variables else ""
    is_error = "error" in name or name == "temperature_margin"
    own = "shown_in" in found[name].attrs if name in found.variables else False
    if unit and (own or (name in found.dims and name not in PLANE)):
        unit = usual_unit(found[name])
    if unit == "K" and not is_error:
        unit = "°C"
    if unit == "1":
        unit = "%" if is_error or name == "loo_probability" else ""
    return _HEADINGS.get(name, name.replace("_", " ")) + f" [{unit}]" * bool(unit)
