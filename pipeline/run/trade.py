"""Processor time against the whole error of a scene's boundary, both measured.

Runs with ever smaller errors continue one store, and so share their points. They are compared with
the whole plane of the scene by each preset, at the cost of a point that is simulated here.
"""

from __future__ import annotations

import math
import time
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np
import pandas as pd

from pipeline.answers.error import curve_errors, exponents, preset_error_of, presets_for, total
from pipeline.answers.results import cases_of, open_sweep
from pipeline.answers.specimen import realizations_share
from pipeline.constants import RISE_EXPONENT
from pipeline.frames import frame_of, lines_of
from pipeline.progress import Progress, Report, silent
from pipeline.run.goal import goal_outcomes, reason_surface_is_fixed, require_boundary, search_of
from pipeline.run.run_sweep import run_sweep
from pipeline.scene.scene_file import SceneLike, sweep_of
from pipeline.store.location import PathLike
from pipeline.sweep.plan import choose_stored_steps, run_point
from pipeline.sweep.sweep import Point, Sweep
from tribo import InputError

ACCURACIES = 0.05, 0.03, 0.02
"""Errors that `irg trade` asks for, one after another."""


@dataclass(frozen=True, slots=True)
class MeasuredCost:
    """Cost and error of a boundary: of a run with a goal, or of a plane of one realization."""

    accuracy: float | None  #: Error that was asked for; None for a plane.
    preset: str | None
    points: int  #: In the store after the run, or of the plane.
    seconds: float  #: Processor time of all processes, earlier runs included [s].
    error: float  #: Relative error at the load where it is largest, a bound at 95 %.


@dataclass(frozen=True, slots=True)
class Trade:
    """Measured processor time and error of the boundary of a scene."""

    title: str  #: Title of the scene.
    runs: tuple[MeasuredCost, ...]  #: Runs with a goal, each on the points of those before.
    #: The whole plane by each preset; its time is that of one point.
    planes: tuple[MeasuredCost, ...]

    @property
    def table(self) -> pd.DataFrame:
        """Frame with a row for each run and plane."""
        rows = []
        for measured in (*self.runs, *self.planes):
            name = f"plane by {measured.preset}"
            if measured.accuracy is not None:
                name = f"accuracy {100 * measured.accuracy:g}%"
            numbers = float(f"{measured.seconds:.3g}"), float(f"{measured.error:.3g}")
            rows.append((name, measured.preset, measured.points, *numbers))
        heads = "run", "preset", "points", "CPU time [s]", "numerical error [%]"
        return frame_of(heads, rows)

    def __str__(self) -> str:
        head = f"{self.title}: processor time against the error of the boundary"
        note = "Errors are bounds at 95 %, at the load where they are largest."
        return "\n".join([head, "", *lines_of(self.table), "", note])


@np.errstate(under="ignore")
def trade(
    scene: SceneLike,
    out: PathLike,
    accuracies: Sequence[float] = ACCURACIES,
    workers: int | None = None,
    progress: Report | None = None,
) -> Trade:
    """Measure the computing time of accuracy goals and of whole planes.

    Parameters
    ----------
    scene : Sweep, str or path
        Scene, or its path or name. Of several cases, only the first is measured.
    out : str or path
        New store for the points of the runs.
    accuracies : sequence of float, optional
        Relative errors to ask for, the largest first. Runs end where one needs another preset.
    workers : int, optional
        Number of processes; one for each core if not given.
    progress : callable, optional
        Called with a `Progress` at each stage.

    Raises
    ------
    InputError
        If the sweep has no boundary, or the store exists.
    TriboError
        If a point has no solution.

    Examples
    --------
    >>> import pipeline  # doctest: +SKIP
    >>> pipeline.trade("first_try", "results/trade.zarr").table  # doctest: +SKIP
    """
    sweep, report = sweep_of(scene), progress or silent
    require_boundary(sweep)
    if Path(str(out)).exists():
        raise InputError(f"{out} exists, and its points would cost nothing; give a new store")
    runs, seconds = list[MeasuredCost](), 0.0
    for accuracy in accuracies:
        report(Progress(f"running to an error of {100 * accuracy:g} %"))
        try:
            outcome = run_sweep(sweep, out, workers, accuracy=accuracy, progress=progress)
        except InputError:  # another preset is needed
            if not runs:
                raise
            break
        seconds += outcome.cpu_time
        outcomes = goal_outcomes(open_sweep(out), accuracy, bool(reason_surface_is_fixed(sweep)))
        preset = outcomes[0].preset
        error = max(goal.total for goal in outcomes)
        runs.append(MeasuredCost(accuracy, preset, outcome.done, seconds, error))
    return Trade(sweep.title, tuple(runs), tuple(_planes(sweep, out, report)))


def _planes(sweep: Sweep, out: PathLike, report: Report) -> Iterator[MeasuredCost]:
    """The whole plane of one realization by each preset."""
    case = next(iter(cases_of(out)))
    search = search_of(case, 1.0, bool(reason_surface_is_fixed(sweep)))
    specimen, field = search.specimen, search.specimen.field
    crosses = np.isfinite(search.critical) & (specimen.realizations > 0)
    loads, critical = field.loads[crosses], search.critical[crosses]
    x, log_critical = np.log(field.velocities), np.log(critical)
    exponent = exponents(field, loads, critical)
    interpolation = [
        curve_errors(x, row, point[None])[0]
        for row, point in zip(field.rows(field.velocities)[crosses], log_critical, strict=True)
    ] / exponent
    realizations = len(sweep.case_table.axes.get("realization", (0,)))
    # With more realizations than a plane has, their deviation is known better.
    realization_counts = specimen.realizations[crosses]
    bound = realizations_share(realization_counts, specimen.is_highest, specimen.freedom[crosses])
    bound = bound if specimen.is_highest else bound * np.sqrt(realization_counts / realizations)
    deviation = field.at(loads, critical).bilinear(specimen.mean.deviation)
    surface = bound * deviation / exponent
    points = len(sweep.cases) * len(sweep.loads) * len(sweep.velocities)
    for name, fidelity in presets_for(sweep.scene, ["standard", "fine", "reference"]).items():
        report(Progress(f"timing a point of preset {name}"))
        preset_sweep = sweep.with_fidelity(fidelity, name)
        preset_error = preset_error_of(preset_sweep) or math.nan
        preset_errors = preset_error * RISE_EXPONENT / np.minimum(exponent, RISE_EXPONENT)
        errors = total(np.stack([interpolation, surface, preset_errors]))
        seconds = points * _seconds_of_point(preset_sweep, float(np.median(critical)))
        yield MeasuredCost(None, name, points, seconds, float(errors.max(initial=0.0)))


def _seconds_of_point(sweep: Sweep, target: float) -> float:
    """Processor time [s] of a point's end at the middle load, and nearest to `target` [m/s].

    Points of a plane share their ramps, and so may take less.
    """
    case, load = sweep.on_first_surface[0], sweep.loads[len(sweep.loads) // 2]
    velocity = min((v for v in sweep.velocities if v > 0), key=lambda v: abs(v - target))
    stored_steps = choose_stored_steps(replace(sweep, steps="end", loads=(load,)))
    began = time.process_time()
    run_point(case.scene, stored_steps, Point(load, velocity, case.name))
    return time.process_time() - began
