"""The commands that say what a sweep takes, and compute it."""

from __future__ import annotations

import argparse
from pathlib import Path

import pipeline
from pipeline.cli.meaning import meaning
from pipeline.cli.output import (
    DONE,
    SOME_FAILED,
    ProgressLine,
    duration,
    failed_points,
    show,
    tell,
)
from pipeline.cli.scenes import scene_of, selected
from pipeline.run import forkserver
from pipeline.sweep.doubts import doubts
from pipeline.sweep.facts import facts_of, require_bearable_loads
from pipeline.sweep.left_out import left_out
from pipeline.tradeoff.forecast import machine_bytes, worker_bytes


def run(options: argparse.Namespace) -> int:
    """Run or resume a sweep, or the part of it that the boundary needs."""
    if options.scheduler is None:
        forkserver.start()
    out = options.output or Path("results") / f"{options.scene.stem}.zarr"
    sweep = scene_of(options, store=out)
    for note in sweep.notes:
        tell(f"note: {note}")
    with ProgressLine() as line:
        cluster = {
            "workers": options.workers,
            "scheduler": options.scheduler,
            "progress": line,
            "retry_failed": options.retry_failed,
            "tell": tell,
        }
        if options.boundary_only is None:
            outcome = pipeline.run_sweep(sweep, out, **cluster, fill_fields=options.fill_fields)
        else:
            outcome = pipeline.follow_boundary(sweep, out, options.boundary_only, **cluster)
    document = {
        "store": str(out),
        "points": outcome.total,
        "computed": outcome.computed,
        "done": outcome.done,
        "failed": failed_points(outcome.failed),
        "wall_time": outcome.wall_time,
        "warnings": (found := pipeline.warned(pipeline.open_sweep(out))).as_dict(),
        **selected(sweep),
    }
    text = [
        f"{out}: {outcome.done} of {outcome.total} points done, {outcome.computed} of them now, "
        f"in {outcome.wall_time:.1f} s",
        *(f"failed: {point}" for point in outcome.failed),
    ]
    if outcome.failed:
        text.append("try these again with: irg run --retry-failed")
    text += found.lines()
    show(options, document, text)
    return SOME_FAILED if outcome.failed else DONE


def check(options: argparse.Namespace) -> int:
    """Say what a scene means, at once, and then what its sweep would cost."""
    sweep = scene_of(options)
    require_bearable_loads(sweep)
    facts = facts_of(sweep)
    doubted, reasons = doubts(sweep, facts), tuple(left_out(sweep))
    memory = worker_bytes(sweep)
    nx, ny = sweep.grid.shape
    first = [
        f"{sweep.title}",
        *meaning(sweep, facts),
        *(f"  left out {reason}" for reason in reasons),
        *(f"  note     {note}" for note in sweep.notes),
        *(f"  warning  {doubt}" for doubt in doubted),
        f"  grid     {nx} × {ny} elements",
        f"  memory   about {memory / 1e6:.0f} MB a worker",
    ]
    if not options.json:
        print("\n".join(first), flush=True)
    document = {"title": sweep.title, "notes": sweep.notes, "meaning": facts.as_dict()}
    if memory > machine_bytes():
        doubt = (
            f"this machine has {machine_bytes() / 1e9:.0f} GB of memory, less than a worker needs: "
            "how long it would take is not tried; give fewer window.pixels, or a coarser fidelity"
        )
        known = {"left_out": reasons, "warnings": [*doubted, doubt], "worker_bytes": memory}
        show(options, document | known, [f"  warning  {doubt}"])
        return DONE
    found = pipeline.estimate(sweep, workers=options.workers)
    document |= found.as_dict() | {"warnings": [*doubted, *found.warnings]}
    surfaces = f", {len(sweep.realizations)} surfaces" if sweep.realizations else ""
    text = [
        f"  points   {found.points}: {len(sweep.loads)} loads, {len(sweep.velocities)} velocities"
        + surfaces,
        f"  steps    {found.steps} contacts and {found.temperatures} temperatures to solve",
        f"  time     about {duration(found.seconds)} on {found.workers} worker(s)",
        *(f"           {line}" for line in found.basis.split("; ")),
        f"  disk     about {found.disk_bytes / 1e6:.0f} MB",
        *(f"  warning  {what}" for what in found.warnings),
        *(f"  left out {reason}" for reason in found.left_out if reason not in reasons),
    ]
    show(options, document, text)
    return DONE
