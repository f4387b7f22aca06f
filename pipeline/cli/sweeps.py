"""The command that computes a sweep."""

from __future__ import annotations

import argparse
import shlex
from contextlib import nullcontext
from pathlib import Path

import pipeline
from pipeline.cli.output import DONE, SOME_FAILED, Result, failed_points, run_line, tell
from pipeline.cli.scenes import scene_of, selected
from pipeline.run.cluster import client_of
from pipeline.scene.facts import require_bearable_load
from pipeline.sweep.physics import note_on_turns


def run(options: argparse.Namespace) -> Result:
    """Run or resume a sweep, or the part of it that the boundary needs."""
    out = options.output or Path("results") / f"{options.scene.stem}.zarr"
    sweep = scene_of(options, store=out)
    for note in sweep.about.notes:
        tell(f"note: {note}")
    require_bearable_load(sweep, min(sweep.plane.loads), "sweep.loads")
    if cold := note_on_turns(sweep):
        tell(f"warning: {cold}")
    is_elsewhere = options.scheduler or options.scheduler_file
    elsewhere = client_of(options.scheduler, options.scheduler_file) if is_elsewhere else None
    with elsewhere or nullcontext() as client, run_line() as progress:
        settings = {
            "workers": options.workers,
            "client": client,
            "dashboard": options.dashboard,
            "progress": progress,
            "retry_failed": options.retry_failed,
            "tell": tell,
        }
        if options.boundary_only is None:
            outcome = pipeline.run_sweep(sweep, out, **settings)
        else:
            outcome = pipeline.follow_boundary(sweep, out, options.boundary_only, **settings)
    document = {
        "store": str(out),
        "points": outcome.total,
        "computed": outcome.computed,
        "done": outcome.done,
        "failed": failed_points(outcome.failed),
        "wall_time": outcome.wall_time,
        **selected(sweep),
    }
    text = [
        f"{out}: {outcome.done} of {outcome.total} points done, {outcome.computed} of them now, "
        f"in {outcome.wall_time:.1f} s",
        *(f"failed: {point}" for point in outcome.failed),
    ]
    if outcome.failed:
        text.append("try these again with: the same command and --retry-failed")
    elif outcome.done:
        names = sweep.variants.answers
        own = sweep.conditions.own_criterion
        word = ["--criterion", own.reference, "--own-laws"] if own else []
        commands = (shlex.join(["irg", name, str(out), *word]) for name in names)
        text.append(f"next: {', '.join(commands)}")
    return Result(
        document, text, pipeline.warned(out), code=SOME_FAILED if outcome.failed else DONE
    )
