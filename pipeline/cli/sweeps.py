"""The commands that say what a sweep takes, and compute it."""

from __future__ import annotations

import argparse
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pipeline
from pipeline.cli.clusters import batch_of, show_script
from pipeline.cli.exit_codes import DONE, SOME_FAILED
from pipeline.cli.meaning import library_lines, meaning
from pipeline.cli.next_steps import after_run
from pipeline.cli.output import counted, failed_points, show, show_text, tell
from pipeline.cli.picture import require_screen, watched
from pipeline.cli.progress import ProgressLine
from pipeline.cli.scenes import given, scene_of, selected
from pipeline.sweep.doubts import doubts
from pipeline.sweep.facts import facts_of, require_bearable_load
from pipeline.sweep.model import Sweep
from pipeline.sweep.savings import savings
from pipeline.sweep.stages import duration
from pipeline.sweep.warned import NO_WARNING
from pipeline.tradeoff.forecast import Estimate, machine_bytes, worker_bytes


def computed(options: argparse.Namespace) -> int:
    """Run or resume a sweep, or the part of it that the boundary needs."""
    out = options.output or Path("results") / f"{options.scene.stem}.zarr"
    batch = batch_of(options)
    require_screen(options.watch)
    sweep = scene_of(options, store=out)
    if batch and options.dry_run:
        show_script(options, batch, out)
        return DONE
    for note in sweep.notes:
        tell(f"note: {note}")
    with ProgressLine() as line, watched(options.watch, out, line) as progress:
        settings = {
            "workers": options.workers,
            "scheduler": options.scheduler,
            "cluster": batch,
            "progress": progress,
            "retry_failed": options.retry_failed,
            "tell": tell,
        }
        if options.boundary_only is None:
            outcome = pipeline.run_sweep(sweep, out, **settings)
        else:
            asked = given(options, "boundary_only")
            outcome = pipeline.follow_boundary(sweep, out, *asked.values(), **settings)
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
        text.append(after_run(sweep, out))
    warned = pipeline.warned(out) if pipeline.summary(out).warned else NO_WARNING
    show(options, document, text, warned=warned)
    return SOME_FAILED if outcome.failed else DONE


def check(options: argparse.Namespace) -> int:
    """Say what a scene means, at once, and then what its sweep would cost."""
    sweep = scene_of(options)
    require_bearable_load(sweep, max(sweep.loads), "sweep.loads")
    facts, memory, saved = facts_of(sweep), worker_bytes(sweep), tuple(savings(sweep))
    doubted = list(doubts(sweep, facts))
    small = memory > machine_bytes()
    if small:
        doubted.append(
            f"this machine has {machine_bytes() / 1e9:.0f} GB of memory, less than a worker needs: "
            "the time is not tried out; give fewer window.pixels, or a coarser fidelity"
        )
    nx, ny = sweep.grid.shape
    document: dict[str, Any] = {
        "title": sweep.title,
        "notes": sweep.notes,
        "meaning": facts.as_dict(),
        "library": [entry._asdict() for entry in sweep.library],
        "saved": saved,
        "worker_bytes": memory,
        **_unknown(sweep),
        "warnings": doubted,
    }
    text = [
        f"{sweep.title}",
        *meaning(sweep, facts),
        *library_lines(sweep),
        *(f"  saved    {work}" for work in saved),
        *_on_unknown(sweep),
        *(f"  note     {note}" for note in sweep.notes),
        *(f"  warning  {doubt}" for doubt in doubted),
        f"  grid     {nx} × {ny} elements",
        f"  memory   about {memory / 1e6:.0f} MB a worker",
    ]
    if small:
        show(options, document, text)
        return DONE
    if not options.json:
        show_text(text)
    searched = options.boundary_only is not None
    found = pipeline.estimate(sweep, workers=options.workers, boundary_only=searched)
    document |= found.as_dict() | {"warnings": [*doubted, *found.warnings]} | selected(sweep)
    show(options, document, _cost(sweep, found, searched))
    return DONE


def _unknown(sweep: Sweep) -> dict[str, Any]:
    """Inputs that are not known exactly, as plain data; nothing where all are."""
    if sweep.samples is None:
        return {}
    simulated = {each.path for each in sweep.samples.design.inputs}
    return {
        "unknown": [
            each.as_dict() | {"simulated": each.path in simulated} for each in sweep.samples.unknown
        ],
        "samples": len(sweep.samples),
        "samples_per_contact": sweep.samples.design.per_contact,
        "sample_seed": sweep.samples.design.seed,
    }


def _on_unknown(sweep: Sweep) -> Iterator[str]:
    """Say what is not known exactly, and how samples are drawn of it."""
    if sweep.samples is None:
        return
    design = sweep.samples.design
    simulated = {each.path for each in design.inputs}
    for each in sweep.samples.unknown:
        free = "" if each.path in simulated else "; applied afterwards, at no cost"
        yield f"  unknown  {each}{free}"
    low, high = design.velocities
    yield (
        f"  samples  {len(sweep.samples)} of a scrambled Sobol' sequence, seed {design.seed}, from "
        f"{low:g} to {high:g} m/s; more of them go on from these"
    )
    if design.per_contact > 1:
        yield f"           {design.per_contact} share each contact, and have heat of their own"


def _cost(sweep: Sweep, found: Estimate, searched: bool) -> Iterator[str]:
    """Say what a sweep would cost."""
    loads = counted(len(sweep.loads), "load", "loads")
    velocities = counted(len(sweep.velocities), "velocity", "velocities")
    if sweep.samples:
        yield f"  points   {found.points}: {loads}, {len(sweep.samples)} samples"
    elif searched:
        sought = f"the boundary is sought between {sweep.velocities[0]:g} and "
        sought += f"{sweep.velocities[-1]:g} m/s, {loads}"
        variants = f", {len(sweep.axis[1])} {sweep.axis[0]}s" if sweep.axis else ""
        yield f"  points   about {found.points}: {sought}{variants}"
    else:
        surfaces = f", {len(sweep.realizations)} surfaces" if sweep.realizations else ""
        yield f"  points   {found.points}: {loads}, {velocities}{surfaces}"
    yield f"  steps    {found.steps} contacts and {found.temperatures} temperatures to solve"
    if not (sweep.samples or searched):
        yield f"  chains   {found.chains}, each computed by one worker: more would be idle"
    workers = counted(found.workers, "worker", "workers")
    yield f"  time     about {duration(found.seconds)} on {workers}"
    yield from (f"           {line}" for line in found.basis.split("; "))
    size = found.disk_bytes / 1e6
    yield "  disk     " + (f"about {size:.0f} MB" if size >= 1 else "less than 1 MB")
    yield from (f"  warning  {what}" for what in found.warnings)
