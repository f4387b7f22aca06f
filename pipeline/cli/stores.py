"""The commands that look after a store."""

from __future__ import annotations

import argparse
from collections.abc import Iterable
from typing import TYPE_CHECKING

import pipeline
from pipeline.cli.exit_codes import DONE, SOME_FAILED
from pipeline.cli.output import failed_points, show
from pipeline.cli.progress import working
from pipeline.sweep.stages import duration
from pipeline.sweep.warned import NO_WARNING

if TYPE_CHECKING:
    from pipeline.store.progress import Summary


def status(options: argparse.Namespace) -> int:
    """Count points."""
    state = pipeline.summary(options.store)
    selection = pipeline.stored_selection(options.store)
    warned = pipeline.warned(options.store) if state.warned else NO_WARNING
    document = {
        "title": state.title,
        "points": state.total,
        "done": state.done,
        "failed": failed_points(state.failed),
        "pending": state.pending,
        "done_earlier": state.earlier,
        "running": state.running is not None,
        "points_per_minute": None if state.rate is None else 60 * state.rate,
        "time_to_go": state.time_to_go,
        "selection": selection.as_dict() if selection else None,
    }
    text = [
        state.title,
        f"{state.total} points: {state.done} done, {len(state.failed)} failed, "
        f"{state.pending} pending",
        *_more_text(state),
        *([str(selection)] if selection else []),
        *(f"failed: {point}" for point in state.failed),
    ]
    show(options, document, text, warned=warned)
    return SOME_FAILED if state.failed else DONE


def _more_text(state: Summary) -> Iterable[str]:
    """Points beyond those that were asked for, and the pace of a run."""
    if state.earlier:
        yield f"{state.earlier} more are done, for which an earlier run asked"
    if state.running:
        yield f"running: {state.running}"
    if state.pending and state.rate and state.time_to_go:
        when = "now" if state.running else "the last time"
        yield (
            f"{_pace(60 * state.rate)} points a minute {when}, {duration(state.time_to_go)} to go"
        )


def verify(options: argparse.Namespace) -> int:
    """Read everything and name what is damaged."""
    with working("reading points") as progress:
        check = pipeline.verify_store(options.store, options.repair, progress)
    document = {
        "done": check.done,
        "damaged": failed_points(check.damaged),
        "damaged_records": failed_points(check.records),
        "shared": check.shared,
        "without_status": [point._asdict() for point in check.without_status],
        "repaired": check.repaired,
    }
    text = [
        f"{check.done} points are done and intact, {len(check.damaged)} are damaged",
        *(f"damaged: {damage}" for damage in check.damaged),
        *(f"damaged, but not its data: {damage}" for damage in check.records),
        *(f"damaged: {fault}" for fault in check.shared),
        *(
            f"complete, but without a status: {point}; "
            + ("done again" if check.repaired else "the next run takes it as done")
            for point in check.without_status
        ),
    ]
    if not check.is_clean:
        text.append(
            "repaired; damaged points are pending, and computed again by: irg run"
            if check.repaired
            else "set damaged points to be computed again with: irg verify --repair"
        )
    is_readable = check.is_clean or check.repaired
    show(options, document, text, warned=pipeline.warned(options.store) if is_readable else None)
    return DONE if check.is_clean else SOME_FAILED


def _pace(per_minute: float) -> str:
    """Write a number with three digits, or all before the point.

    Examples
    --------
    >>> _pace(1.5), _pace(4218.3)
    ('1.5', '4218')
    """
    return f"{per_minute:.0f}" if per_minute >= 100 else f"{per_minute:.3g}"
