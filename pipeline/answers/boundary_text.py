"""Lines on a boundary: tests that limit it, and its errors."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np
import xarray as xr

from pipeline.answers.answer_lines import (
    model_error_line,
    not_included_lines,
    uncertain_inputs_lines,
)
from pipeline.answers.hottest_end import end_lines
from pipeline.answers.point_text import ERROR_PARTS
from pipeline.answers.value_text import split_texts
from tribo.types import Array


def boundary_lines(answer: xr.Dataset) -> Iterator[str]:
    """Lines on a boundary: effects not included, ends of the pin, tests that limit it, errors."""
    yield from not_included_lines(answer)
    yield from end_lines(answer)
    yield from ruling_lines(answer)
    yield from error_lines(answer)


def ruling_lines(answer: xr.Dataset) -> Iterator[str]:
    """Lines on the tests that limit the velocities at which wear is mild, or severe."""
    texts, loads = xr.broadcast(answer["ruled_out_by"], answer["load"])
    loads_of = dict[str, list[float]]()
    for cell, load in zip(texts.values.ravel(), loads.values.ravel().tolist(), strict=True):
        for text in split_texts([cell]):
            loads_of.setdefault(text, []).append(load)
    for text, ruled_loads in loads_of.items():
        ends = dict.fromkeys(f"{load:g}" for load in (min(ruled_loads), max(ruled_loads)))
        yield f"at {' to '.join(ends)} N, {text}"


def error_lines(answer: xr.Dataset) -> Iterator[str]:
    """Lines on the numerical error of a boundary and on the model error."""
    names = "velocity_error", "velocity_error_surface", "velocity_error_positions"
    errors, surface, positions = (answer[name].values for name in names)
    is_critical = answer["critical_velocity"].notnull().values
    few_grooves = np.count_nonzero(is_critical & np.isnan(surface))
    if not is_critical.any():
        yield "no numerical error, as no critical velocity lies within the sweep"
    elif np.isfinite(errors).any():
        parts = [
            f", {ERROR_PARTS[name]} {_percents(part)}"
            for name, part in (("surface", surface), ("positions", positions))
            if np.nanmax(part)
        ]
        yield (
            f"numerical error (95 %): ± {_percents(errors)} of the critical velocity"
            f"{''.join(parts)}"
        )
    elif not few_grooves:
        yield "numerical error of the critical velocity: unknown"
    if few_grooves:
        yield (
            f"numerical error unknown at {few_grooves} of {is_critical.sum()} critical velocities: "
            "one surface realization has too few independent grooves; simulate several "
            "(sweep.realizations)"
        )
    yield model_error_line(answer)
    yield from uncertain_inputs_lines(answer)


def _percents(values: Array) -> str:
    ends = [f"{100 * end:.2g}" for end in (np.nanmin(values), np.nanmax(values))]
    return f"{' to '.join(dict.fromkeys(ends))} %"
