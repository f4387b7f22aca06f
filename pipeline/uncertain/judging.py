"""Samples as a user has them judged: weighed by tests, or under other conditions."""

from __future__ import annotations

from typing import Any

import xarray as xr

from pipeline.analysis.conditions import conditions_of
from pipeline.uncertain.ensemble import CONDITIONS, Ensemble
from pipeline.uncertain.weigh import SCATTER, Posterior, posterior
from tribo import InputError


def ensemble_under(ds: xr.Dataset, **changed: Any) -> tuple[Ensemble, dict[str, float]]:
    """Samples under the share and criterion that are given, and other given conditions [SI]."""
    if isinstance(changed.get("friction"), tuple):
        raise InputError("samples are judged at one --friction at a time; give one")
    judged = conditions_of(ds, **changed)
    share = None if changed.get("share") is None else judged.failing_share
    ensemble = Ensemble.of(ds, share, changed.get("criterion"))
    names = (name for name in CONDITIONS if changed.get(name) is not None)
    return ensemble, {name: getattr(judged, name) for name in names}


def posterior_if_given(
    ensemble: Ensemble, given_measured: bool, scatter: float | None = None
) -> Posterior | None:
    """Inputs weighed by the tests, if they are to count, of which there has to be one then."""
    if not given_measured:
        if scatter is not None:
            raise InputError(
                f"scatter is {scatter:g}, of measured velocities that do not count here; add "
                "--given-measured (in Python given_measured=True), or leave it out"
            )
        return None
    if not ensemble.tests:
        raise InputError(
            "the scene has no measured transition and no test; give it a [[measured]] with load "
            "and velocity, or a [[tested]] with an outcome besides"
        )
    return posterior(ensemble, SCATTER if scatter is None else scatter)
