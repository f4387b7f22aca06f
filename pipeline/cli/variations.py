"""The command that changes one input at a time."""

from __future__ import annotations

import argparse
import math
import re
from collections.abc import Iterator
from functools import partial
from typing import TYPE_CHECKING, Any

import pipeline
from pipeline.analysis.transition import CROSSES, OUTCOMES
from pipeline.cli.exit_codes import DONE
from pipeline.cli.output import output_path, show, tell
from pipeline.cli.scenes import scene_of, settings_of
from tribo import InputError

if TYPE_CHECKING:
    from pipeline.run.vary import Variation, Variations

_RELATIVE = re.compile(r"([+-]\d+(?:\.\d+)?)\s*%")
_QUANTITY = re.compile(r"\s*([+-]?[\d.]+(?:[eE][+-]?\d+)?)\s*(.*)")


def vary(options: argparse.Namespace) -> int:
    """Print and draw the boundary for each value of some entries."""
    out = output_path(options)
    others = {
        (key, str(value)): scene_of(_with(options, key, value))
        for key, values in options.over
        for value in _absolute(options, key, values)
    }
    found = pipeline.vary(scene_of(options), others, tell=tell)
    draw = partial(pipeline.draw_variations, found)
    show(
        options, found.as_dict(), _text(found),
        warned=found.warned, out=out, rows=_rows(found), draw=draw,
    )  # fmt: skip
    return DONE


def _rows(found: Variations) -> Iterator[dict[str, Any]]:
    """Rows of a table, one for each value and load."""
    for each in (found.own, *found.others):
        changes = found.changes(each) if each.key else [None] * len(found.loads)
        for load, velocity, change, outcome in zip(
            found.loads, each.critical_velocities, changes, each.outcomes, strict=True
        ):
            yield {
                "entry": each.key or "as it is",
                "value": each.value,
                "load [N]": load,
                "critical velocity [m/s]": velocity,
                "change": change,
                "outcome": outcome,
            }


def _with(options: argparse.Namespace, key: str, value: Any) -> argparse.Namespace:
    """The options with one entry set, whatever --set says of it."""
    settings = settings_of(options) | {key.removeprefix("fidelity."): value}
    return argparse.Namespace(**{**vars(options), "set": [*settings.items()]})


def _absolute(options: argparse.Namespace, key: str, values: list[Any]) -> Iterator[Any]:
    """Values of an entry; of those such as +20%, what they make of the scene's own."""
    for value in values:
        relative = _RELATIVE.fullmatch(value) if isinstance(value, str) else None
        if relative is None:
            yield value
            continue
        own = pipeline.scene_entry(options.scene, key, settings_of(options))
        factor = 1 + float(relative[1]) / 100
        if isinstance(own, int | float) and not isinstance(own, bool):
            yield float(f"{own * factor:.12g}")
        elif isinstance(own, str) and (parts := _QUANTITY.fullmatch(own)):
            if parts[2].startswith(("deg", "°", "C")):
                raise InputError(
                    f"--over {key}={value}: the scene gives {own}, and what a percentage of a "
                    "temperature is depends on its scale; give a value such as 150 degC"
                )
            yield f"{float(parts[1]) * factor:.12g} {parts[2]}"
        else:
            raise InputError(
                f"--over {key}={value}: the scene gives no number there to change; give a value"
            )


def _text(found: Variations) -> Iterator[str]:
    """A table of critical velocities, a row for each value."""
    heads = " ".join(f"{f'{load:g} N':>15}" for load in found.loads)
    width = max([18, *(len(each.value) + 4 for each in found.others)])
    yield f"{'critical velocity [m/s]':{width}} {heads}"
    yield f"{'as it is':{width}} {_cells(found, found.own)}".rstrip()
    for key, variations in found.by_key().items():
        yield key
        for each in variations:
            yield f"    {each.value:{width - 4}} {_cells(found, each)}".rstrip()
    outcomes = {outcome for each in (found.own, *found.others) for outcome in each.outcomes}
    if none := sorted(outcomes - {OUTCOMES[CROSSES]}):
        yield ""
        yield "without a transition between the sweep's velocities: " + ", ".join(
            f"{outcome.split()[0]} = {outcome}" for outcome in none
        )


def _cells(found: Variations, variation: Variation) -> str:
    """Critical velocities and their changes in columns; or in a word, why there is none."""
    changes = found.changes(variation) if variation.key else [math.nan] * len(found.loads)
    cells = (
        f"{velocity:6.3g} {_percent(change):>8}"
        if math.isfinite(velocity)
        else f"{outcome.split()[0]:>6} {'':8}"
        for velocity, change, outcome in zip(
            variation.critical_velocities, changes, variation.outcomes, strict=True
        )
    )
    return " ".join(cells)


def _percent(change: float) -> str:
    return f"{100 * change:+.1f} %" if math.isfinite(change) else ""
