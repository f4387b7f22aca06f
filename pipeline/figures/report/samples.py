"""Sections of a report on a sweep whose inputs are not known exactly: answers as probabilities."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator, Mapping
from typing import Any

import xarray as xr

from pipeline.analysis.operating_points import OperatingPoints
from pipeline.analysis.tables import Column, Table
from pipeline.uncertain.answers import probabilities_at_loads, risk, risk_lines, table_of_lines
from pipeline.uncertain.ensemble import Ensemble
from pipeline.uncertain.judging import ensemble_under
from tribo import InputError


def sections(
    ds: xr.Dataset, points: OperatingPoints | None, changed: Mapping[str, Any]
) -> dict[str, Callable[[], Iterator[str | Table]]]:
    """Writers of the sections that a sweep of samples has in place of the usual ones."""
    ensemble, conditions = ensemble_under(ds, **changed)
    plane = probabilities_at_loads(ensemble, conditions=conditions)
    _, lines = risk_lines(plane)
    of_load = list(zip(ensemble.loads.tolist(), lines.tolist(), strict=True))

    def question() -> Iterator[str | Table]:
        yield (
            "At which load and sliding velocity does wear of this lubricated contact turn from "
            "mild to severe adhesive wear (scuffing), with inputs that are not known exactly? "
            f"{len(ensemble.inputs)} samples of them were simulated."
        )
        yield f"Not known exactly: {'; '.join(map(str, ensemble.unknown))}."
        words = []
        for load, row in dict([of_load[0], of_load[-1]]).items():
            low, middle, high = (_velocity(velocity, ensemble) for velocity in row)
            words.append(f"from {middle} on at {load:g} N ({low} to {high} with 90 % probability)")
        yield f"Answer: wear is as likely severe as mild {' and '.join(words)}."

    def numbers() -> Iterator[str | Table]:
        yield table_of_lines(plane)
        yield "Velocities at which wear is severe with these probabilities."

    def operating_points() -> Iterator[str | Table]:
        if points is None:
            return
        columns = (
            Column("load", "load", "N"), Column("velocity", "velocity", "m/s"),
            Column("probability", "probability of severe wear", digits=2),
            Column("error", "standard error", digits=1),
        )  # fmt: skip
        rows, notes = [], []
        for place in points.places:
            try:
                answer = risk(ensemble, place.load, place.velocity, conditions=conditions)
            except InputError as error:
                notes.append(f"{place.load:g} N at {place.velocity:g} m/s: {error}.")
                continue
            rows.append((answer.load, answer.velocity, answer.probability, answer.error))
        yield Table(columns, tuple(rows))
        yield from notes

    return {
        "Question and answer": question,
        "Boundary in numbers": numbers,
        "Operating points": operating_points,
    }


def _velocity(velocity: float, ensemble: Ensemble) -> str:
    """A velocity, or the end of the samples that it lies beyond."""
    low, high = ensemble.velocities
    if not velocity:
        return f"below {low:.3g} m/s"
    return f"beyond {high:.3g} m/s" if math.isinf(velocity) else f"{velocity:.3g} m/s"
