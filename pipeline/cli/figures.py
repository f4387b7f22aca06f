"""The command that draws a figure of a store."""

from __future__ import annotations

import argparse

import pipeline
from pipeline.cli import given
from pipeline.cli.output import Result, tell
from pipeline.figures.plot import KINDS, options_of, watch
from tribo import InputError

_OF_KINDS = (*given.PLACE, "log", "show")
"""Options that only some kinds of figures have, beside the conditions."""


def plot(options: argparse.Namespace) -> Result:
    """Draw a figure of a store, or draw it again and again as points come."""
    kind = options.kind
    look = given.values_in(options, *_OF_KINDS)
    allowed = [name for name in options_of(KINDS[kind]) if name in _OF_KINDS]
    if others := [name for name in look if name not in allowed]:
        flag, flags = given.flags_of(others[:1]), given.flags_of(allowed)
        raise InputError(f"--kind {kind} takes no {flag}; it takes {flags}")
    look |= given.values_in(options, "width") | {"with_title": not options.no_title}
    if not options.watch:
        ds = given.dataset_in(options)
        out = options.output or given.beside(options.store, f"_{kind}.png")
        written = pipeline.plot(ds, kind, out, **look)
        warned = pipeline.warned(ds)
        return Result({"kind": kind, "file": str(written)}, [str(written)], warned)
    state = watch(
        options.store,
        options.watch,
        kind,
        read=lambda: given.dataset_in(options),
        progress=tell,
        **look,
    )
    document = {"kind": kind, "file": str(options.watch)}
    document |= {"done": state.done, "points": state.total}
    text = f"{options.store}: {state.done} of {state.total} points done, and no run goes on"
    return Result(document, [text])
