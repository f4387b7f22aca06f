"""The commands that study a scene: its inputs one by one, limits of a design, its errors."""

from __future__ import annotations

import argparse
import itertools
import math
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import asdict
from functools import partial
from typing import TYPE_CHECKING, Any

import numpy as np
import pandas as pd
import xarray as xr

import pipeline
from pipeline.analysis.tables import frame_of, short
from pipeline.cli import given
from pipeline.cli.output import Result, rounded, run_line, tell, working
from pipeline.sweep.unknown import Unknown
from pipeline.uncertain.answer_sensitivity import Samples, samples_in
from pipeline.uncertain.design import RISK, RISK_OF_MARGIN, Direct, Goal, Limit, designed, directly
from tribo import InputError, TriboError

if TYPE_CHECKING:
    from pipeline.run.vary import Variations  # with Dask

_STATES = ("counted", "could be counted", "cannot be sized")


def vary(options: argparse.Namespace) -> Result:
    """Print and draw the boundary for each value of some entries."""
    over: dict[str, list[Any]] = {}
    for key, values in options.over:
        over.setdefault(key, []).extend(values)
    if not over and not options.physics:
        raise InputError("nothing to vary; give --over KEY=VALUE,VALUE for an entry, or --physics")
    with run_line() as progress:
        result = pipeline.vary(
            options.scene,
            over,
            options.preset,
            given.settings_in(options),
            tell=tell,
            physics=options.physics,
            own_laws=options.own_laws,
            out=options.kept,
            workers=options.workers,
            progress=progress,
        )
    frame = _critical_velocities(result)
    return Result(
        result.as_dict(),
        _on_variations(result, frame),
        warned=result.warned,
        frames=[frame],
        draw=partial(pipeline.draw_variations, result),
    )


def _critical_velocities(result: Variations) -> pd.DataFrame:
    """Frame with a row for each value and load."""
    rows: list[tuple[Any, ...]] = []
    for variation in (result.base, *itertools.chain(*result.by_key().values())):
        name, changes = "as it is", [math.nan] * len(result.loads)
        if variation.key:
            name, changes = variation.key, result.changes(variation).tolist()
        values = zip(
            result.loads, variation.critical_velocities, changes, variation.outcomes, strict=True
        )
        rows += [(name, variation.value, *row) for row in values]
    heads = "entry", "value", "load [N]", "critical velocity [m/s]", "change [%]", "outcome"
    return frame_of(heads, rows)


def _on_variations(result: Variations, frame: pd.DataFrame) -> Iterator[str | pd.DataFrame]:
    """The frame, and physics that the scene leaves out."""
    yield short(frame)
    yield ""
    yield f"{result.points} points, computed on the contacts of {result.contacts}"
    for state, group in itertools.groupby(
        sorted(result.physics, key=lambda effect: _STATES.index(effect.state)),
        key=lambda effect: effect.state,
    ):
        yield from ("", f"{state}:")
        for effect in group:
            yield f"  {effect.name}: {effect.size}"
            if effect.certainty:
                yield f"    certainty  {effect.certainty}"
            if effect.entry:
                yield f"    entry      {effect.entry}"


def trade(options: argparse.Namespace) -> Result:
    """Measure speed against accuracy on a scene."""
    measured = pipeline.trade(given.scene_in(options), base=options.base, progress=tell)
    draw = partial(pipeline.draw_trade, measured)
    return Result(measured.as_dict(), [str(measured)], frames=[measured.table], draw=draw)


_LINE = 9  # values of the first of two entries


def design(options: argparse.Namespace) -> Result:
    """Print the value of an entry that reaches a goal, or of two entries a line in their plane."""
    goal, entries = _goal(options), options.entries
    if len(entries) > 2 or len(set(entries)) < len(entries):
        raise InputError(f"--over is {', '.join(entries)}; give one entry, or two different ones")
    ds = given.dataset_in(options)
    samples = samples_in(ds)
    shift, direct = 0.0, None
    for seed in range(2):  # the first time to correct the limit, the second to check it
        with working("seeking the limit") as progress:
            limits = list(_limits(samples, goal, entries, shift, progress))
        found = [pair for pair in limits if pair[1].value is not None] or limits
        at, limit = found[len(found) // 2]
        direct, reason = _simulated(ds, samples, limit, at, shift, seed)
        if direct is None:
            break
        shift = direct.shift
    entry, path = limit.entry, limit.entry.path
    if at:
        (other,) = at
        rows = ((at[other], one.side, one.value) for at, one in limits)
        frame = frame_of((other, "side", path), rows)
        answer = {"line": [{"at": at, **one.as_dict()} for at, one in limits]}
        text = [f"{path} by {other}, in SI, for {_wanted(goal)}", frame]
    else:
        points = zip(limit.values, limit.probabilities, strict=True)
        frame = frame_of((f"{path} [{entry.unit}]", "probability"), points)
        answer, text = limit.as_dict(), [_in_words(limit)]
    document = samples.as_dict() | answer
    document["direct"] = direct and asdict(direct)
    fits = not (samples.posterior and samples.posterior.misfit)
    document["confirmed"] = bool(fits and direct and direct.agrees_with(goal.risk))
    text += [*(_on_check(goal, limit, at, direct, reason) if fits else ()), *samples.notes()]
    draw = partial(pipeline.draw_design, limits, samples.ensemble)
    out = given.beside(options.store, "_design.png")
    return Result(document, text, pipeline.warned(ds), [frame], draw, out)


def _goal(options: argparse.Namespace) -> Goal:
    """Operating points, and what is to be reached at them."""
    if options.risk is not None and options.margin is not None:
        raise InputError("--risk and --margin are two goals; give one of them")
    points = given.operating_points_in(options)
    points.require_places_alone("a design is sought at loads and velocities alone")
    places = points.places
    if options.margin is not None:
        return Goal(places, RISK_OF_MARGIN, options.margin)
    return Goal(places, RISK if options.risk is None else options.risk)


def _limits(
    samples: Samples,
    goal: Goal,
    entries: Sequence[str],
    shift: float,
    progress: Callable[[int, int], None],
) -> Iterator[tuple[dict[str, float], Limit]]:
    """Limits of the last entry, at each of some values of another one if there are two."""
    *first, last = entries
    places: list[dict[str, float]] = [{}]
    for path in first:
        low, high = designed(samples.ensemble, path).parameters
        places = [{path: value} for value in np.linspace(low, high, _LINE).tolist()]
    for number, at in enumerate(places):
        progress(number, len(places))
        yield at, pipeline.design(samples.ensemble, goal, last, samples.draws, at, shift)


def _simulated(
    ds: xr.Dataset,
    samples: Samples,
    limit: Limit,
    at: Mapping[str, float],
    shift: float,
    seed: int,
) -> tuple[Direct | None, str]:
    """Direct simulations at a limit; or why there are none."""
    if limit.value is None:
        return None, ""
    values = {**at, limit.entry.path: limit.value}
    place = limit.goal, limit.binding
    try:
        scene_with = given.scene_with_of(ds)
        with working("simulating draws near the limit") as progress:
            direct = directly(
                samples.ensemble, *place, values, scene_with, samples.draws, progress,
                shift=shift, seed=seed,
            )  # fmt: skip
    except (TriboError, OSError) as error:
        return None, str(error).splitlines()[0]
    return direct, ""


def _worded(entry: Unknown, value: float) -> str:
    return f"{entry.shown.of(value):.4g}{entry.shown.suffix}"


def _wanted(goal: Goal) -> str:
    if goal.margin:
        return f"{goal.margin:g} K below the critical temperature with {100 * (1 - goal.risk):g} %"
    return f"a risk of {100 * goal.risk:g} %"


def _in_words(limit: Limit) -> str:
    """The limit of one entry, in a line."""
    path, place = limit.entry.path, limit.binding
    where = f"{_wanted(limit.goal)} at {place.load:g} N and {place.velocity:g} m/s"
    if len(limit.goal.places) > 1:
        where += f", the worst of {len(limit.goal.places)} points"
    if limit.side == "none":
        (at, least), entry = limit.best, limit.entry
        best = f"{rounded(100 * least)} % at best, with {_worded(entry, at)}"
        return f"not by {path} alone: {best}, for {where}"
    if limit.value is None or limit.interval is None:
        low, high = (_worded(limit.entry, end) for end in limit.entry.parameters)
        return f"{path}: any value from {low} to {high} does for {where}"
    low, high = (_worded(limit.entry, end) for end in limit.interval)
    sign = "≥" if limit.side == "at least" else "≤"
    also = ""
    if limit.side == "between" and limit.safe:
        also = f" and ≥ {_worded(limit.entry, limit.safe[0])}"
    return f"{path} {sign} {_worded(limit.entry, limit.value)}{also} ({low} to {high}) for {where}"


def _on_check(
    goal: Goal, limit: Limit, at: Mapping[str, float], direct: Direct | None, reason: str
) -> Iterator[str]:
    """What direct simulations say of the limit."""
    if limit.value is None:
        return
    if direct is None:
        yield f"  not confirmed by direct simulations: {reason}"
        return
    found = (
        f"{direct.probability:.4f} ± {direct.error:.4f} in {direct.draws} new draws; the "
        f"{direct.simulated} near the limit were simulated"
    )
    where = "".join(f" with {path} {value:.4g}" for path, value in at.items())
    if direct.agrees_with(goal.risk):
        yield f"  confirmed{where}: {found}"
    else:
        yield f"  warning: not confirmed{where}: {found}; run more samples"
