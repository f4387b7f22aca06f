"""State, temperatures and warnings of the simulated points."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field
from typing import Any, Unpack, cast

import numpy as np
import xarray as xr

from pipeline.answers.answer_dataset import answer_attributes, with_attributes
from pipeline.answers.condition_values import override_conditions
from pipeline.answers.results import cases_of, dataset_of, sweeps_of
from pipeline.answers.scene_wording import named_value
from pipeline.answers.verdict_model import conditions_of, verdict_model
from pipeline.condition_kinds import ConditionValues
from pipeline.store.location import PathLike
from pipeline.store.schema import FAILED, PENDING, PLANE
from pipeline.sweep.case import allowable_rise
from tribo import QUANTILES, InputError, WarningKind
from tribo.simulation.point_warnings import SLOW
from tribo.simulation.verdict import columns_needed, corrected_columns
from tribo.thermal.quantiles import failed_share

_MEANINGS = {
    "max_temperature": ("max_rise", "highest temperature of the contact"),
    "mean_temperature": ("mean_rise", "mean temperature of the contact"),
    "temperature_quantile": ("rise_quantile", "quantile of the temperature of the contact"),
}


def points(ds: xr.Dataset | PathLike, **conditions: Unpack[ConditionValues]) -> xr.Dataset:
    """Table of simulated points: mild, severe, failed or pending, on each surface realization.

    Parameters
    ----------
    ds : Dataset, str or path
        Dataset of `pipeline.open_sweep`, or path of a store; of several cases, the first.
    **conditions
        Conditions as in `pipeline.margin`.

    Returns
    -------
    Dataset
        ``state``, which is empty at points that are not simulated; ``warned``, true at points with
        a warning.

    Examples
    --------
    >>> import pipeline
    >>> pipeline.points("results/first_try.zarr")["state"].sel(load=750)[0].values.tolist()
    ['mild', 'severe', 'severe', 'severe', 'severe', 'severe']
    """
    case = cases_of(ds)[0]
    case_conditions = override_conditions(case.conditions, conditions)
    y = case.log_rises(case_conditions)
    model = verdict_model(case, case_conditions)
    failed, pending = (case.status == code for code in (FAILED, PENDING))
    masks = case.done & (y > model.limit), case.done, failed, pending
    state = np.select(masks, ("severe", "mild", "failed", "pending"), "")
    axes = {"load": case.loads, "velocity": case.velocities}
    dims = ("realization", *PLANE)
    states = xr.Dataset({"state": (dims, state), "warned": (dims, case.warning_flags != 0)}, axes)
    return with_attributes(states).assign_attrs(
        answer_attributes(model), missing_points=case.missing
    )


@dataclass(frozen=True, slots=True)
class WarnedPoints:
    """Counts of points that carry a warning, by kind."""

    points: int = 0  #: Points with at least one warning.
    kinds: Mapping[str, int] = field(default_factory=dict)  #: Number of points by kind.
    example: str = ""  #: The first of these points, with its warning.

    def lines(self) -> Iterator[str]:
        """Yield the number of points with each kind of warning, and the first such point."""
        if self.points:
            kinds = ", ".join(f"{kind}: {count}" for kind, count in self.kinds.items())
            carry = "1 point carries" if self.points == 1 else f"{self.points} points carry"
            yield f"warning: {carry} a warning ({kinds})"
            yield f"warning: at {self.example}"


def points_with_warnings(ds: xr.Dataset | PathLike) -> WarnedPoints:
    """Count the points of a sweep that carry a warning, such as too few elements in contact.

    Examples
    --------
    >>> import pipeline
    >>> pipeline.points_with_warnings("results/first_try.zarr").points
    0
    """
    count, counts, example = 0, Counter[WarningKind](), ""
    for case in cases_of(ds):
        flags = case.warning_flags
        count += int(np.count_nonzero(flags))
        counts.update({kind: int(np.count_nonzero(flags & kind)) for kind in WarningKind})
        if flags.any() and not example:
            index, *_ = np.argwhere(flags).tolist()
            kinds = [kind for kind in WarningKind if flags[*index] & kind]
            labels = [SLOW if kind == WarningKind.SLOW_RISE else kind.label for kind in kinds]
            point = f"{case.loads[index[1]]:g} N", f"{case.velocities[index[2]]:g} m/s"
            entries = (named_value(case.ds[name]) for name in case.labels)
            example = f"{', '.join([*point, *entries])}: {'; '.join(labels)}"
    return WarnedPoints(count, {k.label: counts[k] for k in WarningKind if counts[k]}, example)


@np.errstate(under="ignore")
def temperatures(ds: xr.Dataset | PathLike, **conditions: Unpack[ConditionValues]) -> xr.Dataset:
    """Temperatures of the contact at each step of each point.

    Parameters
    ----------
    ds : Dataset, str or path
        Dataset of `pipeline.open_sweep`, a part of it that keeps ``status``, or path of a store. A
        whole large sweep takes much memory: select loads and velocities first.
    **conditions
        Conditions as in `pipeline.margin`, such as ``friction=0.12``.

    Returns
    -------
    Dataset
        ``max_temperature`` and ``mean_temperature`` of the contact [K]; ``temperature_quantile``,
        quantiles of the temperature over the contact area [K]: a share ``area_fraction_below`` of
        it is cooler; and, with a critical temperature, ``failed_area_fraction``, the share of the
        contact area above it.

    Examples
    --------
    >>> import pipeline
    >>> point = pipeline.open_sweep("results/first_try.zarr").sel(load=600, velocity=1.6)
    >>> end = pipeline.end_of_point(point)
    >>> pipeline.temperatures(end)["max_temperature"].round().item()
    441.0
    >>> pipeline.temperatures(end, friction=0.12)["max_temperature"].round().item()
    470.0
    """
    ds = dataset_of(ds)
    if ds["area_fraction_below"].size < len(QUANTILES):
        raise InputError(
            f"the dataset has {ds['area_fraction_below'].size} of {len(QUANTILES)} values of "
            "area_fraction_below; give all, and select from the result"
        )
    parts = list[xr.Dataset]()
    for sweep, part in sweeps_of(ds):
        case_conditions = override_conditions(sweep.conditions, conditions)
        if case_conditions.critical_temperature is None and sweep.base.critical_from_tests:
            case_conditions = conditions_of(cases_of(part)[0], conditions)
        names = {"max_rise", "mean_rise", "rise_quantile", *columns_needed(case_conditions)}
        axes = (*part["status"].dims, "step", "area_fraction_below")
        variables = {
            name: part[name].broadcast_like(part["status"]).transpose(*axes, missing_dims="ignore")
            for name in names
        }
        rises = corrected_columns(
            {name: variable.values for name, variable in variables.items()}, case_conditions
        )
        answer = xr.Dataset()
        for name, (rise, meaning) in _MEANINGS.items():
            answer[name] = variables[rise].copy(
                data=case_conditions.contact_temperature(rises[rise])
            )
            answer[name].attrs = {"units": "K", "long_name": meaning}
        if case_conditions.critical_temperature is not None:
            compute_share = np.vectorize(failed_share, excluded=[1], signature="(q)->()")
            share = compute_share(rises["rise_quantile"], allowable_rise(case_conditions))
            share = np.where(np.isnan(rises["max_rise"]), np.nan, share)
            meaning = "share of the contact above the critical temperature"
            about_share = {"units": "1", "long_name": meaning}
            answer["failed_area_fraction"] = variables["max_rise"].copy(data=share)
            answer["failed_area_fraction"].attrs = about_share
        parts.append(answer)
    joined: Any = parts[0] if len(parts) == 1 else xr.combine_by_coords(parts)
    return cast(xr.Dataset, joined)
