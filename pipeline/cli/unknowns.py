"""The commands on inputs not known exactly: risk, sensitivity, and inputs by measurements."""

from __future__ import annotations

import argparse
import math
from collections.abc import Iterator
from dataclasses import astuple
from functools import partial
from typing import Any, NamedTuple

import numpy as np
import pandas as pd
import xarray as xr

import pipeline
from pipeline.analysis.tables import as_dict, frame_of, short
from pipeline.analysis.transition import UNITS
from pipeline.cli import given
from pipeline.cli.next_steps import next_tests
from pipeline.cli.output import Result, counted, working
from pipeline.sweep.samples import JUDGED
from pipeline.uncertain.answers import MEAN_OF_RUNS, frame_of_lines
from pipeline.uncertain.ensemble import Ensemble
from pipeline.uncertain.inputs import QUANTILES, Draws
from pipeline.uncertain.posterior import Posterior
from pipeline.uncertain.risks import MarginIntervals, Risk
from pipeline.uncertain.sensitivity import Sensitivity
from pipeline.uncertain.weigh import posterior_if_given
from tribo import InputError

_GOOD = 0.3  # of the spread of a velocity, which its error may be


def risk(options: argparse.Namespace) -> Result:
    """Print the probability of severe wear at a point, or draw it over the plane."""
    place = given.values_in(options, "load", "velocity")
    if len(place) == 1:
        raise InputError("only one of --load and --velocity is given; give both or neither")
    ds = given.dataset_in(options)
    samples = samples_in(options, ds, **given.criterion_in(options))
    ensemble, document, text = samples.ensemble, samples.as_dict(), list(samples.notes())
    if place:
        with working("finding the probability"):
            here = pipeline.risk(ensemble, options.load, options.velocity, samples.draws)
        document |= here.as_dict()
        text = [
            on_risk(here),
            *text,
            f"  emulated from {here.samples} samples: the rise errs by "
            f"{100 * here.rise_error:.2g} %, which the ± includes",
            *_to_weigh(samples),
        ]
    warned = pipeline.warned(ds)
    if place and options.output is None:
        return Result(document, text, warned)
    with working("finding probabilities over the plane"):
        plane = pipeline.probabilities(ensemble, samples.draws)
        lines = frame_of_lines(ensemble, samples.draws)
    text += [] if place else [_ON_LINES, lines]
    rows = plane.to_dataframe().reset_index().itertuples(index=False, name=None)
    cells = frame_of(("load [N]", "velocity [m/s]", "probability"), rows)
    draw = partial(pipeline.draw_risk, ensemble, plane, place, samples.posterior)
    out = given.beside(options.store, "_risk.png")
    return Result(document | _velocities(lines), text, warned, [cells], draw, out)


def on_risk(here: Risk) -> str:
    """Probability of severe wear at an operating point, in words."""
    return (
        f"{here.load:g} N at {here.velocity:g} m/s: severe wear with a probability of "
        f"{here.probability:.3g} ± {here.error:.2g}, {here.lowest:.2g} to {here.highest:.2g} with "
        f"the error of the preset: {here.verdict}"
    )


def _to_weigh(samples: Samples) -> Iterator[str]:
    ensemble, weighed = samples
    if ensemble.tests and weighed is None:
        yield "next: add --given-measured to weigh the inputs by the scene's tests"


_ON_LINES = "velocity at which wear is severe with a probability of 5, 50 and 95 %"


def _velocities(lines: pd.DataFrame) -> dict[str, Any]:
    """Velocities of some probabilities by load, as plain data; null where they lie beyond."""
    loads, *velocities = as_dict(lines).values()
    shares = map(str, QUANTILES)
    return {"load": loads, "velocity_of_probability": dict(zip(shares, velocities, strict=True))}


def boundary_of_samples(
    options: argparse.Namespace, ds: xr.Dataset, conditions: dict[str, Any]
) -> Result:
    """Print the velocities at which wear is severe with some probabilities."""
    samples = samples_in(options, ds, **conditions)
    with working("finding probabilities at each load"):
        lines = frame_of_lines(samples.ensemble, samples.draws)
    text = [_ON_LINES, lines, *samples.notes(), *(() if conditions else _to_weigh(samples))]
    return Result(samples.as_dict() | _velocities(lines), text, pipeline.warned(ds), [lines])


def frame_of_intervals(answer: MarginIntervals) -> pd.DataFrame:
    """Distance of an operating point from severe wear, a quantity a row."""
    place, temperature = answer.risk, answer.decisive_temperature
    rows: list[tuple[Any, ...]] = [
        ("decisive temperature [°C]", *(value - 273.15 for value in astuple(temperature))),
        ("distance below the critical [K]", *astuple(answer.distance)),
    ]
    for name, interval, here in (
        ("velocity", answer.critical_velocity, place.velocity),
        ("load", answer.critical_load, place.load),
    ):
        if interval is not None:
            values = [value or -math.inf for value in astuple(interval)]  # 0 below the sweep
            rows.append((f"critical {name} [{UNITS[name]}]", *values))
            rows.append((f"{name} factor", *(value / here for value in values)))
    return frame_of(("quantity", "5 %", "50 %", "95 %"), rows)


def sensitivity(options: argparse.Namespace) -> Result:
    """Print and draw the shares of the inputs in the variance of the boundary."""
    ds = given.dataset_in(options)
    samples = samples_in(options, ds, **given.criterion_in(options))
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
        yield f"  {MEAN_OF_RUNS}"
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


def samples_in(options: argparse.Namespace, ds: xr.Dataset, **conditions: Any) -> Samples:
    """The samples of a sweep under conditions, weighed as the options say."""
    others = [name for name in conditions if name not in ("criterion", "own_laws")]
    if others and (weighed := given.values_in(options, "scatter", "given_measured")):
        raise InputError(
            f"{given.flags_of(weighed)} weighs the conditions as they were drawn: leave out "
            f"{given.flags_of(others)}"
        )
    with working("reading samples"):
        ensemble = pipeline.Ensemble.of(ds, given.at_in(options), **conditions)
    with working("weighing the inputs by the measurements"):
        posterior = posterior_if_given(ensemble, options.given_measured, options.scatter)
    return Samples(ensemble, posterior)


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
