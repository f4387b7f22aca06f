"""What the command ``irg design`` answers."""

from __future__ import annotations

import argparse
import math
from collections.abc import Sequence
from dataclasses import asdict
from functools import partial
from typing import Any

import numpy as np
import xarray as xr

import pipeline
from pipeline.analysis.dataset import scene_sweep, taken_at
from pipeline.analysis.laboratory import model_error
from pipeline.analysis.margin import NOT_DECIDED
from pipeline.analysis.tables import frame_of
from pipeline.cli import given
from pipeline.cli.output import Result, working
from pipeline.cli.values import setting
from pipeline.scene.along import Place
from pipeline.sweep.conditions import PATHS
from pipeline.sweep.own_laws import own_laws
from pipeline.sweep.stages import Progress
from pipeline.sweep.stored import misfits
from pipeline.sweep.unknown import Fixed
from pipeline.uncertain.design import RISK, RISK_OF_MARGIN, Chances, Direct, Goal, Limit
from pipeline.uncertain.direct import SceneWith
from pipeline.uncertain.fields import single_field
from tribo import InputError, TriboError

_LINE = 9  # values of the first of two entries


def design(options: argparse.Namespace) -> Result:
    """Print the value of an entry that reaches a goal, or of two entries a line in their plane."""
    goal, entries = _goal(options), _sought_entries(options)
    ds = given.dataset_in(options)
    with working("weighing the inputs"):
        samples = single_field(ds)
    basis, notes = samples.basis
    scatter = model_error(ds, samples)
    chances = Chances(samples.ensemble, goal, samples.given_draws, scatter, samples.rig_scatter)
    for seed in range(2):  # the first time to correct the limit, the second to check it
        limits = _limits(chances, entries)
        found = [one for one in limits if one.value is not None] or limits
        limit = found[len(found) // 2]
        direct, reason = _simulated(ds, chances, limit, seed)
        if direct is None:
            break
        chances.shift, chances.spare = direct.shift, direct.spare
    path = limit.entry.path
    if limit.at:
        (other,) = limit.at
        rows = ((one.at[0].value, one.side, one.value) for one in limits)
        frame = frame_of((other.unknown.path, "side", path), rows)
        line = [
            {"at": {fixed.unknown.path: fixed.value for fixed in one.at}, **one.as_dict()}
            for one in limits
        ]
        answer: dict[str, Any] = {"line": line}
        text = [f"{path} by {other.unknown.path}, in SI, for {_wanted(goal)}", frame]
    else:
        points = zip(limit.values, limit.probabilities, strict=True)
        frame = frame_of((f"{path} [{limit.entry.unit}]", "probability"), points)
        answer, text = limit.as_dict(), [_word_limit(limit)]
    is_known = samples.ensemble.velocity_error is not None
    confirmed = bool(is_known and direct and direct.confirms(goal.risk))
    document = basis | answer | {
        "model_error": scatter.worded,
        "numerical_error": math.expm1(chances.numerical) if is_known else None,
        "direct": direct and asdict(direct) | {"highest": direct.highest}, "confirmed": confirmed,
    }  # fmt: skip
    if limit.value is not None:
        reason = reason or ("" if is_known else "the error of the samples' fidelity is not known")
        text.append(_describe_check(limit, direct, reason))
    if is_known:
        text.append(f"rises up to {100 * math.expm1(chances.numerical):.2g} % higher are counted")
    text += [f"the model's own error: {scatter.worded}", *notes]
    draw = partial(pipeline.plot, limits, title=samples.ensemble.title)
    return Result(document, text, pipeline.warned(ds), [frame], draw)


def _sought_entries(options: argparse.Namespace) -> Sequence[str]:
    """The one entry or the two that are sought."""
    entries: list[str] = options.entries
    if len(entries) > 2 or len(set(entries)) < len(entries):
        raise InputError(f"--over is {', '.join(entries)}; give one entry, or two different ones")
    fixed = {PATHS[name] for name in given.conditions_in(options) if name in PATHS}
    for path in entries:
        if path in fixed | given.judged_entries(options).keys():
            raise InputError(f"{path} is given and sought by --over; leave one of them out")
    return entries


def _goal(options: argparse.Namespace) -> Goal:
    """Operating points, and what is to be reached at them."""
    if options.risk is not None and options.margin is not None:
        raise InputError("--risk and --margin are two goals; give one of them")
    sought = [name for name in Place._fields if name in options.entries]
    if twice := [name for name in sought if getattr(options, name) is not None or options.points]:
        (name, *_), where = twice, "--points" if options.points else f"--{twice[0]}"
        raise InputError(f"the {name} is sought by --over, and given by {where}; leave one out")
    known = argparse.Namespace(**vars(options) | dict.fromkeys(sought, math.nan))
    points = given.operating_points_in(known)
    points.require_places_alone("a design is sought at loads and velocities alone")
    if options.margin is not None:
        return Goal(points.places, RISK_OF_MARGIN, options.margin)
    return Goal(points.places, RISK if options.risk is None else options.risk)


def _limits(chances: Chances, entries: Sequence[str]) -> list[Limit]:
    """Limits of the last entry, at each of some values of another one if there are two."""
    *first, last = entries
    places: list[dict[str, float]] = [{}]
    for path in first:
        low, high = chances.entry(path).parameters
        places = [{path: value} for value in np.linspace(low, high, _LINE).tolist()]
    limits = []
    with working("seeking the limit") as progress:
        for number, at in enumerate(places):
            progress(Progress(done=number, total=len(places)))
            limits.append(chances.limit(last, at))
    return limits


def _simulated(
    ds: xr.Dataset, chances: Chances, limit: Limit, seed: int
) -> tuple[Direct | None, str]:
    """Direct simulations at a limit; or why there are none."""
    if limit.value is None:
        return None, ""
    try:
        scene_with = read_scene(ds)
        with working("simulating draws near the limit") as progress:
            return chances.simulated(limit, scene_with, seed, progress), ""
    except (TriboError, OSError) as error:
        return None, str(error).splitlines()[0]


def _worded(fixed: Fixed) -> str:
    shown = fixed.unknown.shown
    return f"{shown.express(fixed.value):.4g}{shown.suffix}"


def _percent(probability: float, beside: float) -> str:
    """A probability in as many digits as tell it from another one."""
    other = f"{100 * beside:g} %"
    texts = (f"{float(f'{100 * probability:.{digits}g}'):g} %" for digits in range(3, 7))
    return next((text for text in texts if text != other or probability == beside), other)


def _wanted(goal: Goal) -> str:
    if goal.margin:
        return f"{goal.margin:g} K below the critical temperature with {100 * (1 - goal.risk):g} %"
    return f"a risk of {100 * goal.risk:g} %"


def _word_limit(limit: Limit) -> str:
    """The limit of one entry, in a line."""
    path, place, goal = limit.entry.path, limit.binding, limit.goal
    value, low, high = (
        _worded(Fixed(limit.entry, one))
        for one in (limit.value or limit.best[0], *(limit.interval or limit.entry.parameters))
    )
    where = " and ".join(
        f"{number:g} {unit}"
        for name, number, unit in zip(Place._fields, place, ("N", "m/s"), strict=True)
        if name != path
    )
    where = f"{_wanted(goal)} at {where}"
    if len(goal.places) > 1:
        where += f", the worst of {len(goal.places)} points"
    if limit.side == NOT_DECIDED:
        return f"{path} is not decided for {where}: the tests contradict the model"
    if limit.side == "none":
        best = _percent(limit.best[1], goal.risk)
        return f"not by {path} alone: {best} with {value}, the least, for {where}"
    if limit.value is None:
        return f"{path}: any value from {low} to {high} does for {where}"
    sign = "≥" if limit.side == "at least" else "≤"
    also = ""
    if limit.side == "between" and limit.safe:
        also = f" and ≥ {_worded(Fixed(limit.entry, limit.safe[0]))}"
    return f"{path} {sign} {value}{also} ({low} to {high}) for {where}"


def _describe_check(limit: Limit, direct: Direct | None, reason: str) -> str:
    """What direct simulations say of the limit, in a line."""
    if direct is None or reason:
        return f"  not confirmed by direct simulations: {reason}"
    risk, fixed = limit.goal.risk, [*limit.at, Fixed(limit.entry, limit.value or 0.0)]
    where = ", ".join(f"{one.unknown.path} {_worded(one)}" for one in fixed)
    is_confirmed = direct.confirms(risk)
    said = "confirmed" if is_confirmed else "warning: not confirmed"
    instead = "" if is_confirmed else "; run more samples"
    return (
        f"  {said} with {where}: {_percent(direct.probability, risk)} ± "
        f"{100 * direct.error:.2g} %, below {_percent(direct.highest, risk)} with 95 % "
        f"probability, by {direct.draws} new draws, of which {direct.simulated} near the limit "
        f"were simulated{instead}"
    )


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
    samples = ("unknown", "sweep.samples")  # entries, which settings may have changed
    settings = {key: one for key, one in settings.items() if not key.startswith(samples)}
    alone = {"without": [*left_out, *samples]}
    taken = taken_at(ds)
    return lambda entries: read(settings | alone | dict(entries)).variant(taken)
