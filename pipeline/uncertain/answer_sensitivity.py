"""The command ``irg sensitivity``: the share of each input in the variance of the boundary."""

from __future__ import annotations

import argparse
from collections.abc import Iterator
from functools import partial

import numpy as np
import pandas as pd

import pipeline
from pipeline.analysis.tables import frame_of, short
from pipeline.cli import given
from pipeline.cli.output import Result, working, wrapped
from pipeline.sweep.remarks import remarks
from pipeline.uncertain.fields import single_field
from pipeline.uncertain.sensitivity import Sensitivity

_GOOD = 0.3  # warn if the emulator's error exceeds this share of the spread


def sensitivity(options: argparse.Namespace) -> Result:
    """Answer ``irg sensitivity``: show Sobol' indices of the inputs by load, with a figure."""
    ds = given.dataset_in(options)
    with working("weighing the inputs"):
        samples = single_field(ds)
    with working("finding Sobol' indices"):
        indices = pipeline.sensitivity(samples.ensemble, samples.given_draws)
    frame = _index_frame(indices)
    text = [*wrapped(samples.basis), *_describe_indices(indices, frame)]
    draw = partial(pipeline.plot, indices, title=samples.ensemble.title)
    return Result(indices.as_dict(), text, pipeline.warned(ds), [frame], draw)


def _index_frame(indices: Sensitivity) -> pd.DataFrame:
    """Sobol' indices with the ends of their 90 % intervals, a row for each load and input."""
    heads = (
        "load [N]", "input", "first", "first low", "first high", "total", "total low", "total high",
        "velocity spread [%]", "emulator error [%]",
    )  # fmt: skip
    parts = (indices.first, *indices.first_interval, indices.total, *indices.total_interval)
    values = np.stack(parts, axis=-1).tolist()
    rows = zip(indices.loads, indices.spread, indices.velocity_error, values, strict=True)
    order = np.argsort(-indices.first.mean(axis=0))
    return frame_of(
        heads,
        (
            (load, indices.unknown[number].path, *at_load[number], spread, error)
            for load, spread, error, at_load in rows
            for number in order
        ),
    )


def _describe_indices(indices: Sensitivity, frame: pd.DataFrame) -> Iterator[str | pd.DataFrame]:
    """Yield the table of Sobol' indices, then notes on missing indices and emulator errors."""
    yield short(frame, ["total low", "total high"])  # -o and --json have them
    if not np.isfinite(indices.total).all():
        given_measured = "given the measurements"
        reason = given_measured if indices.given_measured else "as stated in the scene"
        yield f"no total index: {reason}, the inputs are correlated"
    for load, spread, error in zip(
        indices.loads, indices.spread, indices.velocity_error, strict=True
    ):
        if error > _GOOD * spread:
            words = (
                f"at {load:g} N the emulated velocity is off by {100 * error:.2g} %, against a "
                f"spread of {100 * spread:.2g} %; run more samples"
            )
            yield from remarks("warning", words)
