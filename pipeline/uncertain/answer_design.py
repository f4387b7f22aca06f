"""What the command ``irg design`` answers."""

from __future__ import annotations

import argparse
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import asdict
from functools import partial
from typing import Any

import numpy as np
import xarray as xr

import pipeline
from pipeline.analysis.dataset import scene_sweep
from pipeline.analysis.laboratory import model_error
from pipeline.analysis.tables import frame_of
from pipeline.cli import given
from pipeline.cli.output import Result, rounded, working
from pipeline.cli.values import setting
from pipeline.sweep.own_laws import own_laws
from pipeline.sweep.stored import misfits
from pipeline.sweep.unknown import Unknown
from pipeline.uncertain.design import RISK, RISK_OF_MARGIN, Direct, Goal, Limit, designed, directly
from pipeline.uncertain.direct import SceneWith
from pipeline.uncertain.fields import SampleField, single_field
from tribo import InputError, TriboError

_LINE = 9  # values of the first of two entries


def design(options: argparse.Namespace) -> Result:
    """Print the value of an entry that reaches a goal, or of two entries a line in their plane."""
    goal, entries = _goal(options), options.entries
    if len(entries) > 2 or len(set(entries)) < len(entries):
        raise InputError(f"--over is {', '.join(entries)}; give one entry, or two different ones")
    ds = given.dataset_in(options)
    with working("weighing the inputs"):
        samples = single_field(ds)
    basis, notes = samples.basis
    scatter = model_error(ds, samples)
    run = {"scatter": scatter, "friction_scatter": 0.0 if samples.rig is None else samples.rig}
    shift, direct = 0.0, None
    for seed in range(2):  # the first time to correct the limit, the second to check it
        with working("seeking the limit") as progress:
            limits = list(_limits(samples, goal, entries, shift, run, progress))
        found = [pair for pair in limits if pair[1].value is not None] or limits
        at, limit = found[len(found) // 2]
        direct, reason = _simulated(ds, samples, limit, at, shift, seed, run)
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
        answer, text = limit.as_dict(), [_word_limit(limit)]
    document = basis | answer | {"model_error": scatter.worded}
    document["direct"] = direct and asdict(direct)
    fits = not (samples.posterior and samples.posterior.misfit)
    document["confirmed"] = bool(fits and direct and direct.agrees_with(goal.risk))
    text += [*(_describe_check(goal, limit, at, direct, reason) if fits else ())]
    text += [f"the model's own error: {scatter.worded}", *notes]
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
    samples: SampleField,
    goal: Goal,
    entries: Sequence[str],
    shift: float,
    run: Mapping[str, Any],
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
        told = samples.ensemble, goal, last, samples.given_draws, at, shift
        yield at, pipeline.design(*told, **run)


def _simulated(
    ds: xr.Dataset,
    samples: SampleField,
    limit: Limit,
    at: Mapping[str, float],
    shift: float,
    seed: int,
    run: Mapping[str, Any],
) -> tuple[Direct | None, str]:
    """Direct simulations at a limit; or why there are none."""
    if limit.value is None:
        return None, ""
    values = {**at, limit.entry.path: limit.value}
    place = limit.goal, limit.binding
    try:
        scene_with = read_scene(ds)
        with working("simulating draws near the limit") as progress:
            direct = directly(
                samples.ensemble, *place, values, scene_with, samples.given_draws, progress,
                shift=shift, seed=seed, **run,
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


def _word_limit(limit: Limit) -> str:
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


def _describe_check(
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


def read_scene(ds: xr.Dataset) -> SceneWith:
    """Reader of the scene of a store with other entries, if its file is still the same."""
    stored = scene_sweep(ds)
    path, *words = stored.about.arguments or [""]
    given = [word.partition("=")[::2] for word in words]
    settings = dict(setting(value) for flag, value in given if flag == "--set")
    preset = next((value for flag, value in given if flag == "--preset"), None)
    if own_laws(stored.scene):
        raise InputError("it has laws of its own, and no code runs because a store names it")
    read = partial(pipeline.load_scene, path, preset)  # also without the user's own laws
    if not path or [*misfits(stored, read(settings))]:
        raise InputError(f"{path or 'the scene'} is not the scene of the store any more")
    left_out = settings.pop("without", [])
    left_out = [left_out] if isinstance(left_out, str) else left_out
    alone = {"without": [*left_out, "unknown", "sweep.samples"]}
    return lambda entries: read(settings | alone | dict(entries))
