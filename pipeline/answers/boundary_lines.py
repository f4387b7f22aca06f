"""Sentences on a boundary: what is probable for the next specimen, tests, and errors."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np
import xarray as xr

from pipeline.answers.answer_lines import (
    common_lines,
    model_error_line,
    not_included_lines,
    withheld_lines,
)
from pipeline.answers.digits import rounded_value
from pipeline.answers.readable import outcome_texts
from pipeline.messages import split_notes
from tribo.types import Array

_MIN_SHIFT = 0.05  # relative shift of the boundary by tests above which it is stated
_VELOCITIES = {
    (True, True): "{p50} at {load:g} N (5 %: {p05} m/s, 95 %: {p95} m/s)",
    (True, False): "{p50} at {load:g} N (5 %: {p05} m/s)",
    (False, True): "{p50} at {load:g} N (95 %: {p95} m/s)",
    (False, False): "{p50} at {load:g} N",
}
"""Velocities at which severe wear is probable, by whether 5 and 95 % lie within the sweep."""


def boundary_lines(answer: xr.Dataset) -> Iterator[str]:
    """Lines below a boundary: effects not included, errors, tests, missing points."""
    yield from not_included_lines(answer)
    yield from ruling_lines(answer)
    yield from error_lines(answer)
    yield from shift_lines(answer)
    yield from common_lines(answer)


def closing_lines(answer: xr.Dataset) -> Iterator[str]:
    """Lines on a boundary after a run: the next specimen, tests, and effects not included."""
    yield next_run_line(answer)
    yield from ruling_lines(answer)
    yield from withheld_lines(answer)
    yield from not_included_lines(answer)


def next_run_line(answer: xr.Dataset) -> str:
    """Sentence on the velocities at which severe wear is 5, 50 and 95 % probable.

    It states them at the lowest and the highest load with a known outcome. If no load has such a
    velocity and all have the same outcome, it states the outcome.
    """
    outcomes = outcome_texts(answer, "velocity").tolist()
    if not any(outcomes):
        return "there is no boundary, as the sweep has a single velocity"
    if len({*outcomes}) == 1 and not answer["critical_velocity_p50"].notnull().any():
        is_of_wear = outcomes[0].startswith(("mild", "severe"))
        return f"wear is {outcomes[0]}" if is_of_wear else f"the boundary is {outcomes[0]}"
    pairs = zip(answer["load"].values.tolist(), outcomes, strict=True)
    loads = [load for load, outcome in pairs if not outcome.startswith("unknown")]
    texts = [_velocities(answer.sel(load=load)) for load in dict.fromkeys((loads[0], loads[-1]))]
    return f"severe wear is 50 % probable at {'; at '.join(texts)}"


def _velocities(at_load: xr.Dataset) -> str:
    """Velocities at a load at which severe wear is 50 % probable, and 5 and 95 %, if known."""
    names = "p05", "p50", "p95"
    texts = {name: rounded_value(at_load, f"critical_velocity_{name}") for name in names}
    template = _VELOCITIES[bool(texts["p05"]), bool(texts["p95"])]
    texts["p50"] = f"{texts['p50']} m/s" if texts["p50"] else "no velocity in the sweep"
    return template.format(load=at_load["load"].item(), **texts)


def ruling_lines(answer: xr.Dataset) -> Iterator[str]:
    """Lines on the tests that limit the velocities at which wear is mild, or severe."""
    texts, loads = xr.broadcast(answer["ruled_out_by"], answer["load"])
    loads_of = dict[str, list[float]]()
    for cell, load in zip(texts.values.ravel(), loads.values.ravel().tolist(), strict=True):
        for text in split_notes([cell]):
            loads_of.setdefault(text, []).append(load)
    for text, ruled_loads in loads_of.items():
        ends = dict.fromkeys(f"{load:g}" for load in (min(ruled_loads), max(ruled_loads)))
        yield f"at {' to '.join(ends)} N, {text}"


_TOO_FEW_GROOVES = (
    "numerical error unknown at {} of {} critical velocities: one surface realization has too few "
    "independent grooves; simulate several (sweep.realizations)"
)


def error_lines(answer: xr.Dataset) -> Iterator[str]:
    """Lines on the numerical error of a boundary and on the model error."""
    errors, surface = (answer[name].values for name in ("velocity_error", "velocity_error_surface"))
    is_critical = answer["critical_velocity"].notnull().values
    lacks_grooves = is_critical & np.isnan(surface)
    if not is_critical.any():
        yield "numerical error: not stated, as no critical velocity lies within the sweep"
    elif not np.isfinite(errors).any():
        if not lacks_grooves.any():
            yield "numerical error of the critical velocity: unknown"
    elif np.nanmax(surface):
        yield (
            f"numerical error (95 %): ± {_percents(errors)} of the critical velocity, of which "
            f"surface sampling {_percents(surface)}"
        )
    else:
        yield f"numerical error (95 %): ± {_percents(errors)} of the critical velocity"
    if lacks_grooves.any():
        yield _TOO_FEW_GROOVES.format(lacks_grooves.sum(), is_critical.sum())
    yield model_error_line(answer)


def _percents(values: Array) -> str:
    ends = [f"{100 * end:.2g}" for end in (np.nanmin(values), np.nanmax(values))]
    return f"{' to '.join(dict.fromkeys(ends))} %"


def shift_lines(answer: xr.Dataset) -> Iterator[str]:
    """Line on the shift of the boundary by tests, if it is above `_MIN_SHIFT`."""
    ratios = (answer["critical_velocity_p50"] / answer["critical_velocity"]).values.ravel()
    ratios = ratios[np.isfinite(ratios)]
    shift = float(np.median(ratios)) - 1 if ratios.size else 0.0
    size = f"{100 * abs(shift):.0f} %"
    if shift > _MIN_SHIFT:
        yield f"with tests, the boundary lies {size} higher in velocity than computed"
    elif shift < -_MIN_SHIFT:
        yield f"with tests, the boundary lies {size} lower in velocity than computed"
