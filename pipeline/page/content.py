"""Data of a sweep for a page: ln(rise) on a fine grid, what tests say of it, and points.

The page looks arrays up and draws them. All depend on the reader's conditions through ln(limit)
alone, but what tests say, which depends on the critical temperature. Arrays are base64 of
little-endian numbers.
"""

from __future__ import annotations

import base64
import math
from collections.abc import Mapping, Sequence
from contextlib import suppress
from dataclasses import asdict, replace
from typing import Any

import numpy as np
import xarray as xr

from pipeline.analysis.film import critical_inside, is_outside
from pipeline.analysis.judge import judge_of
from pipeline.analysis.likelihood import condition
from pipeline.analysis.outcomes import Outcome, outcomes
from pipeline.analysis.reading import results
from pipeline.analysis.results import Results
from pipeline.analysis.rise_error import SURFACE, rise_errors, totals
from pipeline.analysis.rises import Rises, rises_of
from pipeline.analysis.specimen import specimen_of
from pipeline.analysis.tested import Evidence, is_alike
from pipeline.constants import DECIDED
from pipeline.figures.overlays import number_tests, reachable_tests
from pipeline.page.controls import Control, controls
from pipeline.page.pictures import FIELDS, packed_fields
from pipeline.quantities import shown_in
from pipeline.store.schema import PLANE
from pipeline.sweep.conditions import Conditions, plain_values
from pipeline.sweep.inputs import spread_places
from pipeline.sweep.severity import above_colder, corrected_columns, rise_limit, worst_moment
from tribo import Criterion, InputError
from tribo.types import Array, Indices

MOST_FIELDS = 500
"""Default for the largest number of points with fields on a page: some 5 MB."""

_NUMBERS = (
    ("contact_width", "contact width", "µm"),
    ("contact_fraction", "contact area", "% of the window"),
    ("mean_pressure", "mean pressure", "GPa"),
    ("max_pressure", "highest pressure", "GPa"),
    ("saturated_fraction", "contact at the hardness", "%"),
    ("wear_depth_max", "wear depth", "µm"),
    ("wear_volume", "worn volume", "mm³"),
    ("pin_heat_share", "pin’s share of the heat", "%"),
    ("sliding_distance", "sliding distance", "m"),
    ("time", "duration", "s"),
)
"""Values shown for a point: variable, label and unit."""


def content(ds: xr.Dataset | Results, most_fields: int = MOST_FIELDS) -> dict[str, Any]:
    """Data of the page for one scene with a grid of loads and velocities, as JSON values.

    Velocity 0 is left out. Contact fields are included for at most `most_fields` points: those
    nearest to the transition.
    """
    data = results(ds).take_moving()
    data.require_plane()
    sweep, conditions = data.sweep, data.conditions
    judge = judge_of(data) if data.stored.inputs and conditions.critical_temperature else None
    conditions = judge.conditions if judge else conditions
    unequal = data.rest["bulk_ratio"].values.tolist() if "bulk_ratio" in data.rest.coords else []
    ratios, first = _tabulated_ratios(unequal), data.take_row(None)
    columns = corrected_columns(data.columns, conditions)
    # Axes: load, velocity, bulk ratio, then quantile, step.
    deciding, quantiles = _tables(columns, data.shares, conditions.criterion, ratios)
    load = data.columns["normal_load"][..., None, :]
    worst = worst_moment(deciding, load, data.least_loads[:, None, None, None])
    rises = np.where(data.done[..., None], _step_values(deciding, worst), np.nan)
    shown = 0 if data.front else ...  # points are shown on the first surface
    steps = worst[shown][..., ratios.index(0.0)]  # and at the step that decides
    has_fields = {*FIELDS} <= data.rest.keys()
    chosen = _nearest(first, conditions, most_fields) if has_fields else []
    form = controls(conditions, sweep.scene.friction_heat, len(ratios) > 1)
    return {
        **_page_facts(data),
        **_point_states(first),
        "conditions": _conditions(data, conditions),
        "controls": [*map(asdict, form)],
        "deciding": conditions.criterion.temperature,
        "times": packed_array(_step_values(first.columns["time"], steps), "<f4"),
        "bulk_ratios": ratios,
        "rises": packed_array(_step_values(quantiles[shown], steps[..., None, None]), "<f4"),
        **_planes(rises, data, conditions),
        **_evidence(data, conditions, form),
        "fields": packed_fields(first.rest, chosen, conditions.bulk_ratio),
    }


def _page_facts(data: Results) -> dict[str, Any]:
    """Data for the page: the scene's name, the values and ranges of its axes, words."""
    sweep = data.sweep
    return {
        "name": sweep.name,
        "outside": _range_hint(data.loads, data.velocities),
        "origins": _ORIGINS,
        "friction_band": sweep.friction_band,
        "several": Outcome.SEVERAL,
        "outcomes": {
            axis: [*outcomes(axis).values(), "outside the model: oil film"]
            for axis in ("velocity", "load")
        },
        "loads": data.loads.tolist(),
        "velocities": data.velocities.tolist(),
        "quantiles": data.shares.tolist(),
    }


def _range_hint(loads: Array, velocities: Array) -> str:
    """Hint for the reader: the range of loads and velocities that may be typed."""
    ends = [f"{x[0]:.4g} to {x[-1]:.4g}" for x in (loads, velocities)]
    return f"Type a load and a velocity within the sweep: {ends[0]} N, {ends[1]} m/s."


def _point_states(data: Results) -> dict[str, Any]:
    """Data on each point: the status, whether it was asked for, values of the contact, a message.

    Points are in the flat order (load, velocity).
    """
    stored = {*data.columns, *data.rest}
    return {
        "status": digit_string(data.columns["status"]),
        "asked": digit_string(data.asked),
        "numbers": [
            {"label": label, "unit": unit}
            | {"values": packed_array(shown_in(data.values(name)[..., -1], unit.split()[0]), "<f4")}
            for name, label, unit in _NUMBERS
            if name in stored
        ],
        "messages": {
            str(place): str(message)
            for place, message in enumerate(data.messages.ravel())
            if isinstance(message, str) and message  # NaN if a point was masked
        },
    }


def _tabulated_ratios(unequal: Sequence[float]) -> list[float]:
    """Ratios of bulk temperatures for which the page has rises, ascending; others interpolated.

    They are those that are stored, 0, and the middles between them.
    """
    known = np.union1d(unequal, [0.0])
    return [float(one) for one in np.union1d(known, (known[1:] + known[:-1]) / 2)]


def _tables(
    columns: Mapping[str, Array], quantile: Array, criterion: Criterion, ratios: Sequence[float]
) -> tuple[Array, Array]:
    """Two tables: the rise that `criterion` compares with its limit, and quantiles of the rise.

    Rises are per unit friction coefficient [K]. The first table has the axes (..., bulk ratio,
    step), the second (..., bulk ratio, probability, step).

    - `columns` are variables by name. `quantile` has the probabilities of ``rise_quantile``.
    - `ratios` are bulk ratios [K]: (disk's − pin's bulk temperature)/friction coefficient.
    """
    at_ratios = [{**above_colder(columns, ratio), "quantile": quantile} for ratio in ratios]
    deciding = [criterion.rise(rises) for rises in at_ratios]
    quantiles = [np.swapaxes(rises["rise_quantile"], -1, -2) for rises in at_ratios]
    return np.stack(deciding, axis=-2), np.stack(quantiles, axis=-3)


def _step_values(values: Array, steps: Indices) -> Array:
    """For each point, its value at one step; `steps` has the index of the step by point.

    `values` have the steps on their last axis.
    """
    chosen: Array = np.take_along_axis(values, steps[..., None], axis=-1)[..., 0]
    return chosen


def _planes(rises: Array, data: Results, conditions: Conditions) -> dict[str, Any]:
    """ln(rise) and its numerical error on a fine grid, and where it passes each target.

    `rises` are those of the sweep's points per unit friction coefficient [K], with the axes
    surface, load, velocity and bulk ratio. The tables have the last in front.
    """
    base = rises_of(data, conditions)
    parts = pieces_of(len(data.loads), len(data.velocities), rises.shape[-1])
    velocities, loads = divided(data.velocities, parts[0]), divided(data.loads, parts[1])
    places = [axis.ravel() for axis in np.meshgrid(loads, velocities, indexing="ij")]
    shape = len(loads), len(velocities)
    plain = np.moveaxis(rises, -1, 0) / conditions.friction_factor(data.velocities)
    each = [replace(base, plane=specimen_of(data, one, conditions).rises) for one in plain]
    planes = np.log([np.reshape(one.rise(*places), shape) for one in each])
    errors, known = rise_errors(base, *places), planes[np.isfinite(planes)]
    ends = (known.min(), known.max()) if known.size else (0.0, 1.0)
    # Just beyond both ends, so that at the outermost limits wear surely does not change.
    targets = np.linspace(ends[0] - _ROUNDING, ends[1] + _ROUNDING, _TARGETS)
    states = np.where(base.is_done(*places), COMPUTED, INTERPOLATED)
    states = np.where(base.is_continued(*places), EXTRAPOLATED, states)
    return {
        "fine": {"velocity": velocities.tolist(), "load": loads.tolist()},
        "nodes": {
            "velocity": (parts[0] * np.arange(len(data.velocities))).tolist(),
            "load": (parts[1] * np.arange(len(data.loads))).tolist(),
        },
        "friction_factors": conditions.friction_factor(velocities).tolist(),
        "plane": packed_array(planes, "<f4"),
        "errors": packed_array(np.log1p(totals(errors)), "<f4"),
        "surface_errors": packed_array(np.log1p(errors[SURFACE]), "<f4"),
        "state": digit_string(states),
        "film": digit_string(is_outside(base, *places)),
        "targets": targets.tolist(),
        "turns": {
            "velocity": _turns(each, base, "velocity", data.loads, np.exp(targets)),
            "load": _turns(each, base, "load", data.velocities, np.exp(targets)),
        },
    }


def _turns(
    each: Sequence[Rises], own: Rises, axis: str, at: Array, limits: Array
) -> dict[str, str]:
    """Critical values along an axis by limit, and codes of outcomes, the last for "outside".

    Of `each` of the rises by bulk ratio. A film is that at the scene's `own` temperatures.
    """
    places, codes = list[Array](), list[Array]()
    for rises in each:
        turns = rises.turns_by_limit(axis, at, limits)
        along = np.broadcast_to(at[:, None], turns.outcome.shape)
        critical, is_film = critical_inside(own, axis, along, turns)
        places.append(critical)
        codes.append(np.where(is_film, len(Outcome), turns.outcome))
    return {"places": packed_array(places, "<f4"), "codes": digit_string(codes)}


def _evidence(data: Results, conditions: Conditions, form: Sequence[Control]) -> dict[str, Any]:
    """What tests say, by critical temperature: probabilities by y, levels, and each test.

    - ``criticals``: critical temperatures [K] of the tables, within those of the slider.
    - ``supports``: loads and velocities of the tables, between which uncertain inputs act
      differently; one of each if none is simulated.
    - ``ys``: values of y of the table ``likely``, by critical temperature, support and y.
    - ``levels``: y at which severe wear is 5, 50 and 95 % likely, by critical temperature and
      support.
    - ``no_mild``, ``no_severe``: whether no place is, by critical temperature.
    """
    (slider,) = (one for one in form if one.name == "critical_temperature")
    low, high = (end - slider.offset for end in (slider.low, slider.high))
    own = conditions.critical_temperature
    criticals = np.linspace(low, high, _CRITICALS - (own is not None))
    criticals = criticals if own is None else np.union1d(criticals, own)
    ys = _WIDEST * np.sinh(np.linspace(-_BEND, _BEND, _TARGETS)) / math.sinh(_BEND)
    supports = _supports(data)
    nodes = [axis.ravel() for axis in np.meshgrid(*supports, indexing="ij")]
    likely, levels, open_sides = list[Array](), list[list[float]](), list[tuple[bool, bool]]()
    evidence = None
    for critical in criticals.tolist():
        offset, sides = 0.0, (True, True)
        found, a = _no_evidence(data), np.empty((len(nodes[0]), 0))
        with suppress(InputError):  # at or below the bulk temperature
            judge = judge_of(data, replace(conditions, critical_temperature=critical))
            found, offset, sides = judge.evidence, judge.offset, judge.open_sides
            a = judge.effects.at(judge.tested_conditions, *nodes)
        evidence = found if critical == own else evidence
        for here in a.tolist():
            likely.append(found.belief.probability(ys + offset, tuple(here)))
            levels.append(np.interp(DECIDED, likely[-1], ys).tolist())
        open_sides.append(sides)
    return {
        "criticals": criticals.tolist(),
        "supports": dict(zip(PLANE, (axis.tolist() for axis in supports), strict=True)),
        "ys": ys.tolist(),
        "likely": packed_array(likely, "<f4"),
        "levels": levels,
        "no_mild": [no_mild for no_mild, _ in open_sides],
        "no_severe": [no_severe for _, no_severe in open_sides],
        "measured": _tests(data, conditions, evidence),
        "decided": [DECIDED[0], DECIDED[-1]],
    }


def _supports(data: Results) -> tuple[Array, Array]:
    """Loads and velocities at which inputs are simulated; the first of each if none is."""
    places = spread_places(data.loads.tolist(), data.velocities.tolist())
    if not any(one.is_simulated for one in data.stored.inputs):
        places = places[:1]
    loads, velocities = (np.unique(axis) for axis in zip(*places, strict=True))
    return loads, velocities


def _no_evidence(data: Results) -> Evidence:
    return Evidence((), (), (), condition((), data.prior))


def _tests(
    data: Results, conditions: Conditions, evidence: Evidence | None
) -> list[dict[str, Any]]:
    """Tests as dictionaries: place, outcome, sign in the legend, and what dominance compares."""
    drawn = reachable_tests(data, number_tests(data.sweep.tests))[0].values()
    facts = []
    for row in evidence.rows if evidence else ():
        test, own = row.test, row.conditions
        bulks = own and (own.bulk_temperature, own.disk_temperature or own.bulk_temperature)
        facts.append(
            {
                "load": test.normal_load,
                "velocity": test.velocity,
                "outcome": test.outcome,
                "places": [*map(list, test.places)],
                "friction": own and own.friction_at(test.velocity),
                "bulks": bulks,
                "isAlike": own is not None and is_alike(data, conditions, row),
                "sign": f"test-{test.outcome}" if test.outcome else "transition",
                "isDrawn": test in drawn,
            }
        )
    return facts


def _conditions(data: Results, conditions: Conditions) -> dict[str, Any]:
    """Conditions as a dictionary by name, with the disk's bulk temperature if it can be set.

    It can be set if `data` has rises for bodies of unequal temperature (``bulk_rise_quantile``). By
    default it is the pin's bulk temperature.
    """
    disk, bulk = conditions.disk_temperature, conditions.bulk_temperature
    plain = plain_values(conditions)
    if "bulk_rise_quantile" in data.columns:
        plain["disk_temperature"] = bulk if disk is None else disk
    return plain


def _nearest(data: Results, conditions: Conditions, most: int) -> list[tuple[int, ...]]:
    """Indices (load, velocity) of at most `most` done points, nearest to the transition.

    The page shows the fields of these points. If the critical temperature is not known, the points
    with the highest rise are taken.
    """
    places = np.argwhere(data.done)
    if len(places) > most:
        judged = conditions.critical_temperature is not None
        limit = rise_limit(conditions) if judged else math.inf
        rise = np.nan_to_num(data.rises(conditions)[data.done])
        distance = np.abs(rise - min(limit, rise.max(initial=0.0)))
        places = places[np.sort(np.argsort(distance, kind="stable")[:most])]
    return [tuple(place) for place in places.tolist()]


def digit_string(values: Any) -> str:
    """Write an array of codes 0 to 9 as a string of digits; NaN becomes 0."""
    digits = np.rint(np.nan_to_num(np.asarray(values, float))).astype(np.uint8)
    return str((digits + ord("0")).tobytes(), "ascii")


def packed_array(values: Any, dtype: str) -> str:
    """Convert an array to `dtype`, and its bytes to base64 text."""
    return base64.b64encode(np.asarray(values, dtype=dtype).tobytes()).decode()


_PLACES = np.array([60, 30])  # wanted number of nodes along velocity and load
_MOST = 400_000  # most values of a table: 2 MB of a page
_TARGETS, _CRITICALS = 121, 41  # values of ln(limit) or y, and critical temperatures, of tables
_ROUNDING = 1e-6  # of ln(limit)
_WIDEST, _BEND = 6.0, 5.0  # farthest y of a table, and how much closer its values are about 0
COMPUTED, INTERPOLATED, EXTRAPOLATED = 1, 2, 3
"""States of the rise at a node of the page's grid."""
_ORIGINS = ("", "computed there", "interpolated", "extrapolated")  # by state


def pieces_of(loads: int, velocities: int, others: int) -> tuple[int, int]:
    """Numbers of parts (by velocity, by load) into which the page's grid divides an interval.

    An interval lies between neighbouring velocities, or loads, of the sweep. `loads` and
    `velocities` are the sweep's numbers of loads and velocities. `others` is the number of values
    at each pair of load and velocity; a large number makes the grid coarser.
    """
    gaps = np.array([velocities, loads]) - 1
    parts = np.maximum(1, np.ceil(_PLACES / np.maximum(gaps, 1))).astype(int)
    while parts.max() > 1 and others * np.prod(parts * gaps + 1) > _MOST:
        parts[parts.argmax()] -= 1
    return int(parts[0]), int(parts[1])


def divided(places: Array, parts: int) -> Array:
    """Divide each interval between the values `places` of an axis into `parts` equal parts."""
    index = np.arange((len(places) - 1) * parts + 1) / parts
    return np.interp(index, np.arange(len(places)), places)
