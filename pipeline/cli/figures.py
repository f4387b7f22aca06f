"""The commands that draw a figure of a store, or write a report or a page of it."""

from __future__ import annotations

import argparse
from collections.abc import Iterable
from typing import Any

import pipeline
from pipeline.cli import given
from pipeline.cli.output import Result, tell, working
from tribo import InputError

_OF_KINDS = (*given.PLACE, *given.CONDITIONS, "log", "show", "against", "given_measured", "scatter")
"""Options that only some kinds of figures have."""


def plot(options: argparse.Namespace) -> Result:
    """Draw a figure of a store."""
    look = given.values_in(
        options, *given.PLACE, "scatter", "width", "log", "show", "against", "given_measured"
    )
    conditions = given.conditions_in(options)
    _require_options(options.kind, [*look, *conditions])
    look |= {"with_title": not options.no_title}
    if options.watch:
        return _watched(options, look | conditions)
    ds = given.opened(options)
    out = options.output or given.beside(options.store, f"_{options.kind}.png")
    written = pipeline.plot(ds, options.kind, out, **look, **conditions)
    document = {"kind": options.kind, "file": str(written)}
    return Result(document, [str(written)], pipeline.warned(ds, **conditions))


def _watched(options: argparse.Namespace, look: dict[str, Any]) -> Result:
    """Draw the figure as points come."""
    from pipeline.figures.plot import watch  # with xarray

    state = watch(
        options.store,
        options.watch,
        options.kind,
        read=lambda: given.opened(options),
        progress=lambda state: tell(f"{state.done} of {state.total} points drawn"),
        **look,
    )
    document = {
        "kind": options.kind,
        "file": str(options.watch),
        "done": state.done,
        "points": state.total,
    }
    text = f"{options.store}: {state.done} of {state.total} points done, and no run goes on"
    return Result(document, [text])


def _require_options(kind: str, names: Iterable[str]) -> None:
    """Raise an `InputError` that names, as it is typed, an option that a kind of figure lacks."""
    from pipeline.figures.plot import options_of

    allowed = [name for name in options_of(kind) if name in _OF_KINDS]
    for name in names:
        if name in _OF_KINDS and name not in allowed:
            flag, others = given.flags_of([name]), given.flags_of(allowed)
            raise InputError(f"--kind {kind} takes no {flag}; it takes {others}")


def explore(options: argparse.Namespace) -> Result:
    """Write a page to explore a store in a browser."""
    ds = given.opened(options)
    out = options.output or given.beside(options.store, ".html")
    criterion = given.criterion_in(options)
    chosen = given.values_in(options, "scatter", "given_measured") | criterion
    if options.no_fields:
        chosen["most_fields"] = 0
    with working("writing the page"):
        page = pipeline.explore(ds, out, **chosen)
    return Result(page.as_dict(), [str(page)], pipeline.warned(ds, **criterion))


def report(options: argparse.Namespace) -> Result:
    """Write a report of a store."""
    ds, conditions = given.opened(options), given.conditions_in(options)
    out = options.output or given.beside(options.store, "_report.html")
    with working("writing the report"):
        written = pipeline.report(ds, out, options.points, **conditions)
    warned = pipeline.warned(ds, **conditions)
    return Result({"file": str(written)}, [str(written)], warned)
