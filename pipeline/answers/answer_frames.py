"""Answers as data frames, in the usual units."""

from __future__ import annotations

import numpy as np
import pandas as pd
import xarray as xr

from pipeline.answers.answer_dataset import ATTRIBUTES
from pipeline.answers.condition_values import PAIRS
from pipeline.answers.scene_wording import value_words
from pipeline.answers.value_text import code_text, flag_names, printed_unit, variable_texts
from pipeline.condition_kinds import CONDITIONS
from pipeline.frames import cell_text, frame_of, without_columns
from pipeline.store.schema import PLANE
from pipeline.sweep.case_table import CASE

_COMPUTED_RISE = "computed over allowable rise [%]"
_COMMON_ATTRIBUTES = ("conditions", "model_error", "not_included", "notes")
_MARGIN_VARIABLES = (
    "verdict", "probability", "governing_temperature", "temperature_error", "temperature_margin",
    "friction_safety_factor", "velocity_safety_factor", "load_safety_factor",
)  # fmt: skip
_TYPED_DIGITS = 6  # of loads, velocities, conditions and entries
_NUMBER_STARTS = tuple("0123456789+-−.")
_HEADINGS = {
    "critical_velocity_p50": "50 % severe", "velocity_error": "numerical error",
    "mild_velocity": "mild up to", "mild_load": "mild up to",
    "severe_velocity": "severe from", "severe_load": "severe from",
    "velocity_error_surface": "surface sampling error", "outcome_along_velocity": "outcome",
    "outcome_along_load": "outcome", "loo_probability": "leave-one-out probability",
}  # fmt: skip


def row_labels(answer: xr.Dataset, row: str) -> list[str]:
    """Label of each row of an answer: the user's first column, else load and velocity.

    `row` is the dimension of the rows.
    """
    hidden = {*PLANE, *ATTRIBUTES, *CONDITIONS}
    user_columns = [
        name for name, array in answer.coords.items() if array.dims == (row,) and name not in hidden
    ]
    if not user_columns:
        points = zip(*(answer[name].values.tolist() for name in PLANE), strict=True)
        return [f"{load:g} N, {velocity:g} m/s" for load, velocity in points]
    axis = answer[min(user_columns, key=lambda name: name == row)]
    texts = [value_words(axis, value) for value in axis.values.tolist()]
    name = str(axis.name).replace("_", " ").partition(" [")
    named_texts = (f"{name[0]} {text} {name[2][:-1]}".rstrip() for text in texts)
    pairs = zip(texts, named_texts, strict=True)
    return [named_text if text[:1] in _NUMBER_STARTS else text for text, named_text in pairs]


def answer_frame(answer: xr.Dataset, *names: str) -> pd.DataFrame:
    """Rows of an answer: its dimensions, then the variables `names`, in the usual units.

    Without `names`, all variables. Headings are names with units. Columns that a user added to a
    table come first.
    """
    dims = [str(dim) for dim in answer.sizes]
    coordinates = [
        str(name) for name, array in answer.coords.items() if array.ndim and name not in dims
    ]
    user_columns = [name for name in _user_columns(answer) if name in (names or coordinates)]
    user_columns.sort(key=lambda name: name in CONDITIONS)
    names = names or (*coordinates, *map(str, answer.data_vars))
    axes = [name for name in ("load", "velocity") if name not in dims and name not in names]
    plane_columns = [name for name in axes if {*answer[name].dims} <= {*answer[names[0]].dims}]
    columns = [*dict.fromkeys([*user_columns, *plane_columns, *names])]
    ds = xr.Dataset({name: _to_text(answer[name]) for name in columns})
    ds = ds.assign_coords({dim: answer[dim] for dim in ds.dims if dim in answer.coords})
    ds = ds if ds.sizes else ds.expand_dims(PAIRS)
    frame = ds.to_dataframe().reset_index()
    row_dims = [dim for dim in dims if dim in frame and (dim != PAIRS or dim in ds.coords)]
    all_columns = [*row_dims, *columns]
    short_headings = [_heading(name, answer) for name in all_columns]
    headings = [  # names in place of equal headings, such as the outcomes along both axes
        heading if short_headings.count(heading) == 1 else name.replace("_", " ")
        for name, heading in zip(all_columns, short_headings, strict=True)
    ]
    return frame_of(headings, frame[all_columns].itertuples(index=False, name=None))


def _user_columns(answer: xr.Dataset) -> list[str]:
    """Names of the columns that a user added to a table, or varied conditions and entries."""
    program_names = {*answer.sizes, *PLANE, *ATTRIBUTES}
    coordinates = answer.coords.items()
    return [str(name) for name, array in coordinates if array.ndim and name not in program_names]


def _to_text(variable: xr.DataArray) -> xr.Variable:
    """A variable with text for its codes and flags."""
    if "flag_values" in variable.attrs:
        return variable.copy(data=code_text(variable)).variable
    if "flag_masks" in variable.attrs:
        texts = [", ".join(flag_names(variable, k)) for k in variable.values.ravel().tolist()]
        return variable.copy(data=np.array(texts, object).reshape(variable.shape)).variable
    return variable.variable


def complete_frame(answer: xr.Dataset, *names: str) -> pd.DataFrame:
    """`answer_frame` with columns for the conditions and notes of all rows, for programs."""
    frame = answer_frame(answer, *names)
    return frame.assign(
        **{name: answer.attrs[name] for name in _COMMON_ATTRIBUTES if name in answer.attrs}
    )


def margin_frame(answer: xr.Dataset) -> pd.DataFrame:
    """Main columns of `pipeline.margin`, with probabilities in words, for a reader."""
    user_columns, names = _user_columns(answer), [*_MARGIN_VARIABLES]
    if "end_temperature" in answer:
        names.insert(names.index("governing_temperature") + 1, "end_temperature")
    if "mild_load_factor" in answer:  # in place of the factors along lines of a plane
        names[-2:] = ["mild_load_factor"]
    frame = _reader_frame(answer, *user_columns, *names)
    return without_columns(frame, [CASE] if user_columns and CASE in answer.sizes else [])


def comparison_frame(comparison: xr.Dataset) -> pd.DataFrame:
    """Tests and what is computed for them, for a reader: rises in percent of the allowable rise.

    A transition with a step has the rises at both of its ends.
    """
    names = [str(name) for name in comparison if not str(name).startswith("log_rise_ratio")]
    frame = _reader_frame(comparison, *names)
    ends = np.stack([comparison[f"log_rise_ratio_{end}"].values for end in ("mild", "severe")])
    percents = [
        " to ".join(dict.fromkeys(f"{100 * np.exp(y):.0f}" for y in pair[np.isfinite(pair)]))
        for pair in ends.T.astype(float)
    ]
    position = [*frame].index("governing temperature [°C]") + 1
    frame.insert(position, _COMPUTED_RISE, [text or None for text in percents])
    return frame


def boundary_frame(answer: xr.Dataset, by: str = "load") -> pd.DataFrame:
    """Rows of `pipeline.boundary` by load or by velocity, for a reader.

    Between the limits by the verdict stands the boundary, as computed and with tests. A value
    outside the sweep is "below" or "above" its end.
    """
    axis = "velocity" if by == "load" else "load"
    headings = {
        f"mild_{axis}": "mild up to", f"critical_{axis}": "computed",
        "critical_velocity_p50": "50 %", f"severe_{axis}": "severe from",
        f"film_parameter_at_{by}": "film", "velocity_error": "error",
    }  # fmt: skip
    tests = answer.attrs["tests"] if "tests" in answer.attrs else answer["tests"]
    if not np.any(tests):  # with a result within the model
        del headings["critical_velocity_p50"]
    names = [name for name in headings if name in answer and by in answer[name].dims]
    short = {_heading(k, answer): _heading(k, answer, headings[k]) for k in names}
    return _reader_frame(answer, *names).rename(columns=short)


def _reader_frame(answer: xr.Dataset, *names: str) -> pd.DataFrame:
    """`answer_frame` for a reader: numbers as text.

    Results have the digits that their errors allow, and what a person typed has all of its digits.
    """
    texts = {name: variable_texts(answer, name) for name in names}
    return answer_frame(answer.assign(texts), *names).apply(_typed_texts)


def _typed_texts(values: pd.Series) -> list[str | None]:
    """Values that a person typed as text, with all of their digits; None for empty ones."""
    return [None if pd.isna(value) else cell_text(value, _TYPED_DIGITS) or None for value in values]


def _heading(name: str, answer: xr.Dataset, title: str = "") -> str:
    title = title or _HEADINGS.get(name, name.replace("_", " "))
    if name in ("mild_velocity", "mild_load") and "temperature_error" in answer:
        title = name.replace("_", " ")  # margins have both
    unit = printed_unit(answer, name) if name in answer.variables else ""
    return f"{title} [{unit}]" if unit else title
