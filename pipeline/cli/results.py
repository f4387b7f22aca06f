"""The commands that say when wear is severe, and at which temperature or wear rate."""

from __future__ import annotations

import argparse
import math
from collections.abc import Iterator, Mapping
from dataclasses import asdict
from pathlib import Path

import pipeline
from pipeline.cli.crossings import document_of, text_of
from pipeline.cli.output import DONE, micrometres, show, tell
from pipeline.cli.scenes import CONDITIONS, PLACE, given, scene_of, selected
from pipeline.sweep.criterion import Verdict
from pipeline.sweep.model import Point, Sweep
from pipeline.sweep.plan import PointResult
from tribo import InputError, measures, specific_wear_rate


def boundary(options: argparse.Namespace) -> int:
    """Print critical velocities and loads."""
    ds, conditions = pipeline.open_sweep(options.store), given(options, *CONDITIONS)
    found, warned = pipeline.boundary(ds, **conditions), pipeline.warned(ds, **conditions)
    document = document_of(found) | {"warnings": warned.as_dict()}
    show(options, document, [*text_of(found), *warned.lines()])
    return DONE


def plot(options: argparse.Namespace) -> int:
    """Draw a figure of a store."""
    ds = pipeline.open_sweep(options.store)
    store = Path(options.store if isinstance(options.store, Path) else Path(options.store).name)
    out = options.output or store.with_name(f"{store.stem}_{options.kind}.png")
    place, conditions = given(options, *PLACE), given(options, *CONDITIONS)
    written = pipeline.plot(ds, options.kind, out, **place, **conditions)
    warned = pipeline.warned(ds, **conditions)
    document = {"kind": options.kind, "file": str(written), "warnings": warned.as_dict()}
    show(options, document, [f"{written}", *warned.lines()])
    return DONE


def point(options: argparse.Namespace) -> int:
    """Simulate one point."""
    sweep = scene_of(options, points=[Point(options.load, options.velocity)])
    sweep = sweep.on_surface(options.realization)
    result = pipeline.run_point(sweep, options.load, options.velocity)
    found, verdict = measures(sweep, result.state), result.verdict(sweep.conditions)
    document = found | {
        "velocity": options.velocity,
        "friction": sweep.conditions.friction,
        "max_temperature": verdict.max_temperature,
        "decisive_temperature": verdict.decisive_temperature,
        "failed_fraction": verdict.failed_fraction,
        "failed_fraction_time": verdict.time,
        "severe": verdict.is_severe,
        "warnings": [{"kind": kind.label, "text": text} for kind, text in result.warnings],
        "wall_time": result.wall_time,
        **selected(sweep),
    }
    show(options, document, _on_point(sweep, result, verdict, found))
    return DONE


def _on_point(
    sweep: Sweep, result: PointResult, verdict: Verdict, found: Mapping[str, float]
) -> Iterator[str]:
    load, velocity, _ = result.point
    conditions = sweep.conditions
    at_worst = f" at its worst, after {verdict.time:.3g} s" if verdict.time < found["time"] else ""
    wear = "severe wear" if verdict.is_severe else "mild wear"
    if verdict.is_severe is None:
        wear = "whether wear is severe is not known without temperature.critical"
    yield (
        f"{load:g} N at {velocity:g} m/s after {found['time']:.3g} s "
        f"and {found['sliding_distance']:.3g} m: {wear}"
    )
    if conditions.critical_temperature is not None and verdict.failed_fraction is not None:
        yield (
            f"  failed share      {100 * verdict.failed_fraction:.1f} % of the contact above "
            f"{pipeline.display(conditions.critical_temperature, '°C')} "
            f"(severe above {100 * conditions.failing_share:g} %)"
        )
    if conditions.failing_share:
        yield (
            f"  exceeded          {pipeline.display(verdict.decisive_temperature, '°C', 4)} on "
            f"{100 * conditions.failing_share:g} % of the contact"
        )
    yield (
        f"  max temperature   {pipeline.display(verdict.max_temperature, '°C', 4)} at friction "
        f"{conditions.friction:g}{at_worst}"
    )
    heat = found["pin_heat_share"]
    yield "  pin's heat share  " + (f"{100 * heat:.1f} %" if math.isfinite(heat) else "no heat")
    yield f"  contact width     {micrometres(found['contact_width'])}"
    yield f"  contact area      {100 * found['contact_fraction']:.2f} % of the window"
    yield (
        f"  pressure          {found['mean_pressure'] / 1e9:.3f} GPa on average, "
        f"{found['max_pressure'] / 1e9:.3f} GPa at most"
    )
    yield (
        f"  wear              {micrometres(found['wear_depth_max'])} deep, "
        f"{found['wear_volume'] * 1e9:.3g} mm³"
    )
    yield f"  computed in       {result.wall_time:.2f} s"
    yield from (f"  note: {note}" for note in sweep.notes)
    yield from (f"  warning: {text}" for _, text in result.warnings)


def infer(options: argparse.Namespace) -> int:
    """Find what was not measured from what was."""
    sweep = scene_of(options).on_surface(options.realization)
    if options.contact_width is not None:
        return _wear_rate(options, sweep)
    if options.load is not None or options.velocity is not None:
        raise InputError("--load and --velocity belong to --contact-width, which is not given")
    found = pipeline.critical_temperatures(sweep, progress=tell)
    rows = zip(found.transitions, found.means, found.spreads, strict=True)
    several = f" on {len(found.surfaces)} surfaces" if len(found.surfaces) > 1 else ""
    text = [
        f"critical temperature from {len(found.transitions)} measured transition(s){several}: "
        f"exceeded on {100 * found.share:g} % of the contact",
        *(
            f"  {at.normal_load:g} N, {at.velocity:g} m/s, friction {at.friction:g}: "
            f"{pipeline.display(mean, '°C', 4)}" + (f" ± {spread:.1f} K" if spread else "")
            for at, mean, spread in rows
        ),
        f"on average {pipeline.display(found.mean, '°C', 4)}"
        + (f", {found.spread:.1f} K apart (standard deviation)" if found.spread else ""),
    ]
    show(options, found.as_dict(), text)
    return DONE


def _wear_rate(options: argparse.Namespace, sweep: Sweep) -> int:
    if options.load is None or options.velocity is None:
        raise InputError("--contact-width needs --load and --velocity: where it was measured")
    found = specific_wear_rate(sweep, options.contact_width, options.load, options.velocity)
    value, lowest, highest = (1e9 * rate for rate in (found.value, found.lowest, found.highest))
    text = (
        f"specific wear rate {value:.3g} mm³/(N m), from {lowest:.3g} to {highest:.3g} within half "
        "an element of the width"
    )
    show(options, asdict(found), [text])
    return DONE
