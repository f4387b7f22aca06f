"""The command ``irg run``."""

from __future__ import annotations

import argparse
import shlex
from contextlib import nullcontext, suppress
from pathlib import Path

import xarray as xr

import pipeline
from pipeline.analysis.caveats import doubt_lines
from pipeline.analysis.dataset import Layout, entry_dims, scene_sweep, sweep_kind
from pipeline.analysis.preset_error import error_in_words, has_unknown_error, velocity_error
from pipeline.analysis.reached import Reached, percent, reached
from pipeline.analysis.words import next_run_line
from pipeline.cli import output
from pipeline.cli.given import scene_in, typed_scene, values_in
from pipeline.cli.output import Result, tell
from pipeline.scene.doubts import notes_on_scene
from pipeline.scene.facts import require_bearable_load
from tribo import InputError


def run(options: argparse.Namespace) -> Result:
    """Answer ``irg run``: run or resume a sweep, or only the points that the boundary needs."""
    out = options.output or Path("results") / f"{options.scene.stem}.zarr"
    sweep = scene_in(options)
    tell(*(str(one) for one in notes_on_scene(sweep)))
    for line in doubt_lines(sweep):
        output.complain(line)  # with --quiet, too
    require_bearable_load(sweep, min(sweep.loads), "sweep.loads")
    choices = values_in(options, "workers", "dashboard", "retry_failed", "accuracy", "source")
    is_elsewhere = options.scheduler or options.scheduler_file
    elsewhere = None
    if is_elsewhere:
        from pipeline.run.cluster import client_of  # Dask, which irg check does without

        elsewhere = client_of(options.scheduler, options.scheduler_file)
    with elsewhere or nullcontext() as client, output.run_line() as progress:
        outcome = pipeline.run_sweep(sweep, out, client=client, progress=progress, **choices)
    judged = pipeline.at(out)
    stored, tests = scene_sweep(judged), outcome.tests
    failed = *outcome.failed, *(tests.failed if tests else ())
    text = [
        f"{out}: {outcome.done} of {outcome.total} points done, {outcome.computed} of them now, "
        f"in {outcome.wall_time:.1f} s",
        *output.counted_tests(outcome.tests),
        *(f"failed: {point}" for point in failed),
    ]
    told = list[Reached]()
    if options.accuracy is not None:
        from pipeline.run.goal import why_fixed

        told = reached(judged, counts_surface=not (fixed := why_fixed(sweep)))
        text += [line for one in told for line in one.lines(options.accuracy, fixed)]
    elif has_unknown_error(stored):
        text.append(error_in_words(stored))
    if failed:
        text.append("to compute them again: the same command and --retry-failed")
    elif outcome.done:
        text += _ending(judged, shlex.quote(str(out)))
        half, least = (options.accuracy or 0.0) / 2, velocity_error(stored) or 0.0
        if least < half < max((one.total for one in told), default=0.0):
            text.append(f"to go on: {_going_on(options, out, half)}")
    document = {
        "store": str(out), "points": outcome.total, "done": outcome.done,
        "computed": outcome.computed, "failed": len(outcome.failed),
        "wall time [s]": outcome.wall_time,
    }  # fmt: skip
    if tests:
        document["tests"] = {
            "points": tests.total, "done": tests.done, "failed": len(tests.failed),
        }  # fmt: skip
    if options.accuracy is not None:
        document["accuracy"] = {"goal": options.accuracy, "scenes": [x._asdict() for x in told]}
    code = output.SOME_FAILED if failed else output.DONE
    return Result(document, text, pipeline.warned(judged), code=code)


def _going_on(options: argparse.Namespace, out: Path | str, goal: float) -> str:
    """The command that goes on with the store of a goal, to a smaller error."""
    accuracy = percent(goal).replace(" ", "")
    where = "" if options.output is None else f"-o {shlex.quote(str(out))} "
    return f"irg run {typed_scene(options)} {where}--accuracy {accuracy}"


def _ending(judged: xr.Dataset, store: str) -> list[str]:
    """The boundary of a sweep that was run, and the commands that go on from its `store`."""
    if scene_sweep(judged).conditions.critical_temperature is None:
        return [f"next: irg plot {store} --kind temperature"]
    if sweep_kind(judged) is Layout.PLACES:
        return [f"next: irg margin {store}"]
    found = list[str]()
    if not entry_dims(judged):  # one scene; irg boundary has a table of several
        with suppress(InputError):  # as where too few points are done; irg boundary says why
            found = [next_run_line(pipeline.boundary(judged))]
    return [*found, f"next: irg boundary {store}, irg plot {store}"]
