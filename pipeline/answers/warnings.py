"""Points of a sweep that carry a warning.

Most warnings are stored by the run. Two are found here: steel would melt under the conditions, and
the rise grows slowly with velocity. The relative error of a critical velocity is that of the rise
over the exponent n of rise ∝ Vⁿ. Below n = 0.3 this error was 5 to 8 % with preset `standard`.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field
from typing import Unpack

import numpy as np
import xarray as xr

from pipeline.answers.conditions import ConditionValues, judged
from pipeline.answers.results import CaseResults, cases_of
from pipeline.answers.units import named_value
from pipeline.constants import APART_FOR_EXPONENT
from pipeline.quantities import display
from pipeline.store.place import PathLike
from pipeline.sweep.conditions import Conditions
from pipeline.words import remarks
from tribo import WarningKind
from tribo.constants import SLOWEST
from tribo.simulation.point_warnings import SLOW
from tribo.types import Array, Indices

MELTS = 1700.0  # K, at which a steel with 1 % carbon begins to melt
MOLTEN = (
    f"the governing temperature is above {display(MELTS, '°C', '.0f')}, where steel melts: the "
    "conditions are not possible"
)


@dataclass(frozen=True, slots=True)
class WarnedPoints:
    """Counts of points that carry a warning, by kind."""

    points: int = 0  #: Points with at least one warning.
    kinds: Mapping[str, int] = field(default_factory=dict)  #: Number of points by kind.
    example: str = ""  #: The first of these points, with its warning.

    def lines(self) -> Iterator[str]:
        """Yield how many points carry each kind of warning, and the first such point."""
        if self.points:
            kinds = ", ".join(f"{kind}: {count}" for kind, count in self.kinds.items())
            carry = "1 point carries" if self.points == 1 else f"{self.points} points carry"
            yield from remarks("warning", f"{carry} a warning ({kinds})", f"at {self.example}")


def points_with_warnings(
    ds: xr.Dataset | PathLike, **conditions: Unpack[ConditionValues]
) -> WarnedPoints:
    """Count the points of a sweep that carry a warning, such as too few elements in contact.

    One kind, "molten", says that steel would melt under the conditions.

    Examples
    --------
    >>> import pipeline
    >>> pipeline.points_with_warnings("results/first_try.zarr").points
    0
    >>> pipeline.points_with_warnings("results/first_try.zarr", friction=2.0).kinds
    {'molten': 22}
    """
    points, kinds, example = 0, dict[str, int](), ""
    for case in cases_of(ds):
        flags = warning_flags(case)
        plain = judged(case.sweep.conditions, conditions)
        molten = case.done & (case.log_rises(plain) > math.log(max(plain.limit(MELTS), 1e-9)))
        flags = flags | molten * int(WarningKind.MOLTEN)
        points += int(np.count_nonzero(flags))
        for kind in WarningKind:
            if count := int(np.count_nonzero(flags & kind)):
                kinds[kind.label] = kinds.get(kind.label, 0) + count
        if flags.any() and not example:
            realization, i, j = np.argwhere(flags)[0].tolist()
            texts = {WarningKind.SLOW_RISE: SLOW, WarningKind.MOLTEN: MOLTEN}
            flag = flags[realization, i, j]
            said = [texts.get(kind, kind.label) for kind in WarningKind if flag & kind]
            own = [named_value(case.ds[name]) for name in case.labels]
            place = ", ".join([f"{case.loads[i]:g} N", f"{case.velocities[j]:g} m/s", *own])
            example = f"{place}: {'; '.join(said)}"
    return WarnedPoints(points, kinds, example)


def warning_flags(case: CaseResults) -> Indices:
    """Sums of `WarningKind` codes (m, n_load, n_velocity): the stored ones, and ``SLOW_RISE``."""
    flags = np.where(case.done, case.array("warning_flags"), 0).astype(int)
    if not case.sweep.scene.friction_heat:
        return flags
    share = case.sweep.conditions.critical_area_fraction
    rises = case.log_rises(Conditions(1.0, 300.0, critical_area_fraction=share))
    slow = np.apply_along_axis(
        lambda y: _exponents(np.log(case.velocities), y) < SLOWEST, -1, rises
    )
    return np.asarray(flags | slow * int(WarningKind.SLOW_RISE))


def _exponents(x: Array, y: Array) -> Array:
    """Slope at each point of a curve y(x), from neighbours around it; NaN without any."""
    result, known = np.full(x.shape, np.nan), np.flatnonzero(np.isfinite(y))
    x, y, least = x[known], y[known], math.log(APART_FOR_EXPONENT)
    low = np.maximum(np.searchsorted(x, x - least, "right") - 1, 0)
    high = np.minimum(np.searchsorted(x, x + least), len(known) - 1)
    apart = x[high] - x[low] >= least
    result[known[apart]] = ((y[high] - y[low]) / np.where(apart, x[high] - x[low], 1))[apart]
    return result
