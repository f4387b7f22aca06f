"""Sections of a report on a sweep whose inputs are not known exactly: answers as probabilities."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator, Mapping
from typing import Any

import pandas as pd
import xarray as xr

from pipeline.analysis.margins import notes_of
from pipeline.analysis.tables import short
from pipeline.scene.along import OperatingPoints
from pipeline.uncertain.answers import frame_of_lines
from pipeline.uncertain.ensemble import Ensemble
from pipeline.uncertain.risks import risk_table


def sections(
    ds: xr.Dataset, points: OperatingPoints | None, changed: Mapping[str, Any]
) -> dict[str, Callable[[], Iterator[str | pd.DataFrame]]]:
    """Writers of the sections that a sweep of samples has in place of the usual ones."""
    ensemble = Ensemble.of(ds, **changed)
    lines = frame_of_lines(ensemble)

    def question() -> Iterator[str | pd.DataFrame]:
        yield (
            "At which load and sliding velocity does wear of this lubricated contact turn from "
            "mild to severe adhesive wear (scuffing), with inputs that are not known exactly? "
            f"{len(ensemble.inputs)} samples of them were simulated."
        )
        yield f"Not known exactly: {'; '.join(map(str, (*ensemble.unknown, *ensemble.fixed)))}."
        words = []
        for load, *row in dict.fromkeys(lines.iloc[[0, -1]].itertuples(index=False, name=None)):
            low, middle, high = (_velocity(velocity, ensemble) for velocity in row)
            words.append(f"from {middle} on at {load:g} N ({low} to {high} with 90 % probability)")
        yield f"Answer: wear is as likely severe as mild {' and '.join(words)}."

    def numbers() -> Iterator[str | pd.DataFrame]:
        yield lines
        yield "Velocities at which wear is severe with these probabilities."

    def operating_points() -> Iterator[str | pd.DataFrame]:
        if points is None:
            return
        table = risk_table(ensemble, points)
        yield short(table, ["note"])
        yield from (f"{note}." for note in notes_of(table))

    return {
        "Question and answer": question,
        "Boundary in numbers": numbers,
        "Operating points": operating_points,
    }


def _velocity(velocity: float, ensemble: Ensemble) -> str:
    """A velocity, or the end of the samples that it lies beyond."""
    low, high = ensemble.velocities
    if velocity < 0:
        return f"below {low:.3g} m/s"
    return f"beyond {high:.3g} m/s" if math.isinf(velocity) else f"{velocity:.3g} m/s"
