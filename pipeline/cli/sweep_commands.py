"""The commands ``irg run``, ``irg sensitivity`` and ``irg trade``."""

from __future__ import annotations

import argparse
import shlex
from contextlib import AbstractContextManager, nullcontext, suppress
from dataclasses import fields
from functools import partial
from pathlib import Path
from typing import Any

import xarray as xr

import pipeline
from pipeline.answers.error import has_unknown_preset_error, preset_error_text
from pipeline.answers.facts import fact_lines
from pipeline.answers.results import case_dims, sweep_of
from pipeline.answers.scene_wording import test_group_words, warning_lines
from pipeline.answers.sensitivity_answer import sensitivity_frame, sensitivity_lines
from pipeline.cli import output
from pipeline.cli.check import check
from pipeline.cli.inputs import one_scene_in, scene_in, values_in
from pipeline.cli.output import Result, print_note, wrapped
from pipeline.cli.store_commands import boundary_text
from pipeline.scene.contact_estimate import require_admissible_load
from pipeline.store.schema import PLANE
from tribo import Fidelity, InputError


def _require_possible_run(options: argparse.Namespace) -> None:
    """Refuse a goal out of reach, and a store to copy from that is not there, before a run."""
    from pipeline.progress import silent
    from pipeline.run.goal import GoalPlan
    from pipeline.store.create import find_sweep
    from pipeline.store.store import opened

    if options.source is not None:
        opened(options.source)
    if options.accuracy is not None:
        out = options.output or Path("results") / f"{options.scene.stem}.zarr"
        GoalPlan(scene_in(options), find_sweep(out), options.accuracy, silent)


def run(options: argparse.Namespace) -> Result:
    """Answer ``irg run``: run or resume a sweep, or only the points that the boundary needs."""
    if options.accuracy is not None:
        _refuse_numerical_settings(options)
    if options.dry_run:
        _require_possible_run(options)
        # The path of the store; irg check would write its table to it.
        options.store_path, options.output = options.output, None
        return check(options)
    out = options.output or Path("results") / f"{options.scene.stem}.zarr"
    sweep = scene_in(options)
    print_note(*(f"note: {note.text}" for note in sweep.notes))
    for line in warning_lines(sweep):
        output.print_error(line)  # with --quiet, too
    require_admissible_load(sweep, min(sweep.loads), "sweep.loads")
    choices = values_in(options, "workers", "dashboard", "retry_failed", "accuracy", "source")
    with _remote_client(options) as client, output.run_line() as progress:
        outcome = pipeline.run_sweep(sweep, out, client=client, progress=progress, **choices)
    ds, tests = pipeline.open_sweep(out), outcome.tests
    failed = *outcome.failed, *(tests.failed if tests else ())
    document: dict[str, Any] = {
        "store": str(out), "points": outcome.total, "done": outcome.done,
        "computed": outcome.computed, "failed": len(outcome.failed),
        "wall time [s]": outcome.wall_time,
    }  # fmt: skip
    text: list[Any] = [
        f"{out}: {outcome.done} of {outcome.total} points done, {outcome.computed} of them in "
        f"this run, in {outcome.wall_time:.1f} s"
    ]
    if tests:
        counts = {"points": tests.total, "done": tests.done, "failed": len(tests.failed)}
        document["tests"] = counts
        text.append(f"{test_group_words(sweep_of(ds))}: {tests.done} of {tests.total} points done")
    text += [f"failed: {point}" for point in failed]
    is_reached = True
    if options.accuracy is not None:
        from pipeline.run.goal import goal_outcomes, reason_surface_is_fixed

        reason = reason_surface_is_fixed(sweep)
        goals = goal_outcomes(ds, options.accuracy, bool(reason))
        text += [line for goal in goals for line in goal.lines(options.accuracy, reason)]
        is_reached = all(goal.is_below(options.accuracy) for goal in goals)
        document["accuracy"] = {
            "goal": options.accuracy,
            "scenes": [goal._asdict() for goal in goals],
        }
    elif has_unknown_preset_error(sweep_of(ds)):
        text.append(preset_error_text(sweep_of(ds)))
    if failed:
        text.append("to simulate failed points again, add --retry-failed to the command")
    elif outcome.done:
        text += _next_steps(ds, shlex.quote(str(out)))
    text += wrapped(pipeline.points_with_warnings(ds).lines())
    code = output.SOME_FAILED if failed or not is_reached else output.DONE
    return Result(document, text, code=code)


def _remote_client(options: argparse.Namespace) -> AbstractContextManager[Any]:
    """Client of the Dask scheduler that the user names; a context with None if there is none."""
    if not (options.scheduler or options.scheduler_file):
        return nullcontext()
    from pipeline.run.cluster import PATIENCE, client_of  # Dask, which irg check does without

    address = options.scheduler or options.scheduler_file
    print_note(f"connecting to the Dask scheduler at {address}, for at most {PATIENCE:g} s")
    client: AbstractContextManager[Any] = client_of(options.scheduler, options.scheduler_file)
    return client


def _refuse_numerical_settings(options: argparse.Namespace) -> None:
    """Raise an `InputError` for numerical settings, which an accuracy goal would replace."""
    names = {"preset", *(field.name for field in fields(Fidelity))}
    keys = (key for key in options.set if key.removeprefix("fidelity.") in names)
    settings = [f"--set {key}" for key in keys]
    if options.preset is not None:
        settings.insert(0, "--preset")
    if settings:
        raise InputError(
            f"--accuracy chooses the numerical settings; leave out {', '.join(settings)}"
        )


def _next_steps(ds: xr.Dataset, store: str) -> list[Any]:
    """The boundary of a finished sweep, and commands to continue with its `store`."""
    if not sweep_of(ds).base.is_judged:
        return [f"temperatures are in {store}; there is no verdict without temperature.critical"]
    if not {*PLANE} <= {*ds["status"].dims}:
        lines = wrapped(fact_lines(pipeline.margin(ds), "mild load factor"))
        return [*lines, f"next: irg margin {store}, irg plot {store}"]
    if max(ds.sizes[axis] for axis in PLANE) == 1:
        return [f"one point has no boundary; next: irg margin {store}"]
    text = list[Any]()
    if not case_dims(ds):  # irg boundary has a table of several cases
        # Without a boundary, for example if too few points are done, irg boundary prints why.
        with suppress(InputError):
            # Notes are printed already.
            text = wrapped(boundary_text(pipeline.boundary(ds), omitted=["note"]))
    return [*text, f"next: irg boundary {store}, irg plot {store}"]


def sensitivity(options: argparse.Namespace) -> Result:
    """Answer ``irg sensitivity``: what each input of a scene does to rise and critical velocity."""
    out = options.store_path or Path("results") / f"{options.scene.stem}-sensitivity.zarr"
    scene = one_scene_in(options, finds_row=True)
    point = values_in(options, "load", "velocity", "workers")
    with output.run_line() as progress:
        ds = pipeline.sensitivity(scene, out=out, progress=progress, **point)
    text = wrapped([*sensitivity_lines(ds), f"points: {out}"])
    return Result(text=text, frames=[sensitivity_frame(ds)], draw=partial(pipeline.plot, ds))


def trade(options: argparse.Namespace) -> Result:
    """Answer ``irg trade``: what each accuracy of a scene's boundary costs, measured."""
    out = options.store_path or Path("results") / f"{options.scene.stem}-trade.zarr"
    scene = scene_in(options)
    with output.run_line() as progress:
        study = pipeline.trade(scene, out, workers=options.workers, progress=progress)
    text = [str(study), f"points: {out}"]
    return Result(text=text, frames=[study.table], draw=partial(pipeline.plot, study))
