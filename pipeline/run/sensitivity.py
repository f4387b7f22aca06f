"""Sensitivities of a scene's rise and critical velocity to its inputs, at one point."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import ClassVar

import numpy as np
import pandas as pd
import xarray as xr

from pipeline.answers.input_errors import change_of_step, input_name, sensitivity_dataset
from pipeline.answers.results import cases_of
from pipeline.answers.verdict_model import conditions_of
from pipeline.arguments import in_load_or_velocity, typed_arguments
from pipeline.frames import frame_of, lines_of
from pipeline.progress import Progress, Report, silent
from pipeline.quantities import in_unit
from pipeline.run.goal import reason_surface_is_fixed, require_boundary, searches
from pipeline.run.run_sweep import run_sweep
from pipeline.scene.scene_file import SceneLike, sweep_of
from pipeline.scene.variants import variants_of
from pipeline.store.location import PathLike
from pipeline.sweep.case import TEMPERATURES, VELOCITY_INPUT
from pipeline.sweep.sweep import Sweep
from pipeline.units import typeset
from tribo import InputError

_SEARCH_ERROR = 0.05  # of the critical velocity at which sensitivities are computed


@dataclass(frozen=True, slots=True, eq=False)
class Sensitivity:
    """Sensitivities of a scene at one point; the dataset has the dimension ``input``."""

    drawn_by: ClassVar = "pipeline.figures.study_figures:draw_sensitivity"
    title: str  #: Title of the scene.
    #: ``sensitivity``: d ln(rise ratio)/d ln(input), or per K; ``log_rise_change`` and
    #: ``velocity_change`` (relative): for +10 % of the input, or +10 K.
    dataset: xr.Dataset

    @property
    def table(self) -> pd.DataFrame:
        """Frame with a row for each input, the strongest first."""
        ds, rows = self.dataset, []
        for k, path in enumerate(ds["input"].values.tolist()):
            unit, value = str(ds["unit"].values[k]), float(ds["value"].values[k])
            text = f"{in_unit(value, typeset(unit)):.4g} {typeset(unit)}".strip()
            step = "+10 K" if path in TEMPERATURES else "+10 %"
            change, velocity = (
                float(f"{ds[name].values[k]:.3g}")
                for name in ("log_rise_change", "velocity_change")
            )
            rows.append((input_name(path), text, step, change, 100 * velocity, path))
        heads = "input", "value", "change", "ln(rise ratio)", "critical velocity (%)", "entry"
        return frame_of(heads, rows)

    def __str__(self) -> str:
        ds = self.dataset
        point = f"{ds['load'].item():.4g} N and {ds['velocity'].item():.3g} m/s"
        exponent = ds["velocity_exponent"].item()
        head = f"{self.title}: inputs at {point}, where the rise grows as velocity^{exponent:.2f}"
        note = (
            "Differences of ± 10 % of each input on one surface. A higher ln(rise ratio) is a "
            "hotter contact, and a lower critical velocity."
        )
        return "\n".join([head, "", *lines_of(self.table), "", note])


@typed_arguments
@np.errstate(under="ignore")
def sensitivity(
    scene: SceneLike,
    out: PathLike,
    load: float | str | None = None,
    velocity: float | str | None = None,
    workers: int | None = None,
    progress: Report | None = None,
) -> Sensitivity:
    """Compute by how much each input of a scene changes the temperature rise and the limit.

    Parameters
    ----------
    scene : Sweep, str or path
        Scene, or its path or name. With several cases, inputs are those of the first.
    out : str or path
        Store for the points, which is created or resumed.
    load, velocity : float or str, optional
        Operating point, in SI or text with a unit. By default the middle load of the sweep, at its
        critical velocity, which is searched for.
    workers : int, optional
        Number of processes; one for each core if not given.
    progress : callable, optional
        Called with a `Progress` at each stage.

    Raises
    ------
    InputError
        If there is no critical velocity at the load, and no velocity is given.

    Examples
    --------
    >>> import pipeline  # doctest: +SKIP
    >>> pipeline.sensitivity("first_try", "results/inputs.zarr", "400 N", "2 m/s")  # doctest: +SKIP
    """
    sweep, report = sweep_of(scene), progress or silent
    middle = sweep.loads[len(sweep.loads) // 2]
    load_in_si = middle if load is None else in_load_or_velocity("load", load)
    tests = sweep.tests if sweep.base.critical_from_tests else ()
    single = replace(
        sweep._single_case(), tests=tests, steps="end", fields=False, loads=(load_in_si,)
    )
    if not reason_surface_is_fixed(single):
        single = single._with_realizations(1)  # the search may add further ones
    if velocity is None:
        report(Progress(f"searching for the critical velocity at {load_in_si:g} N"))
        velocity_in_si = _critical_velocity(single, out, workers, report)
    else:
        velocity_in_si = in_load_or_velocity("velocity", velocity)
    with_variants = replace(
        single,
        velocities=(velocity_in_si,),
        variants=variants_of(sweep, [(load_in_si, velocity_in_si)]),
    )
    run_sweep(with_variants, out, workers, progress=progress)
    (case,) = cases_of(out)
    point = {"load": load_in_si}
    ds = sensitivity_dataset(case, conditions_of(case, {})).sel(point)
    changes = change_of_step(ds)
    ds["log_rise_change"] = changes
    ds["velocity_change"] = np.expm1(-changes / ds["velocity_exponent"])
    ds = ds.sel(input=ds["input"] != VELOCITY_INPUT)
    return Sensitivity(sweep.title, ds.sortby(-abs(ds["log_rise_change"])))


def _critical_velocity(sweep: Sweep, out: PathLike, workers: int | None, report: Report) -> float:
    """Critical velocity at the single load of a sweep, by the search of an accuracy goal."""
    require_boundary(sweep)
    run_sweep(sweep, out, workers, accuracy=_SEARCH_ERROR, progress=report)
    _, search = next(searches(cases_of(out), _SEARCH_ERROR, True))
    velocity = float(search.critical[0])
    if not np.isfinite(velocity):
        raise InputError(
            f"there is no critical velocity at {sweep.loads[0]:g} N in the sweep; give --velocity"
        )
    return velocity
