"""Variants that a run simulates for the uncertainties of a scene, once its plane is done."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from pipeline.answers.results import ascending, cases_of
from pipeline.answers.verdict_model import verdict_model
from pipeline.scene.variants import variants_of
from pipeline.store.dataset import store_dataset
from pipeline.store.store import Store
from pipeline.sweep.case import CLOSED_FORM, OperatingPoint
from pipeline.sweep.sweep import Sweep


def with_variants(store: Store) -> Sweep | None:
    """The sweep of a store with the variants that its uncertainties need; None if it has them."""
    sweep = store.sweep
    entries = {path for each in sweep.base.uncertainty for path in each.entries} - {*CLOSED_FORM}
    if not entries <= {variant.entry for variant in sweep.variants}:
        points = [*dict.fromkeys((v.load, v.velocity) for v in sweep.variants)]
        simulated = {variant.entry for variant in sweep.variants}
        points = points or _boundary_points(store)
        return replace(sweep, variants=variants_of(sweep, points, entries | simulated))
    return None


def _boundary_points(store: Store) -> list[OperatingPoint]:
    """Lowest, middle and highest load of a computed sweep, each at its critical velocity.

    Without one, the velocity is the end of the sweep that is nearest to it.
    """
    case = cases_of(ascending(store_dataset(store)))[0]
    model = verdict_model(case, case.conditions)
    loads = model.field.loads
    loads = loads[[0, len(loads) // 2, -1]]
    lines = model.field.along_velocity(loads, np.full(loads.shape, model.limit))
    ends = np.where(lines.is_severe, case.velocities[0], case.velocities[-1])
    velocities = np.where(np.isfinite(lines.critical), lines.critical, ends)
    return [*dict.fromkeys(zip(loads.tolist(), velocities.tolist(), strict=True))]
