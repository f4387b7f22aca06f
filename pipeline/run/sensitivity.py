"""Sensitivities of a scene's rise and critical velocity to its inputs, at one point."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import xarray as xr

from pipeline.answers.results import cases_of
from pipeline.answers.sensitivity_answer import sensitivity_answer
from pipeline.kinds import LOAD, VELOCITY, WORKERS
from pipeline.progress import Progress, Report, silent
from pipeline.run.boundary_variants import governing_row
from pipeline.run.goal import reason_surface_is_fixed, require_boundary, search_of
from pipeline.run.run_sweep import PointsBeside, run_planned, run_sweep
from pipeline.scene.scene_file import SceneLike, sweep_of
from pipeline.scene.variants import variants_of
from pipeline.store.location import PathLike
from pipeline.sweep.case import Case
from pipeline.sweep.sweep import Point, Sweep
from tribo import InputError

_SEARCH_ERROR = 0.05  # of the critical velocity at which sensitivities are computed
_SAME_WITHIN = 0.005  # relative, for the load and velocity of a row


@np.errstate(under="ignore")
def sensitivity(
    scene: SceneLike,
    load: float | str | None = None,
    velocity: float | str | None = None,
    out: PathLike | None = None,
    workers: int | None = None,
    progress: Report | None = None,
) -> xr.Dataset:
    """Compute by how much each input of a scene changes the temperature rise and the limit.

    Each input is changed by ± 10 %, on the first surface of the scene. Friction and temperatures
    act in closed form.

    Parameters
    ----------
    scene : Sweep, str or path
        Scene, or its path or name. With several values of an entry, the scene's own or the first.
    load, velocity : float or str, optional
        Operating point, in SI or text with a unit. By default the critical velocity of the load, or
        of the middle load of the sweep, which is searched for. In a sweep of rows the point of a
        row; by default the row that governs.
    out : str or path, optional
        Store for the points, which is created or resumed; by default
        ``results/NAME-sensitivity.zarr``.
    workers : int, optional
        Number of processes; one for each core if not given.
    progress : callable, optional
        Called with a `Progress` at each stage.

    Returns
    -------
    Dataset
        Along ``input``, the strongest first: ``sensitivity``, d ln(rise/allowable rise)/d ln(input)
        or the change per K of a temperature; ``log_rise_change`` and ``velocity_change``
        (relative), for +10 % of the input or +10 K; ``curvature``, the sum of the changes of
        ln(rise) on both sides; ``uncertainty``, the declared standard deviation, relative or in K,
        and ``log_rise_deviation``, that of ln(rise) by it; ``value`` in SI; ``sides``, the sides on
        which the scene allows the change; ``choice``, what a designer chooses by it. Inputs with a
        declared deviation are sorted by its effect. ``velocity_exponent`` is that of the rise.

    Raises
    ------
    InputError
        If there is no critical velocity at the load, and no velocity is given; or if no row has
        this load and velocity.

    Examples
    --------
    >>> import pipeline  # doctest: +SKIP
    >>> ds = pipeline.sensitivity("first_try", "400 N", "2 m/s")  # doctest: +SKIP
    >>> ds["velocity_change"].sel(input="pin.radius").round(2).item()  # doctest: +SKIP
    0.02
    """
    if workers is not None:
        workers = WORKERS.argument("workers", workers)
    sweep, report = sweep_of(scene), progress or silent
    store = Path("results") / f"{sweep.name}-sensitivity.zarr" if out is None else out
    if velocity is not None and load is None:
        raise InputError("a velocity needs a load; give both")
    load_in_si = None if load is None else LOAD.argument("load", load)
    velocity_in_si = None if velocity is None else VELOCITY.argument("velocity", velocity)
    study = _study_of(sweep)
    if sweep.case_table.column("load") is not None:
        point = _row_at(study, load_in_si, velocity_in_si)
        if point is None:
            report(Progress("simulating the rows, to find the one that governs"))
            run_sweep(study, store, workers, progress=progress)
            point = governing_row(cases_of(store))
    else:
        middle = sweep.loads[len(sweep.loads) // 2] if load_in_si is None else load_in_si
        study = replace(study, loads=(middle,))
        if velocity_in_si is None:
            report(Progress(f"searching for the critical velocity at {middle:g} N"))
            velocity_in_si = _critical_velocity(study, store, workers, report)
        point = Point(middle, velocity_in_si)
    study = replace(study, variants=variants_of(study, [point]))
    run_planned(study, store, PointsBeside(study), workers, progress)
    (case,) = (case for case in cases_of(store) if case.name == point.case)
    uncertainties = sweep.base.uncertainty
    answer = sensitivity_answer(case, point.load, point.velocity, uncertainties)
    return answer.assign_attrs(title=sweep.title)


def _study_of(sweep: Sweep) -> Sweep:
    """The sweep whose points a study simulates: one case on one surface, or all rows themselves."""
    tests = sweep.tests if sweep.base.critical_from_tests else ()
    if sweep.case_table.column("load") is None:
        sweep = sweep.single_case()
        if not reason_surface_is_fixed(sweep):
            sweep = sweep.with_realizations(1)  # a search may add further ones

    def certain(case: Case) -> Case:
        return replace(case, uncertainty=())  # whose points only a run adds

    sweep = replace(sweep, case_table=replace(sweep.case_table, load_factors=()))
    return replace(sweep, tests=tests, steps="end", fields=False).map_cases(certain)


def _row_at(sweep: Sweep, load: float | None, velocity: float | None) -> Point | None:
    """The point of the row with this load and velocity; None without both."""
    if load is None:
        return None
    for name, row in sweep.case_table.by_name.items():
        point = Point(float(row["load"]), float(row["velocity"]), name)
        pairs = (point.load, load), (point.velocity, velocity or point.velocity)
        if all(abs(a - b) <= _SAME_WITHIN * b for a, b in pairs):
            surfaces = {column.name for column in sweep.case_table.columns if column.is_seed}
            case_name = tuple(pair for pair in name if pair[0] not in surfaces)
            return point._replace(case=case_name)
    rows = (f"{row['load']:g} N, {row['velocity']:g} m/s" for row in sweep.case_table.rows)
    raise InputError(
        f"no row of the sweep has {load:g} N and {velocity or 0:g} m/s; give one of "
        f"{'; '.join(dict.fromkeys(rows))}"
    )


def _critical_velocity(sweep: Sweep, out: PathLike, workers: int | None, report: Report) -> float:
    """Critical velocity at the single load of a sweep, by the search of an accuracy goal."""
    require_boundary(sweep)
    (load,) = sweep.loads
    run_sweep(sweep, out, workers, accuracy=_SEARCH_ERROR, progress=report)
    (case,) = cases_of(out)
    search = search_of(case, _SEARCH_ERROR, is_fixed=True)
    velocity = float(search.critical[search.loads == load][0])
    if not np.isfinite(velocity):
        raise InputError(
            f"there is no critical velocity at {load:g} N in the sweep; give --velocity"
        )
    return velocity
