"""Schema of the dataset of a sweep: its variables, with their dimensions and attributes."""

from __future__ import annotations

from collections import Counter
from collections.abc import Mapping, Sequence
from typing import Any, NamedTuple

import numpy as np

from pipeline.sweep.case import TEST
from pipeline.sweep.case_table import LOAD_FACTOR, ROWS
from pipeline.sweep.plan import TEST_POINT
from pipeline.sweep.sweep import Sweep
from tribo import InputError, WarningKind
from tribo.simulation.corrections import NEEDED
from tribo.simulation.pin_ends import has_free_ends
from tribo.types import Array

FORMAT = 48
"""Version of the layout of stores, and of the defaults of the fields of stored classes."""
NOT_NEEDED, DONE, FAILED, PENDING = 0, 1, 2, 3
"""Values of the variable ``status``; the last run did not need a point that is `NOT_NEEDED`."""
INPUT_DIM = "input"
"""Dimension of the variable `INPUTS`, which has no coordinate."""


class Variable(NamedTuple):
    """A variable of the dataset: dimensions, unit, meaning, NumPy type and further attributes."""

    dims: tuple[str, ...]
    units: str | None
    long_name: str
    dtype: str = "float64"
    attributes: Mapping[str, Any] = {}


FIELD_REALIZATION = "field_realization"
"""Scalar coordinate of fields: the label of the surface realization that they are of.

It is not called ``realization``, since xarray gives a group the dimensions of the root.
"""
PLANE = ("load", "velocity")
"""Dimensions of the plane; if each row has its own load and velocity, coordinates of rows."""
_STEP_DIMS = (*PLANE, "step")
_QUANTILE_DIMS = (*_STEP_DIMS, "area_fraction_below")
_FIELD_DIMS = (*PLANE, "x", "y")
_PER_FRICTION = "per unit friction coefficient"


def _field(units: str, long_name: str) -> Variable:
    return Variable(_FIELD_DIMS, units, long_name, "float32")  # half the size


COORDINATES = {
    **{name: Variable((name,), "1", meaning, "int64") for name, meaning in ROWS.items()},
    LOAD_FACTOR: Variable(
        (LOAD_FACTOR,), "1", "share of the load of each row at which it is simulated"
    ),
    "load": Variable(("load",), "N", "normal load on the pin at the end of the ramp"),
    "velocity": Variable(("velocity",), "m/s", "sliding velocity"),
    "step": Variable(("step",), "1", "step of the point, 0 at its end, −1 before", "int64"),
    "area_fraction_below": Variable(
        ("area_fraction_below",), "1", "share of the contact area that is cooler than the quantile"
    ),
    "x": Variable(("x",), "m", "position along the sliding direction"),
    "y": Variable(("y",), "m", "position across the sliding direction"),
    FIELD_REALIZATION: Variable((), "1", "surface realization of the fields", "int64"),
}
PROGRESS = {
    "time": Variable(_STEP_DIMS, "s", "time since the start of the ramp"),
    "normal_load": Variable(_STEP_DIMS, "N", "normal load on the pin"),
    "sliding_distance": Variable(_STEP_DIMS, "m", "sliding distance since the start of the ramp"),
}
"""Results at each step that are coordinates of the dataset, equal for all realizations."""
COLUMNS = {
    **PROGRESS,
    "contact_fraction": Variable(_STEP_DIMS, "1", "share of the window in contact"),
    "contact_width": Variable(_STEP_DIMS, "m", "width of the contact along the sliding direction"),
    "max_pressure": Variable(_STEP_DIMS, "Pa", "highest contact pressure"),
    "mean_pressure": Variable(_STEP_DIMS, "Pa", "mean pressure over the contact"),
    "plastic_fraction": Variable(
        _STEP_DIMS, "1", "share of the contact area at the hardness (plastic)"
    ),
    "wear_depth_max": Variable(_STEP_DIMS, "m", "maximum wear depth of the pin"),
    "wear_volume": Variable(_STEP_DIMS, "m^3", "worn volume of the whole pin"),
    "iterations": Variable(_STEP_DIMS, "1", "iterations of the contact solver"),
    "residual": Variable(_STEP_DIMS, "1", "residual of the contact solver"),
    "max_rise": Variable(
        _STEP_DIMS, "K", f"highest temperature rise of the contact {_PER_FRICTION}"
    ),
    "mean_rise": Variable(_STEP_DIMS, "K", f"mean temperature rise of the contact {_PER_FRICTION}"),
    "pin_heat_share": Variable(_STEP_DIMS, "1", "share of the friction heat that enters the pin"),
    "rise_quantile": Variable(
        _QUANTILE_DIMS, "K", f"quantile of the rise of the contact {_PER_FRICTION}"
    ),
}
FIELDS = {
    "pressure": _field("Pa", "contact pressure"),
    "rise": _field("K", f"temperature rise of the pin {_PER_FRICTION}"),
    "wear_depth": _field("m", "wear depth of the pin"),
}
SAMPLING = {
    "rise_realization_std": Variable(
        (*PLANE, "area_fraction_below"),
        "1",
        "standard deviation of ln(rise) between surface realizations; infinite if unknown",
    ),
    "rise_realization_freedom": Variable(
        PLANE, "1", "degrees of freedom of rise_realization_std, 0 if it is unknown"
    ),
}
"""Variables estimated from the contact at the last step."""
FILM = {
    "film_inlet": Variable(
        PLANE, "1/m", "integral over the inlet, from which the pressure of the oil film is computed"
    ),
    "film_pressure": Variable(PLANE, "Pa", "mean pressure of the smooth, worn contact"),
}
"""Variables of the contact at the last step, from which answers compute the oil film."""
ENDS = {
    "end_rise_ratio": Variable(
        (*PLANE, "area_fraction_below"),
        "1",
        "quantile of the rise at the hottest end of the pin over that of the whole pin",
    )
}
"""Variables of a pin that is computed with its ends, at the last step; others do not have them."""
_STATUS_ATTRIBUTES = {
    "flag_values": [NOT_NEEDED, DONE, FAILED, PENDING],
    "flag_meanings": "not_needed done failed pending",
}
_WARNING_ATTRIBUTES = {
    "flag_masks": [int(kind) for kind in WarningKind],
    "flag_meanings": " ".join(kind.label.replace(" ", "_") for kind in WarningKind),
}
RECORDS = {
    "status": Variable(PLANE, None, "state of the point", "int8", _STATUS_ATTRIBUTES),
    "wall_time": Variable(PLANE, "s", "duration of the point's computation"),
    "message": Variable(PLANE, None, "reason for a failure", "str"),
    "warning_flags": Variable(PLANE, None, "kinds of warnings", "int32", _WARNING_ATTRIBUTES),
    "steps": Variable(PLANE, "1", "number of steps of the point", "int32"),
}

INPUTS = "inputs"
"""Variable with the input arrays of a scene, such as measured heights."""
ABOUT, OF_FIELDS, OF_TESTS = "about", "fields", "tests"
"""Zarr groups: facts of the store, fields with their coordinates, points of tests."""
_IN_FIELDS = ("x", "y", FIELD_REALIZATION, *FIELDS)
VARIABLES = COORDINATES | RECORDS | COLUMNS | SAMPLING | FILM | ENDS | FIELDS
"""All variables that a store may have."""
DATA = COLUMNS | SAMPLING | FILM | ENDS | FIELDS
"""All results of a simulation."""


TEST_STEP = "test_step"
"""Dimension of steps at points of tests, whose number may differ from that of the plane."""
AT_TESTS = (
    "status", "message", "warning_flags", "load", "velocity", *FILM,
    *dict.fromkeys((*NEEDED, "max_rise", "rise_quantile")),
)  # fmt: skip
"""Variables at points of tests that answers need."""


def variable_of_tests(name: str) -> str:
    """Name of a variable at the points of tests, in a dataset that also has the plane."""
    return name if name == TEST else f"test_{name}"


def attributes_of(variable: Variable) -> dict[str, Any]:
    """Attributes of a variable in the dataset: meaning, units and further ones."""
    units = {} if variable.units is None else {"units": variable.units}
    return {"long_name": variable.long_name, **units, **variable.attributes}


def path_of(name: str) -> str:
    """Path of a variable in a store; what is for programs is in ``about``."""
    group = ABOUT if name == "message" else OF_FIELDS if name in _IN_FIELDS else ""
    return f"{group}/{name}" if group else name


def is_in_fields(name: str) -> bool:
    """True for a variable of the group ``fields``."""
    return path_of(name).startswith(f"{OF_FIELDS}/")


def is_coordinate(name: str) -> bool:
    """True for a variable without results: a dimension, a column of cases, input arrays."""
    return name in COORDINATES or name not in VARIABLES


def is_of_points(dim: str) -> bool:
    """True for a dimension of points; False for a dimension within points, such as step."""
    return dim not in ("step", TEST_STEP, "area_fraction_below", "x", "y", "input")


def require_free_names(sweep: Sweep) -> None:
    """Raise an `InputError` if a column of the table of cases has the name of a variable.

    The error is also raised if two columns have the same name. A load or a velocity of each row is
    allowed.
    """
    columns = sweep.case_table.columns
    counts = Counter(column.name for column in columns)
    used_names = {INPUTS, *VARIABLES} - {*PLANE}
    for name in (column.name for column in columns if column.along and not column.is_seed):
        if name in used_names or counts[name] > 1:
            raise InputError(
                f"a column of the cases is called {name}, like a variable of the dataset; "
                f'rename it, for example to "{name} of the row"'
            )


def variables_of(sweep: Sweep) -> dict[str, Variable]:
    """All variables that the store of a sweep has, by name."""
    require_free_names(sweep)
    first_row = sweep.case_table.rows[0]
    types = {str: "str", int: "int64", float: "float64"}
    table = {
        column.name: Variable(
            (column.along or column.name,),
            column.unit,
            column.meaning,
            types[type(first_row[column.name])],
            {"display_unit": column.display_unit} if column.display_unit else {},
        )
        for column in sweep.case_table.columns
    }
    plane_dims = {"load": LOAD_FACTOR} if sweep.case_table.load_factors else {}
    if plane_dims:
        table["load"] = table["load"]._replace(dims=(*table["load"].dims, LOAD_FACTOR))
    of_cases, surface = frozenset(table), dict(sweep.surface_with_fields)
    columns = sorted(name for name in of_cases if table[name].dims != (name,))
    absent = {*ROWS, *of_cases}  # the case table has the columns `ROWS`
    absent |= {LOAD_FACTOR} if not plane_dims else set()
    absent |= {*_IN_FIELDS} if not sweep.fields else set()
    absent |= set() if any(has_free_ends(case.scene) for case in sweep.cases) else {*ENDS}
    absent |= {FIELD_REALIZATION} if not surface else set()
    for name, variable in VARIABLES.items():
        if name in absent:
            continue
        is_of_one_surface = name in (*PROGRESS, *FIELDS)
        outer = [dim for dim in sweep.case_table.axes if not (is_of_one_surface and dim in surface)]
        inner = [plane_dims.get(dim, dim) for dim in variable.dims]
        inner = [dim for dim in inner if dim not in of_cases]
        if name in FIELDS and sweep.fields == "steps":
            inner.insert(-2, "step")
        dims = variable.dims if name in COORDINATES else (*outer, *inner)
        table[name] = variable._replace(dims=dims)
    table["status"] = _with_coordinates(table["status"], (*columns, *PROGRESS))
    for name in FIELDS if sweep.fields else ():
        seed = (FIELD_REALIZATION,) if surface else ()
        table[name] = _with_coordinates(table[name], (*columns, *seed))
        # The group has its own copy of each coordinate, so that it can be opened without the root.
        copied_names = (*table[name].dims[:-2], *columns)
        table |= {f"{OF_FIELDS}/{copied}": table[copied] for copied in copied_names}
    if TEST_POINT not in sweep.case_table.axes:
        return table
    return {
        TEST_STEP if name == "step" else name: variable._replace(
            dims=tuple(TEST_STEP if dim == "step" else dim for dim in variable.dims)
        )
        for name, variable in table.items()
    }


def _with_coordinates(variable: Variable, names: Sequence[str]) -> Variable:
    """The variable with the names of coordinates that are no dimensions, by the CF conventions."""
    added = {"coordinates": " ".join(names)} if names else {}
    return variable._replace(attributes={**variable.attributes, **added})


def inputs_variable(sizes: Mapping[str, int]) -> dict[str, Variable]:
    """Variable of the arrays read from a scene's files, concatenated, as {name: variable}.

    It is {} without arrays. `sizes` has the number of values of each array, by SHA-256.
    """
    table = {"digests": " ".join(sizes), "sizes": " ".join(map(str, sizes.values()))}
    meaning = "arrays that the sweep names by their digests, one after the other"
    return {INPUTS: Variable((INPUT_DIM,), None, meaning, attributes=table)} if sizes else {}


def split_arrays(values: Array, attributes: Mapping[str, Any]) -> dict[str, Array]:
    """Split the values of the variable `INPUTS` into its arrays; return them by their SHA-256.

    `values` and the arrays have one dimension. `attributes` are those of the variable: ``digests``
    lists the SHA-256 of each array, and ``sizes`` the number of its values, in the same order.
    """
    digests = str(attributes["digests"]).split()
    ends = np.cumsum([int(size) for size in str(attributes["sizes"]).split()])
    return dict(zip(digests, np.split(np.asarray(values, float), ends[:-1]), strict=True))
