"""Choose the point that a figure shows, and draw its pressure, temperature and wear."""

from __future__ import annotations

import functools
import math
import warnings
from collections.abc import Iterable, Mapping
from typing import Any, NamedTuple

import numpy as np
import xarray as xr
from matplotlib.figure import Figure

from pipeline.answers.case_results import CaseResults
from pipeline.answers.condition_values import argument_array
from pipeline.answers.results import cases_of, refuse_cases, sweep_of
from pipeline.answers.scene_wording import heating_words
from pipeline.answers.verdict_model import conditions_of, outside_reason
from pipeline.arguments import in_load_or_velocity
from pipeline.figures import style
from pipeline.quantities import ROUNDING, UNITS, in_unit
from pipeline.store.dataset import fields_of
from pipeline.store.schema import COLUMNS, FIELDS
from pipeline.sweep.case import Conditions, allowable_rise
from tribo import InputError
from tribo.simulation.verdict import columns_needed, corrected_columns
from tribo.types import Array

QuantityLike = float | str | Iterable[float | str] | None
"""Loads or velocities to show, in SI or as text with a unit; None for those near the transition."""
PointIndex = tuple[int, int]
"""Indices of a point along load and velocity."""
_COLOUR_BAR_HEIGHT = 0.12  # height of a colour bar, and of the gap below it [in]
_STACKING_WIDTH = 4.7  # width of a figure below which its panels are stacked [in]


class DrawnCase(NamedTuple):
    """One surface realization of one case, and the conditions of a figure of it."""

    case: CaseResults
    conditions: Conditions

    def values(self, name: str) -> Array:
        """Values of a variable (load, velocity, ...)."""
        return np.asarray(self.case.array(name)[0])

    def columns(self) -> Mapping[str, Any]:
        """Corrected rises, and all other variables by step (load, velocity, step)."""
        names = [name for name in COLUMNS if name in self.case.ds]
        return corrected_columns({name: self.values(name) for name in names}, self.conditions)

    def point_text(self, point: PointIndex) -> str:
        """Load and velocity of a point, such as "750 N, 1.25 m/s"."""
        return f"{self.case.loads[point[0]]:g} N, {self.case.velocities[point[1]]:g} m/s"

    def rises(self, conditions: Conditions) -> Array:
        """Rises at the points (load, velocity) [K]; NaN at points that are not done."""
        return np.asarray(np.exp(self.case.log_rises(conditions)[0]))

    def title(self, *lines: str) -> str:
        """Title of the sweep, with further lines below it."""
        return "\n".join([style.as_text(self.case.sweep.title), *lines])


def drawn_case(ds: xr.Dataset, conditions: Mapping[str, Any], realization: int | None) -> DrawnCase:
    """The surface realization of a sweep for a figure; by default the one with stored fields."""
    refuse_cases(ds)
    if realization is None and "realization" in ds["status"].dims:
        seeds = ds["realization"].values.tolist()
        field_seed = dict(sweep_of(ds).surface_with_fields).get("realization")
        realization = seeds[seeds.index(field_seed)] if field_seed in seeds else seeds[0]
    case = cases_of(select_realization(ds, realization))[0]
    return DrawnCase(case, conditions_of(case, conditions))


def select_realization(ds: xr.Dataset, realization: int | None) -> xr.Dataset:
    """The dataset of one surface realization, by its seed; unchanged for None."""
    if realization is None:
        return ds
    if "realization" in ds.coords:
        seeds = np.atleast_1d(ds["realization"].values).tolist()
    else:  # a sweep of a single surface
        seed = getattr(sweep_of(ds).scene.roughness, "seed", None)
        seeds = [] if seed is None else [seed]
    if realization not in seeds:
        surfaces = ", ".join(map(str, seeds)) or "a single surface without a number"
        raise InputError(f"realization {realization} is not in the sweep, which has {surfaces}")
    is_dimension = "realization" in ds["status"].dims
    return ds.sel(realization=[realization]) if is_dimension else ds


def chosen_points(drawn: DrawnCase, load: QuantityLike, velocity: QuantityLike) -> list[PointIndex]:
    """Indices (load, velocity) of the points that a figure shows.

    They are the points nearest to each pair of a load and a velocity. By default the load is the
    highest with a computed point, and the velocity is the nearest to the transition, or without a
    transition the hottest one. Raises an `InputError` if a point is not done.
    """
    case, conditions = drawn.case, drawn.conditions
    rises = drawn.rises(conditions)
    is_done = np.isfinite(rises)
    highest_done_load = np.flatnonzero(is_done.any(axis=1))[-1:].tolist()
    limit, points = math.inf, list[PointIndex]()
    if conditions.critical_temperature is not None:
        limit = allowable_rise(conditions)
    for row in nearest_indices(case, "load", load) or highest_done_load or [0]:
        if not is_done[row].any():
            raise InputError(
                f"no point at {case.loads[row]:g} N is done; choose another load, or continue with "
                "irg run"
            )
        distance = np.abs(rises[row] - min(limit, np.nanmax(rises[row])))
        columns = nearest_indices(case, "velocity", velocity) or [int(np.nanargmin(distance))]
        points += [(row, column) for column in columns]
    for point in points:
        if not is_done[point]:
            raise InputError(
                f"the point {drawn.point_text(point)} is not done; choose another load or "
                "velocity, or continue with irg run; irg status prints why a point failed"
            )
    return points


def values_in_si(axis: str, values: Any) -> list[float]:
    """Loads or velocities of an option, in SI; an empty list without any."""
    if values is None or not np.size(values):
        return []
    read = functools.partial(in_load_or_velocity, axis)
    numbers: list[float] = argument_array(axis, values, read, axis).values.ravel().tolist()
    return numbers


def nearest_indices(case: CaseResults, axis: str, values: QuantityLike) -> list[int]:
    """Indices of the loads or velocities of a case nearest to `values`; empty for None.

    Warns of a value that is not simulated.
    """
    simulated = case.loads if axis == "load" else case.velocities
    ends = {axis: (simulated[0].item(), simulated[-1].item())}
    indices, unit = list[int](), UNITS[axis]
    for value in values_in_si(axis, values):
        if refusal := outside_reason(case, ends, **{axis: value}):
            raise InputError(refusal)
        index = int(np.abs(simulated - value).argmin())
        indices.append(index)
        nearest = simulated[index].item()
        if not math.isclose(nearest, value, rel_tol=ROUNDING):
            warnings.warn(
                f"{axis} {value:g} {unit} is not simulated; the figure shows {nearest:g} {unit}",
                stacklevel=2,
            )
    return indices


@style.house_style
def fields(
    ds: xr.Dataset,
    conditions: Mapping[str, Any],
    load: float | str | None = None,
    velocity: float | str | None = None,
    realization: int | None = None,
    step: int = 0,
) -> Figure:
    """Draw pressure, temperature and wear depth over the contact at a step of one point.

    The sweep's point nearest to `load` and `velocity` is drawn; both are in SI or text with a
    unit. By default the load is the highest with a computed point, and the velocity is the nearest
    to the transition. `realization` is the seed of the surface; by default the first one. `step`
    counts back from the end of the point, which is 0. In a figure as narrow as a journal's column
    the panels are stacked.
    """
    if (stored_fields := fields_of(ds)) is None:
        raise InputError(
            "the store has no fields; set 'fields = true' under [sweep], and run the scene into "
            "another store"
        )
    drawn = drawn_case(ds, conditions, realization)
    point, *more_points = chosen_points(drawn, load, velocity)
    if more_points:
        raise InputError(f"fields shows one point, not {1 + len(more_points)}; give one")
    _require_step(drawn, stored_fields, point, step)
    fields_at_step = _fields_at(drawn, stored_fields, point, step)
    x, y = (in_unit(stored_fields[axis].values, "µm") for axis in "xy")
    figure, panels, height = _empty_panels(np.ptp(y) / np.ptp(x))
    labels = "contact pressure [GPa]", "contact temperature [°C]", "wear depth of the pin [µm]"
    colour_maps = "viridis_r", "inferno", "cividis_r"  # bright where hot; dark where pressed, worn
    for axes, label, field, colours in zip(
        panels, labels, fields_at_step, colour_maps, strict=True
    ):
        image = axes.pcolormesh(x, y, field.T, cmap=colours, shading="nearest", rasterized=True)
        axes.set_aspect("equal" if len(y) > 1 else "auto")
        axes.grid(visible=False)
        axes.set(xlabel="x, along sliding [µm]", ylabel="y [µm]")
        axes.label_outer()
        bar = axes.inset_axes((0, 1 + _COLOUR_BAR_HEIGHT / height, 1, _COLOUR_BAR_HEIGHT / height))
        figure.colorbar(image, cax=bar, label=label, location="top")
    if (critical := drawn.conditions.critical_temperature) is not None and len(y) > 1:
        limit, temperature, axes = in_unit(critical, "°C"), fields_at_step[1], panels[1]
        if temperature.min() < limit < temperature.max():
            axes.contour(x, y, temperature.T, [limit], colors=style.SKY, linewidths=style.THIN)
            axes.child_axes[0].set_xlabel(f"{labels[1]}; outline at {limit:g}")
    step_text = drawn.point_text(point)
    if step:
        load_at_step = drawn.values("normal_load")[point][step - 1]
        step_text = f"{drawn.point_text(point)}, step {step} at {load_at_step:g} N"
    lines = [f"{step_text}, {heating_words(drawn.conditions)}"]
    scene = drawn.case.sweep.scene
    if scene.wears_by_strips or scene.sweeps_over:
        lines.append("at one position of the disk; verdicts use the mean over several positions")
    style.write_title(figure, drawn.title(*lines))
    return figure


def _empty_panels(aspect: float) -> tuple[Figure, Any, float]:
    """Figure, three panels for fields of an `aspect` (y over x), and their height [in]."""
    is_stacked = style.width_or(_STACKING_WIDTH) < _STACKING_WIDTH
    height = float(np.clip(3.3 * aspect, 0.5, 2.6 if is_stacked else 6.0))
    if is_stacked:
        figure = style.Picture((4.6, 1.0 + 3 * (1.4 + height)))
        return figure, figure.subplots(3, 1, sharex=True, sharey=True), height
    figure = style.Picture((11.0, 0.5 + (1.4 + height)))
    return figure, figure.subplots(1, 3, sharex=True, sharey=True), height


def _require_step(
    drawn: DrawnCase, stored_fields: xr.Dataset, point: PointIndex, step: int
) -> None:
    """Raise an `InputError` unless the fields at a `step` of a point are stored."""
    known_steps = np.flatnonzero(np.isfinite(drawn.values("contact_fraction")[point]))
    steps = (known_steps - drawn.case.ds.sizes["step"] + 1).tolist()
    if "step" not in stored_fields["pressure"].dims and step:
        raise InputError(
            f"step is {step}, and the store has only the fields at the end of each point; set "
            "'fields = \"steps\"' under [sweep] in the scene, and run it into another store"
        )
    if step not in steps:
        raise InputError(f"step is {step}; the point has the steps {steps[0]} to 0")


def _fields_at(
    drawn: DrawnCase, stored_fields: xr.Dataset, point: PointIndex, step: int
) -> tuple[Array, Array, Array]:
    """Pressure [GPa], temperature [°C] and wear depth [µm] (x, y) at a step of a point.

    Raises an `InputError` if they are not stored.
    """
    case, coords, conditions = drawn.case, drawn.case.ds.coords, drawn.conditions
    surface = case.sweep.surface_with_fields
    if any(dim in coords and coords[dim].item() != label for dim, label in surface):
        raise InputError(
            "no fields are stored for this point: a store keeps those of one surface realization; "
            "leave out the realization"
        )
    load, velocity = case.loads[point[0]], case.velocities[point[1]]
    labels = {**dict(case.name), "load": load, "velocity": velocity, "step": step}
    stored_labels = {dim: labels[dim] for dim in stored_fields["pressure"].dims if dim in labels}
    try:
        arrays = stored_fields[[*FIELDS]].sel(stored_labels)
    except KeyError as error:
        raise InputError(
            f"no fields are stored for {drawn.point_text(point)}; choose a load and a velocity of "
            "the sweep"
        ) from error
    arrays = arrays.squeeze([dim for dim in arrays.dims if dim not in ("x", "y")])
    arrays = arrays.transpose("x", "y")
    rise = arrays["rise"].values
    if conditions.corrections:
        # A correction is linear in the rise, so two of its values give those of all elements.
        columns = {name: drawn.values(name)[point] for name in columns_needed(conditions)}
        columns["rise_quantile"] = np.tile([0.0, 1.0], (len(columns["time"]), 1))
        at_zero, at_one = corrected_columns(columns, conditions)["rise_quantile"][step - 1]
        rise = at_zero + (at_one - at_zero) * rise
    return (
        np.ma.masked_equal(in_unit(arrays["pressure"].values, "GPa"), 0.0),
        in_unit(conditions.contact_temperature(rise), "°C"),
        np.ma.masked_equal(in_unit(arrays["wear_depth"].values, "µm"), 0.0),
    )
