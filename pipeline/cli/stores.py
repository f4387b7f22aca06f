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
    found = pipeline.summary(options.store)
    selection = pipeline.stored_selection(options.store)
    warned = pipeline.warned(options.store) if found.warned else NO_WARNING
    document = {
        "title": found.title,
        "points": found.total,
        "done": found.done,
        "failed": failed_points(found.failed),
        "pending": found.pending,
        "done_earlier": found.earlier,
        "running": found.running is not None,
        "points_per_minute": None if found.rate is None else 60 * found.rate,
        "time_to_go": found.time_to_go,
        "selection": selection.as_dict() if selection else None,
    }
    text = [
        found.title,
        f"{found.total} points: {found.done} done, {len(found.failed)} failed, "
        f"{found.pending} pending",
        *_more_text(found),
        *([str(selection)] if selection else []),
        *(f"failed: {point}" for point in found.failed),
    ]
    show(options, document, text, warned=warned)
    return SOME_FAILED if found.failed else DONE


def _more_text(found: Summary) -> Iterable[str]:
    """Points beyond those that were asked for, and the pace of a run."""
    if found.earlier:
        yield f"{found.earlier} more are done, for which an earlier run asked"
    if found.running:
        yield f"running: {found.running}"
    if found.pending and found.rate and found.time_to_go:
        when = "now" if found.running else "the last time"
        yield (
            f"{_pace(60 * found.rate)} points a minute {when}, {duration(found.time_to_go)} to go"
        )


def verify(options: argparse.Namespace) -> int:
    """Read everything and name what is damaged."""
    with working("reading points") as progress:
        found = pipeline.verify_store(options.store, options.repair, progress)
    document = {
        "done": found.done,
        "damaged": failed_points(found.damaged),
        "damaged_records": failed_points(found.records),
        "shared": found.shared,
        "without_status": [point._asdict() for point in found.without_status],
        "repaired": found.repaired,
    }
    text = [
        f"{found.done} points are done and intact, {len(found.damaged)} are damaged",
        *(f"damaged: {damage}" for damage in found.damaged),
        *(f"damaged, but not its data: {damage}" for damage in found.records),
        *(f"damaged: {fault}" for fault in found.shared),
        *(
            f"complete, but without a status: {point}; "
            + ("done again" if found.repaired else "the next run takes it as done")
            for point in found.without_status
        ),
    ]
    if not found.is_clean:
        text.append(
            "repaired; damaged points are pending, and computed again by: irg run"
            if found.repaired
            else "set damaged points to be computed again with: irg verify --repair"
        )
    is_readable = found.is_clean or found.repaired
    show(options, document, text, warned=pipeline.warned(options.store) if is_readable else None)
    return DONE if found.is_clean else SOME_FAILED


def _pace(per_minute: float) -> str:
    """Write a number with three digits, or all before the point.

    Examples
    --------
    >>> _pace(1.5), _pace(4218.3)
    ('1.5', '4218')
    """
    return f"{per_minute:.0f}" if per_minute >= 100 else f"{per_minute:.3g}"
