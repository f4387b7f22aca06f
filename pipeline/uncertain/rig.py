"""Unknown inputs that tests add to those of a sweep: friction of the rig, and other oils.

The friction µ of a test is the rig's friction µ₀ with a scatter τ: ln µ = ln µ₀ ± τ. The measured
friction has an error s: ln µ ± s. So a measured friction informs on µ₀ with the variance τ² + s².
The friction that acted in a test is the mean of ln µ₀ and of the measured logarithm, weighted by
1/τ² and 1/s². The scatter τ is inferred, too.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import replace
from typing import Any

import numpy as np

from pipeline.sweep.measurement import oils_of
from pipeline.uncertain.ensemble import Ensemble
from pipeline.uncertain.inputs import CRITICAL, FRICTION, LEAST_FRICTION
from pipeline.uncertain.unknown import Unknown
from tribo import InputError
from tribo.types import Array

SCATTER = Unknown("friction.scatter", "log-normal", (0.02, 3.0))
"""Prior of the standard deviation of ln(friction) between tests: about 0 to over 10 %."""
OTHER = "friction.rig"
"""Path of the rig's friction as an input, if it differs from the scene's friction."""
_ROUNDED = 0.005  # least relative error of a measured friction: logs have two or three digits


def acting_friction(rig: Array, test: Mapping[str, Any], change: Array) -> tuple[Array, ...]:
    """ln(friction) that acted in a test, its variance, and ln(likelihood), for each draw.

    The likelihood is for the friction measured in the test; without one, ln(likelihood) is 0, of
    shape (1,). `rig` (n, 2) has draws of the rig's friction coefficient and of its scatter.
    `change` (n,) is what velocity and temperature of the test add to the logarithm of that
    coefficient.
    """
    of_rig = np.log(np.maximum(rig[:, 0], LEAST_FRICTION)) + change
    by_test = rig[:, 1] ** 2
    if test.get("friction") is None:
        return of_rig, by_test, np.zeros(1)
    measured = math.log(test["friction"])
    by_error = max(test.get("friction_scatter", 0.0) / test["friction"], _ROUNDED) ** 2
    variance = by_test + by_error
    acted = (measured * by_test + of_rig * by_error) / variance
    likelihood = -0.5 * ((measured - of_rig) ** 2 / variance + np.log(variance))
    return acted, by_test * by_error / variance, likelihood


def join_rig(
    ensemble: Ensemble, unknown: tuple[Unknown, ...]
) -> tuple[tuple[Unknown, ...], tuple[int, ...]]:
    """Add the rig's friction coefficient, and its scatter between tests, to the `unknown` inputs.

    Returns the inputs, and the indices of these two among them. If the rig is the scene's own, its
    coefficient is there already. If no test measured friction, or the scene's friction is known,
    nothing is added, and there are no indices.
    """
    paths = [one.path for one in ensemble.unknown]
    measured = any(test.get("friction") is not None for test in ensemble.tests)
    if FRICTION not in paths or not measured:
        return unknown, ()
    own, joint = paths.index(FRICTION), list(unknown)
    column = own
    if not ensemble.same_rig:
        column = len(joint)
        joint.append(replace(ensemble.unknown[own], path=OTHER, correlated=()))
    return (*joint, SCATTER), (column, len(joint))


def join_oils(ensemble: Ensemble) -> tuple[tuple[Unknown, ...], dict[str, int]]:
    """Add the critical temperatures of other oils in the tests to the unknown inputs.

    Returns all inputs, and for each other oil the index of its critical temperature among them.
    Raises an `InputError` if there are other oils, but the critical temperature is known.
    """
    unknown = ensemble.unknown
    others = oils_of(test.get("oil") for test in ensemble.tests)[1:]
    if not others:
        return unknown, {}
    critical = next((one for one in unknown if one.path == CRITICAL), None)
    if critical is None:
        raise InputError(
            f"the tests are of {len(others) + 1} oils, each with a critical temperature of its "
            'own; give "temperature.critical" a range under [unknown], or the tests of one oil'
        )
    own = tuple(replace(critical, path=f"{CRITICAL} of {oil}", correlated=()) for oil in others)
    return (*unknown, *own), {oil: len(unknown) + k for k, oil in enumerate(others)}
