"""The command on the causes of what is not known exactly, and what is said of samples."""

from __future__ import annotations

import argparse
from collections.abc import Iterator
from functools import partial
from typing import Any, NamedTuple

import numpy as np
import pandas as pd
import xarray as xr

import pipeline
from pipeline.analysis.tables import frame_of, short
from pipeline.cli import given
from pipeline.cli.next_steps import next_tests
from pipeline.cli.output import Result, counted, working
from pipeline.sweep.samples import JUDGED
from pipeline.uncertain.ensemble import Ensemble
from pipeline.uncertain.inputs import Draws
from pipeline.uncertain.posterior import Posterior
from pipeline.uncertain.sensitivity import Sensitivity
from pipeline.uncertain.weigh import posterior_at

_GOOD = 0.3  # of the spread of a velocity, which its error may be


def sensitivity(options: argparse.Namespace) -> Result:
    """Print and draw the shares of the inputs in the variance of the boundary."""
    ds = given.dataset_in(options)
    samples = samples_in(ds)
    with working("finding Sobol' indices"):
        indices = pipeline.sensitivity(samples.ensemble, samples.draws)
    most = indices.unknown[int(np.argmax(indices.first.mean(axis=0)))]
    target = None if most.kind == "list" else most.path
    frame = _indices(indices)
    text = [
        *samples.notes(),
        *_on_indices(indices, frame),
        f"next: {most.path} moves the boundary most; tests to make: "
        f"{next_tests([options.store], options.scatter, given.at_in(options), target)}",
    ]
    draw = partial(pipeline.draw_sensitivity, indices, samples.ensemble.title)
    document = samples.as_dict() | indices.as_dict()
    return Result(document, text, pipeline.warned(ds), [frame], draw)


def _indices(indices: Sensitivity) -> pd.DataFrame:
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


def _on_indices(indices: Sensitivity, frame: pd.DataFrame) -> Iterator[str | pd.DataFrame]:
    """The frame, and what its numbers rest on."""
    yield short(frame)
    if not np.isfinite(indices.total).all():
        given_measured = "given the measurements"
        reason = given_measured if indices.given_measured else "as stated in the scene"
        yield f"no total index: {reason}, the inputs are correlated"
    for load, spread, error in zip(
        indices.loads, indices.spread, indices.velocity_error, strict=True
    ):
        if error > _GOOD * spread:
            yield (
                f"warning: at {load:g} N the emulated velocity errs by {100 * error:.2g} %, beside "
                f"a spread of {100 * spread:.2g} %; run more samples"
            )


class Samples(NamedTuple):
    """The samples of a sweep, and their inputs as measurements leave them if these are to count."""

    ensemble: Ensemble
    posterior: Posterior | None

    @property
    def draws(self) -> Draws | None:
        """Draws that an answer rests on; None for those of the inputs as the scene has them."""
        return self.posterior.draws if self.posterior else None

    def as_dict(self) -> dict[str, Any]:
        """What every answer of samples says of them and of their inputs, as plain data."""
        ensemble = self.ensemble
        return {
            "given_measured": self.posterior is not None,
            "misfit": self.posterior.misfit if self.posterior else "",
            "samples": len(ensemble.inputs),
            "samples_left_out": ensemble.missing,
            "unknown": [one.as_dict() for one in ensemble.unknown],
            "fixed": {one.unknown.path: one.value for one in ensemble.fixed},
            "left_out_held": ensemble.left_out.held,
            "left_out_contacts": ensemble.left_out.contacts,
        }

    def notes(self) -> Iterator[str]:
        """Basis of the numbers."""
        ensemble, weighed = self
        if weighed and weighed.misfit:
            yield f"warning: {weighed.misfit}"
        basis = "as the scene assumes them"
        if weighed:
            basis = f"given {weighed.evidence}, {scatter_in_words(weighed)}"
        yield f"  {counted(len(ensemble.unknown), 'unknown input', 'unknown inputs')}, {basis}"
        yield from (f"  {one}" for one in ensemble.fixed)
        if weighed:
            yield draws_in_words(weighed)
        if ensemble.velocity_error is None:
            yield "  the error of the samples' fidelity is not known, and not counted"
        if ensemble.missing:
            yield f"  {ensemble.missing} samples are left out: not done at every load"
        yield f"  {_on_left_out(ensemble)}"


def samples_in(ds: xr.Dataset) -> Samples:
    """The samples of a sweep, weighed as it says."""
    with working("reading samples"):
        ensemble = pipeline.Ensemble.of(ds)
    with working("weighing the inputs by the measurements"):
        return Samples(ensemble, posterior_at(ds, ensemble))


def _on_left_out(ensemble: Ensemble) -> str:
    """How samples that are left out lie in the bands of the others, in words."""
    left_out, count = ensemble.left_out, len(ensemble.inputs)
    held = (
        f"of places left out the 90 % bands hold {100 * left_out.held:.0f} ± "
        f"{100 * left_out.error:.0f} %"
    )
    if not left_out.is_known:
        contacts = counted(left_out.contacts, "contact", "contacts")
        return f"{count} samples may not suffice: {held}, by {contacts} where {JUDGED} tell enough"
    if not left_out.is_right:
        return f"{count} samples may not suffice: {held}, not 85 to 95 %"
    suffice = " suffice" if count == ensemble.design.sufficient else ""
    return f"{count} samples{suffice}: {held}"


def draws_in_words(weighed: Posterior) -> str:
    """Number of draws that the numbers rest on, in words."""
    effective, count = weighed.draws.effective, len(weighed.draws.weights)
    return f"  effective sample size {effective:.0f} of {count}"


def scatter_in_words(weighed: Posterior) -> str:
    """Scatter of the velocities, as stated and as inferred."""
    low, middle, high = (100 * value for value in weighed.inferred_scatter)
    said = f"scatter of the velocities as stated, {100 * weighed.scatter:g} %"
    if not weighed.judged:
        return said
    ends = {
        "above": "; it may be larger, which is not considered",
        "below": "; it may be smaller, which is not considered",
    }
    cut_off = ends.get(weighed.cut_off, "")
    return f"{said}, and by the tests {middle:.2g} % ({low:.2g} to {high:.2g}{cut_off})"
