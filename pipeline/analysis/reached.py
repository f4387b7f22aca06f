"""What a run with a goal has reached: the numerical error of the boundary, part by part."""

from __future__ import annotations

from collections.abc import Iterator
from typing import NamedTuple

import numpy as np
import xarray as xr

from pipeline.analysis.at import asked_at
from pipeline.analysis.rise_error import SURFACE, velocity_errors
from pipeline.analysis.rises import rises_of

_PARTS = "points left out", "preset", "warned points", "surface"
_HELP = {"points left out": "; give more sweep.velocities and sweep.loads"}
"""What reduces the largest part of an error that is too large, beside another accuracy."""


class Reached(NamedTuple):
    """Largest numerical error of the critical velocities of one scene, relative, at 95 %."""

    case: str  # values of varied entries that tell the scene from others
    load: float  # where the error is largest [N]; NaN if no load has a critical velocity
    total: float  # without the part by the surface, unless it counts
    parts: dict[str, float]  # at this load, by cause
    surface: float  # largest part by the surface at any load
    without: tuple[float, ...]  # loads without a critical velocity in the plane [N]

    def lines(self, accuracy: float, surface: str) -> Iterator[str]:
        """Lines in words; `surface` says why its part does not count, or is empty."""
        case = f"{self.case}: " if self.case else ""
        if np.isfinite(self.load):
            # NaN, an unknown error, is not reached either.
            state = "reached" if self.total < accuracy else "not reached"
            counted = {
                k: x for k, x in self.parts.items() if x and not (surface and k == "surface")
            }
            parts = ", ".join(f"{name} {percent(part)}" for name, part in counted.items())
            largest = max(counted, key=lambda name: np.nan_to_num(counted[name]), default="")
            advice = "" if state == "reached" else _HELP.get(largest, "")
            yield (
                f"{case}accuracy {percent(accuracy)} {state}: at most ± {percent(self.total)}, at "
                f"{self.load:g} N ({parts}){advice}"
            )
            if surface and self.surface:
                yield f"surface up to ± {percent(self.surface)}: {surface}"
        if self.without:
            loads = ", ".join(f"{load:g}" for load in self.without)
            yield f"{case}no critical velocity in the plane at {loads} N"


def percent(share: float) -> str:
    """A share as text, such as "1.5 %"."""
    return "not known" if np.isnan(share) else f"{100 * share:.3g} %"


def reached(ds: xr.Dataset, counts_surface: bool) -> list[Reached]:
    """What was reached for each scene of a dataset."""
    data, found = asked_at(ds, {}), list[Reached]()
    for scene, name in zip(data.scenes, data.sweep.variants.given, strict=True):
        rises = rises_of(scene)
        critical = rises.turns("velocity", rises.loads).critical
        errors = velocity_errors(rises, rises.loads, critical)
        counted = errors if counts_surface else np.delete(errors, SURFACE, axis=0)
        totals = np.sqrt(np.square(counted).sum(axis=0))
        crosses = np.isfinite(critical)
        ranked = np.where(crosses, np.where(np.isnan(totals), np.inf, totals), -np.inf)
        worst = int(np.argmax(ranked))
        own = data.sweep.variants.in_words(name)
        found.append(
            Reached(
                case=", ".join(f"{key} {value}" for key, value in own.items()),
                load=float(rises.loads[worst]) if crosses.any() else np.nan,
                total=float(totals[worst]),
                parts=dict(zip(_PARTS, errors[:, worst].tolist(), strict=True)),
                surface=float(errors[SURFACE].max(where=crosses, initial=0.0)),
                without=tuple(rises.loads[~crosses].tolist()),
            )
        )
    return found
