"""A boundary as a document and in words, as ``irg boundary`` prints it."""

from __future__ import annotations

import math
from collections.abc import Iterator
from typing import TYPE_CHECKING, Any

import pipeline

if TYPE_CHECKING:
    import xarray as xr

_NO_CROSSING = {1: "mild throughout", 2: "severe from the lowest", 3: "not known yet"}
_OUTCOMES = {0: "crosses"} | _NO_CROSSING
_BOUNDARIES = (
    ("critical_velocity", "load", "  load [N]   critical velocity [m/s]"),
    ("critical_load", "velocity", "  velocity [m/s]   critical load [N]"),
)


def document_of(found: xr.Dataset) -> dict[str, Any]:
    """Plain data of `pipeline.boundary`."""
    conditions = ("bulk_temperature", "critical_temperature", "failing_share")
    frictions = _frictions(found)
    shown = ["load", "critical_velocity", "velocity", "critical_load"]
    if "realization" in found.dims:
        shown += ["realization", "quantile"]
        for name, axis, _ in _BOUNDARIES:
            shown += [f"{name}_{kind}" for kind in ("mean", "spread", "quantile")]
            shown += [f"crossing_at_{axis}", f"known_at_{axis}"]
    return (
        {
            "conditions": {"friction": frictions if "friction" in found.dims else frictions[0]}
            | {name: found.attrs[name] for name in conditions},
            "missing_points": found.attrs["missing_points"],
        }
        | {name: found[name].values.tolist() for name in shown}
        | {
            f"{name}_outcome": _worded(found[f"outcome_at_{axis}"].values.tolist())
            for name, axis, _ in _BOUNDARIES
        }
    )


def _worded(outcomes: Any) -> Any:
    """Outcomes in words, in lists as deep as theirs."""
    if isinstance(outcomes, list):
        return [_worded(outcome) for outcome in outcomes]
    return _OUTCOMES[outcomes]


def text_of(found: xr.Dataset) -> Iterator[str]:
    """Lines of text on `pipeline.boundary`; a column or block for each friction."""
    frictions = ", ".join(f"{value:g}" for value in _frictions(found))
    yield (
        f"friction {frictions}, "
        f"bulk {pipeline.display(found.attrs['bulk_temperature'], '°C')}, "
        f"critical {pipeline.display(found.attrs['critical_temperature'], '°C')}, "
        f"failing share {found.attrs['failing_share']:g}"
    )
    several = "realization" in found.dims
    parts = _by_friction(found) if several else [("", found)]
    for name, axis, heading in _BOUNDARIES:
        for friction, part in parts:
            yield ""
            yield heading + friction
            yield from (_band if several else _columns)(part, name, axis)
    if missing := found.attrs["missing_points"]:
        yield ""
        yield f"{missing} points are pending or failed and were left out"


def _frictions(found: xr.Dataset) -> list[float]:
    if "friction" not in found.dims:
        return [found.attrs["friction"]]
    return [float(value) for value in found["friction"].values]


def _by_friction(found: xr.Dataset) -> list[tuple[str, xr.Dataset]]:
    if "friction" not in found.dims:
        return [("", found)]
    return [(f" at friction {value:g}", found.sel(friction=value)) for value in _frictions(found)]


def _columns(found: xr.Dataset, name: str, axis: str) -> Iterator[str]:
    """Where one surface crosses, a column for each friction."""
    several = "friction" in found.dims
    if several:
        heads = "".join(f"{f'{value:g}':<24}" for value in _frictions(found))
        yield f"{'friction':>10}   {heads}".rstrip()
    for place in range(found.sizes[axis]):
        cells = []
        for _, part in _by_friction(found):
            at = part.isel({axis: place})
            why = int(at[f"outcome_at_{axis}"])
            cells.append(_NO_CROSSING.get(why, f"{float(at[name]):.4g}"))
        row = "".join(f"{cell:<24}" for cell in cells)
        yield f"{float(found[axis][place]):10g}   {row}".rstrip()


def _band(found: xr.Dataset, name: str, axis: str) -> Iterator[str]:
    """Median, lower and upper end of the band, mean and spread, and how many surfaces cross."""
    ends = [f"{100 * share:g} %" for share in found["quantile"].values]
    heads = ("median", ends[0], ends[-1], "mean", "spread")
    yield f"{'':10}   {' '.join(f'{head:>8}' for head in heads)}   surfaces"
    for place in range(found.sizes[axis]):
        at = found.isel({axis: place})
        low, middle, high = at[f"{name}_quantile"].values
        values = (middle, low, high, float(at[f"{name}_mean"]), float(at[f"{name}_spread"]))
        cells = (f"{value:.4g}" if math.isfinite(value) else "-" for value in values)
        outcomes = at[f"outcome_at_{axis}"].values.tolist()
        counts = [f"{outcomes.count(0)} of {len(outcomes)} cross"]
        counts += [
            f"{outcomes.count(why)} {meaning}"
            for why, meaning in _NO_CROSSING.items()
            if why in outcomes
        ]
        row = " ".join(f"{cell:>8}" for cell in cells)
        yield f"{float(at[axis]):10g}   {row}   {', '.join(counts)}"
