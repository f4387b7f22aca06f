"""The command that says how far an operating point lies from severe wear."""

from __future__ import annotations

import argparse
from collections.abc import Iterator, Sequence
from typing import TYPE_CHECKING, Any

import numpy as np

import pipeline
from pipeline.cli.output import DONE, show
from pipeline.cli.scenes import CONDITIONS, given

if TYPE_CHECKING:
    from pipeline.analysis.margin import Margin

_BAND = (0.1, 0.5, 0.9)  # shares of the surfaces that lie lower


def margin(options: argparse.Namespace) -> int:
    """Print the distance of an operating point to the boundary."""
    ds, conditions = pipeline.open_sweep(options.store), given(options, *CONDITIONS)
    found = pipeline.margins(ds, options.load, options.velocity, **conditions)
    warned = pipeline.warned(ds, **conditions)
    judged = found[0].as_dict() if len(found) == 1 else _document(found)
    text = _on_one(found[0]) if len(found) == 1 else _on_several(found)
    show(options, judged | {"warnings": warned.as_dict()}, [*text, *warned.lines()])
    return DONE


def _on_one(found: Margin) -> Iterator[str]:
    """Say how one surface stands."""
    verdict = "severe wear" if found.is_severe else "mild wear"
    unsure = {True: "", False: ", but within the error", None: ""}[found.is_certain]
    yield f"{found.load:g} N at {found.velocity:g} m/s: {verdict}{unsure}"
    yield (
        f"  deciding temperature  {pipeline.display(found.decisive_temperature, '°C', 4)}"
        f"{_error(found.temperature_error)}"
    )
    side = "above" if found.is_severe else "below"
    critical = pipeline.display(found.critical_temperature, "°C", 4)
    yield f"  distance              {abs(found.distance):.1f} K {side} {critical}"
    for name, unit, factor, critical_value, outcome, ends in (
        (
            "velocity", "m/s", found.velocity_factor, found.critical_velocity,
            found.velocity_outcome, found.velocity_range,
        ),
        (
            "load", "N", found.load_factor, found.critical_load,
            found.load_outcome, found.load_range,
        ),
    ):  # fmt: skip
        way = (
            f"{factor:.3g} times, severe from {critical_value:.4g} {unit} on"
            if outcome == "crosses"
            else f"{outcome}, from {ends[0]:.4g} to {ends[1]:.4g} {unit}"
        )
        yield f"  in {name:<19}{way}"


def _error(error: float | None) -> str:
    if error == 0:
        return ", at a point of the sweep"
    if error is None:
        return ", from too few points about it to tell its error"
    return f" ± {error:.2g} K, interpolated between points of the sweep"


def _kind(found: Sequence[Margin]) -> str:
    """What there are several of."""
    return "surfaces" if found[0].sample is None else "samples"


def _document(found: Sequence[Margin]) -> dict[str, Any]:
    """Plain data on several surfaces."""
    return {
        "load": found[0].load,
        "velocity": found[0].velocity,
        f"severe_{_kind(found)}": sum(each.is_severe for each in found),
        _kind(found): [each.as_dict() for each in found],
    }


def _on_several(found: Sequence[Margin]) -> Iterator[str]:
    """Say how several surfaces stand: the median, and the range without a tenth at either end."""
    severe = sum(each.is_severe for each in found)
    yield (
        f"{found[0].load:g} N at {found[0].velocity:g} m/s: severe wear on {severe} of "
        f"{len(found)} {_kind(found)}"
    )
    low, middle, high = np.quantile([each.decisive_temperature - 273.15 for each in found], _BAND)
    yield f"  deciding temperature  {middle:.4g} °C, on 80 % of them {low:.4g} to {high:.4g} °C"
    criticals = {each.critical_temperature for each in found}
    critical = "the critical temperature of each"
    if len(criticals) == 1:
        critical = pipeline.display(criticals.pop(), "°C", 4)
    low, middle, high = np.quantile([each.distance for each in found], _BAND)
    yield f"  distance              {middle:.1f} K below {critical}, {low:.1f} to {high:.1f} K"
    for name, factors, outcomes in (
        ("velocity", [m.velocity_factor for m in found], [m.velocity_outcome for m in found]),
        ("load", [m.load_factor for m in found], [m.load_outcome for m in found]),
    ):
        if set(outcomes) == {"crosses"}:
            low, middle, high = np.quantile(factors, _BAND)
            yield f"  in {name:<19}{middle:.3g} times, {low:.3g} to {high:.3g}"
        else:
            counts = {what: outcomes.count(what) for what in sorted(set(outcomes))}
            told = ", ".join(f"{number} {what}" for what, number in counts.items())
            yield f"  in {name:<19}of {len(found)} {_kind(found)} {told}"
