"""Laboratory tests compared with the model at their own conditions, and the model's error."""

from __future__ import annotations

import functools
import math
from collections import Counter
from collections.abc import Iterator, Sequence
from contextlib import suppress
from dataclasses import replace
from typing import Any, NamedTuple

import numpy as np
import pandas as pd

from pipeline.analysis.dataset import Layout
from pipeline.analysis.field import Here, PointField, places_of, point_field, quantile
from pipeline.analysis.margin import NOT_DECIDED
from pipeline.analysis.model_error import AGREED, USUAL, ModelError
from pipeline.analysis.results import Results
from pipeline.analysis.rise_error import totals
from pipeline.analysis.scenes import heads_of
from pipeline.analysis.tables import frame_of, notes_of, short
from pipeline.quantities import display
from pipeline.sweep.conditions import Conditions
from pipeline.sweep.measurement import Measurement
from pipeline.sweep.model import Sweep
from tribo import InputError

NOT_KNOWN = "not known"
_AGREES = "yes", "no", NOT_DECIDED, NOT_KNOWN
USUAL_SCATTER = 0.05
"""Relative standard deviation of a transition's velocity."""
_DEVIATIONS = 2.0  # a transition agrees within this many standard deviations of its velocity
_BESIDE = 0.1  # a test is near a place within this relative distance in load and velocity
_SAME = 1e-6  # relative rounding difference of equal loads or velocities
_HEADS = (
    "test", "load [N]", "velocity [m/s]", "friction", "bulk temperature [°C]", "hold [s]",
    "computed", "decisive temperature [°C]", "agrees", "notes",
)  # fmt: skip


def own_conditions(data: Results, test: Measurement) -> Conditions:
    """Conditions of a test.

    Friction and bulk temperatures are the test's, if given, else those stored in the scene, without
    changes by `pipeline.at`. The test's bulk temperature is that of both pin and disk. All other
    conditions are those by which `data` are judged.
    """
    judged, scene = data.sweep.conditions, data.stored.conditions
    bulks = {body: getattr(scene, body) for body in ("bulk_temperature", "disk_temperature")}
    if test.bulk_temperature is not None:
        bulks = {"bulk_temperature": test.bulk_temperature, "disk_temperature": None}
    return replace(judged, friction=scene.friction, **bulks).replace_friction(test.friction)


def model_error(data: Results, field: PointField) -> ModelError:
    """Distribution of the model's own error in ln(critical velocity), from tests and a prior."""
    plain, tests = untested_error(data.sweep), data.sweep.tests
    found = [(test, one) for test in tests if (one := _known_comparison(data, field, test))]
    return replace(_update_error(plain, found), reason=AGREED if found else plain.reason)


def untested_error(sweep: Sweep) -> ModelError:
    """Distribution of the model's own error if the scene's tests are not used: the prior."""
    stated = sweep.model_scatter
    return ModelError(usual=USUAL if stated is None else stated)


def _known_comparison(data: Results, field: PointField, test: Measurement) -> Comparison | None:
    """Comparison of a test with the model under the test's conditions; None without a result.

    There is no result if the load is outside the sweep, if points at further velocities might
    change whether test and model agree, or if no critical velocity is found even by extrapolation.
    """
    try:
        found = comparison(field.under(own_conditions(data, test)), test)
    except InputError:
        return None
    return found if found.is_known and 0 < found.critical < math.inf else None


def _update_error(plain: ModelError, found: Sequence[tuple[Measurement, Comparison]]) -> ModelError:
    """Update the model's own error `plain` by `found`, tests compared with the model.

    In each run at most three tests count: the transition farthest from the model, and the wrong
    outcomes farthest below and farthest above the computed critical velocity. A measured transition
    counts as a wrong outcome if none is computed.
    """
    transitions, wrong = dict[Any, float](), dict[Any, float]()
    for number, (test, one) in enumerate(found):
        distance, key = math.log(test.velocity / one.critical), test.run or number
        if test.outcome is None and 0 < one.turn < math.inf:
            transitions[key] = max(transitions.get(key, 0.0), distance, key=abs)
        elif not one.is_right:
            side = key, distance > 0
            wrong[side] = max(wrong.get(side, 0.0), distance, key=abs)
    return replace(plain, residuals=(*transitions.values(),), wrong=(*wrong.values(),))


class Comparison(NamedTuple):
    """Comparison of a test with the wear that was computed at its load, under its conditions."""

    place: tuple[float, float]  # load [N], and velocity [m/s] moved into the computed range
    here: Here  # temperatures computed at that place
    turn: float  # computed velocity at which wear changes, nearest to the test, or infinite [m/s]
    critical: float  # `turn`, extrapolated by a power law if none is computed [m/s]
    is_right: bool  # True if the test has the computed outcome
    is_known: bool  # False if further velocities might change whether it agrees


def comparison(own: PointField, test: Measurement) -> Comparison:
    """Compare a laboratory test with the wear that the model predicts at the test's load.

    `own` has the rises computed on one surface or several, under the test's conditions. The test is
    a run with an outcome, "mild" or "severe", or a measured transition from mild to severe wear.

    `Comparison.turn` is the computed velocity [m/s], nearest to the test's, at which wear changes;
    for a measured transition only changes to severe wear count. It is the median over the surfaces.
    It is infinite if wear is mild at all computed velocities, and -infinite if wear is severe at
    all of them.

    A run agrees with the model if the model predicts the run's outcome on most surfaces. A test
    outside the computed velocities is compared at the nearest of them. A measured transition has a
    counterpart in the model if `Comparison.turn` is finite.

    `Comparison.is_known` is False if a test outside the computed velocities does not agree or has
    no counterpart, but wear may still change between the nearest computed velocity and the test's.
    With rising velocity wear may turn severe, and also mild if friction depends on velocity.

    Raises
    ------
    InputError
        If the test's load is outside the sweep, or too few points near the test are computed for
        the model to predict its outcome.
    """
    if test.changes:
        raise InputError("it has entries of its own, which the plane does not have")
    line = own.lines("velocity", *places_of(test.normal_load, test.velocity))
    low, high = (float(end[0]) for end in line.transitions.computed)
    end = float(np.clip(test.velocity, low, high))
    if math.isnan(end):
        end = float(np.clip(test.velocity, *own.ends["velocity"]))
    here = own.temperatures(test.normal_load, end)
    here.require_known()
    nearest = (line.nearest(test.velocity, test.outcome is None, more) for more in (False, True))
    turn, critical = (float(quantile(places, own.weights, 0.5)[0]) for places in nearest)
    is_severe = bool(np.mean(here.is_severe) > 0.5)
    is_right = test.outcome is not None and (test.outcome == "severe") == is_severe
    has_turn = test.outcome is None and 0 < turn < math.inf
    may_turn = own.conditions.has_friction_curve or is_severe == (test.velocity < end)
    is_known = is_right or has_turn or test.velocity == end or not may_turn
    return Comparison((test.normal_load, end), here, turn, critical, is_right, is_known)


def tests_beside(data: Results, load: float, velocity: float) -> Iterator[str]:
    """Yield a description of each test near a load [N] and velocity [m/s], with its conditions.

    A test is near if its load and its velocity differ by at most 10 %. Tests with a bulk
    temperature above the critical temperature are left out.
    """
    for test in data.sweep.tests:
        pairs = (test.normal_load, load), (test.velocity, velocity)
        if any(abs(measured - here) > _BESIDE * abs(here) for measured, here in pairs):
            continue
        with suppress(InputError):
            own = own_conditions(data, test)
            at = f"friction {own.friction_at(test.velocity):.3g}"
            bulk = display(own.bulk_temperature, "°C", 3)
            place = f"{test.normal_load:g} N, {test.velocity:g} m/s"
            yield f"{test.outcome or 'severe'}, {place} at {at} and bulk {bulk}"


def compared(data: Results) -> pd.DataFrame | None:
    """Data frame of tests compared with the model under their own conditions; None without tests.

    It is also None unless the sweep's points are a grid of loads and velocities. Friction and bulk
    temperature are taken from the test, or from the stored scene. If the sweep is judged at several
    critical temperatures or shares, the first one counts.
    """
    data = data.take(dict.fromkeys(data.judged_dims, 0))
    if not data.sweep.tests or data.kind is not Layout.PLANE:
        return None
    heads, rows = heads_of(data.rows, data.entry_dims), list[tuple[Any, ...]]()
    for scene in data.scenes:
        labels = [scene.rows[name].item() for name in heads]
        rows += [(*labels, *row) for row in _test_rows(scene)]
    return frame_of([*heads.values(), *_HEADS], rows)


def agreement(frame: pd.DataFrame) -> str:
    """Sentence such as "Agreement with the tests: 2 yes, 1 no.", which counts the tests in `frame`.

    `frame` is the result of `compared`. Its column "agrees" says whether each test agrees with the
    model: "yes", "no", "not decided" or "not known".
    """
    counts = Counter(frame["agrees"])
    said = ", ".join(f"{counts[key]} {key}" for key in _AGREES if counts[key])
    return f"Agreement with the tests: {said}."


def test_parts(frame: pd.DataFrame) -> Iterator[str | pd.DataFrame]:
    """Yield parts of a report on tests: how many agree with the model, a table, and notes.

    `frame` is the result of `compared`, with a row for each test.
    """
    yield agreement(frame)
    yield short(frame, ["notes"])
    yield from notes_of(frame)
    yield (
        f"each at its own friction and bulk temperature; a transition agrees within "
        f"{_DEVIATIONS:g} standard deviations of its velocity, {100 * USUAL_SCATTER:g} % "
        "each; a test agrees if the model has its outcome even with the temperature error"
    )


def _test_rows(scene: Results) -> Iterator[tuple[Any, ...]]:
    """Yield the values of each test of a scene, in the order of the columns `_HEADS` [SI]."""
    field = point_field(scene)
    under = functools.cache(field.under)
    hold = getattr(scene.sweep.scene.loading, "hold", 0.0)
    for test in scene.sweep.tests:
        place = test.normal_load, test.velocity
        note = f"computed with the hold of the scene, {hold:g} s" * (test.hold not in (None, hold))
        at = test.friction, test.bulk_temperature
        try:
            own = own_conditions(scene, test)
            at = own.friction, own.bulk_temperature
            found = comparison(under(own), test)
            computed, temperature, agrees = _test_answer(test, under(own), found)
            if found.place != place:
                note = f"computed at {found.place[1]:g} m/s, where the points end"
        except InputError as error:
            computed, temperature, agrees, note = NOT_KNOWN, None, NOT_KNOWN, str(error)
        kind = test.outcome or "transition"
        yield (kind, *place, *at, test.hold, computed, temperature, agrees, note)


def _test_answer(test: Measurement, field: PointField, found: Comparison) -> tuple[str, float, str]:
    """Computed outcome in words, contact temperature [K], and agreement with the test in words.

    The temperature is the one that the criterion compares with the critical temperature; it is the
    median over surfaces. Agreement is "yes", "no", "not decided" or "not known". `found` compares
    the test with `field`. A transition agrees if the computed velocity is within two standard
    deviations of the measured one. A single outcome is not decided if the numerical error might
    change the computed one. The model's own error is not allowed for, as it is inferred from the
    tests.
    """
    here, error = found.here, totals(field.errors(*found.place)).item()
    values, critical = (part[:, 0] for part in (here.values, here.critical))
    is_severe = here.is_severe[:, 0]
    temperature = float(quantile(values, field.weights, 0.5))
    rises = np.array([*map(field.conditions.temperature_error, values.tolist())])
    known = np.abs(critical - values) > error * rises
    verdict = NOT_DECIDED
    if np.all(known) and len({*is_severe.tolist()}) == 1:
        verdict = "severe" if is_severe[0] else "mild"
    if outcome := test.outcome:
        said = verdict
        if len({*is_severe.tolist()}) > 1:
            said = f"severe on {is_severe.sum()} of {len(is_severe)} surfaces"
        agrees = NOT_DECIDED if verdict == NOT_DECIDED else "yes" if verdict == outcome else "no"
        return said, temperature, agrees if found.is_known else NOT_KNOWN
    scatter = USUAL_SCATTER * test.velocity
    near = abs(found.turn - test.velocity) <= _DEVIATIONS * scatter
    said = f"at {found.turn:.3g} m/s" if 0 < found.turn < math.inf else verdict
    if not found.is_known:
        return said, temperature, NOT_KNOWN
    if math.isnan(error):
        return said, temperature, NOT_DECIDED
    away = NOT_DECIDED if verdict == NOT_DECIDED else "no"
    return said, temperature, "yes" if near else away
