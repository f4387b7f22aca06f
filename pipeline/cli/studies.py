"""The commands that study a scene: its inputs one by one, limits of a design, its errors."""

from __future__ import annotations

import argparse
import itertools
import math
from collections.abc import Callable, Iterator, Mapping
from functools import partial
from typing import TYPE_CHECKING, Any

import numpy as np

import pipeline
from pipeline.analysis.tables import frame_of, short
from pipeline.cli.datasets import opened, operating_points_in, scene_with_of
from pipeline.cli.output import Result, run_line, tell, working
from pipeline.cli.scenes import beside, criterion_in, scene_of, settings_of
from pipeline.cli.unknowns import about, ensemble_in, notes
from pipeline.uncertain.design import RISK, RISK_OF_MARGIN, Goal, Limit, confirmed, designed
from tribo import InputError, TriboError

if TYPE_CHECKING:
    import pandas as pd
    import xarray as xr

    from pipeline.run.vary import Variations
    from pipeline.sweep.unknown import Unknown
    from pipeline.uncertain.design import Direct
    from pipeline.uncertain.ensemble import Ensemble
    from pipeline.uncertain.inputs import Draws

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
            settings_of(options),
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
    measured = pipeline.trade(scene_of(options), base=options.base, progress=tell)
    draw = partial(pipeline.draw_trade, measured)
    return Result(measured.as_dict(), [str(measured)], frames=[measured.table], draw=draw)


_LINE = 9  # values of the first of two entries


def design(options: argparse.Namespace) -> Result:
    """Print the value of an entry that reaches a goal, or of two entries a line in their plane."""
    goal, entries = _goal(options), options.entries
    if len(entries) > 2 or len(set(entries)) < len(entries):
        raise InputError(f"--over is {', '.join(entries)}; give one entry, or two different ones")
    ds = opened(options)
    ensemble, weighed = ensemble_in(options, ds, **criterion_in(options))
    draws = weighed.draws if weighed else None
    *first, last = entries
    with working("seeking the limit") as progress:
        limits = list(_limits(ensemble, goal, first, last, draws, progress))
    at, limit = _middle(limits)
    direct, reason = _checked(ds, ensemble, limit, at, draws)
    document = {
        "given_measured": weighed is not None,
        **about(ensemble),
        **(limit.as_dict() if not first else _line(limits)),
        "direct": direct and direct.as_dict(),
        "confirmed": bool(direct and direct.agrees_with(goal.risk)),
    }
    text = [
        *(_on_line(limits) if first else [_in_words(limit)]),
        *_on_check(goal, limit, at, direct, reason),
        *notes(ensemble, weighed),
    ]
    frames = [_table(limits) if first else _curve(limit)]
    draw = partial(pipeline.draw_design, [(dict(at), limit) for at, limit in limits], ensemble)
    return Result(
        document, text, pipeline.warned(ds), frames, draw, beside(options.store, "_design.png")
    )


def _goal(options: argparse.Namespace) -> Goal:
    """Operating points, and what is to be reached at them."""
    if options.risk is not None and options.margin is not None:
        raise InputError("--risk and --margin are two goals; give one of them")
    places = operating_points_in(options).places
    if options.margin is not None:
        return Goal(places, RISK_OF_MARGIN, options.margin)
    return Goal(places, RISK if options.risk is None else options.risk)


def _limits(
    ensemble: Ensemble, goal: Goal, first: list[str], last: str, draws: Draws | None,
    progress: Callable[[int, int], None],
) -> Iterator[tuple[tuple[tuple[str, float], ...], Limit]]:  # fmt: skip
    """Limits of an entry, at each of some values of another one if there are two."""
    if not first:
        yield (), pipeline.design(ensemble, goal, last, draws)
        return
    low, high = designed(ensemble, first[0]).parameters
    values = np.linspace(low, high, _LINE).tolist()
    for number, value in enumerate(values):
        progress(number, _LINE)
        at = {first[0]: value}
        yield tuple(at.items()), pipeline.design(ensemble, goal, last, draws, at)


def _middle(limits: list[tuple[Any, Limit]]) -> tuple[dict[str, float], Limit]:
    """The middle one of those that have a limit; else of all."""
    found = [pair for pair in limits if pair[1].value is not None] or limits
    at, limit = found[len(found) // 2]
    return dict(at), limit


def _checked(
    ds: xr.Dataset, ensemble: Ensemble, limit: Limit, at: Mapping[str, float],
    draws: Draws | None,
) -> tuple[Direct | None, str]:  # fmt: skip
    """Direct simulations at a limit; or why there are none."""
    if limit.value is None:
        return None, ""
    values = {**at, limit.entry.path: limit.value}
    try:
        scene_with = scene_with_of(ds)
        with working("simulating draws near the limit") as progress:
            check = confirmed(
                ensemble, limit.goal, limit.binding, values, scene_with, draws, progress
            )
    except (TriboError, OSError) as error:
        return None, str(error).splitlines()[0]
    return check, ""


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
        best = f"{100 * limit.best[1]:.2g} % at best, with {_worded(limit.entry, limit.best[0])}"
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


def _line(limits: list[tuple[Any, Limit]]) -> dict[str, Any]:
    """Limits of an entry by values of another one, as plain data."""
    return {"line": [{"at": dict(at), **limit.as_dict()} for at, limit in limits]}


def _table(limits: list[tuple[Any, Limit]]) -> pd.DataFrame:
    """Limits of an entry by values of another one, in SI."""
    ((path, _),), first = limits[0][0], limits[0][1]
    rows = ((at[0][1], one.side, one.value) for at, one in limits)
    return frame_of((path, "side", first.entry.path), rows)


def _on_line(limits: list[tuple[Any, Limit]]) -> Iterator[str | pd.DataFrame]:
    goal, entry = limits[0][1].goal, limits[0][1].entry
    yield f"{entry.path} by {limits[0][0][0][0]}, in SI, for {_wanted(goal)}"
    yield _table(limits)


def _curve(limit: Limit) -> pd.DataFrame:
    """Probability by the values of an entry."""
    heads = f"{limit.entry.path} [{limit.entry.unit}]", "probability"
    return frame_of(heads, zip(limit.values, limit.probabilities, strict=True))
