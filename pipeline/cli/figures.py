"""The command that draws a figure of a store."""

from __future__ import annotations

import argparse

import pipeline
from pipeline.cli import given
from pipeline.cli.output import Result
from pipeline.figures.plot import KINDS, options_of
from tribo import InputError

_OF_KINDS = (*given.PLACE, "log", "show")
"""Options that only some kinds of figures have, beside the conditions."""


def plot(options: argparse.Namespace) -> Result:
    """Draw a figure of a store."""
    look = given.values_in(options, *_OF_KINDS)
    allowed = [name for name in options_of(KINDS[options.kind]) if name in _OF_KINDS]
    if others := [name for name in look if name not in allowed]:
        flag, flags = given.flags_of(others[:1]), given.flags_of(allowed) or "none of these"
        raise InputError(f"--kind {options.kind} takes no {flag}; it takes {flags}")
    look |= given.values_in(options, "width", "plain")
    ds = given.dataset_in(options)
    out = options.output or given.beside(options.store, f"_{options.kind}.png")
    written = str(pipeline.plot(ds, options.kind, out, **look))
    return Result({"kind": options.kind, "file": written}, [written], pipeline.warned(ds))
