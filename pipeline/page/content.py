"""Data of a sweep for a page: temperature rises on a fine grid, and the values of points.

The rise is that of the contact temperature which the criterion compares with the critical
temperature. Arrays are base64 of little-endian numbers, in the order surface, load, velocity.
"""

from __future__ import annotations

import base64
import math
from collections.abc import Mapping
from dataclasses import asdict, replace
from typing import Any

import numpy as np
import xarray as xr

from pipeline.analysis.curve import Curve, filled
from pipeline.analysis.field import PointField, point_field
from pipeline.analysis.laboratory import (
    own_conditions,
    untested_error,
)
from pipeline.analysis.left_out import fill_left_out
from pipeline.analysis.margin import DECIDED
from pipeline.analysis.model_error import AGREED, WORTH, ModelError
from pipeline.analysis.results import Results, results
from pipeline.analysis.rise_error import totals
from pipeline.analysis.transition import Outcome, outcomes, range_of
from pipeline.figures.overlays import number_tests, reachable_tests
from pipeline.page.controls import controls
from pipeline.page.pictures import FIELDS, packed_fields
from pipeline.quantities import shown_in
from pipeline.sweep.conditions import Conditions, plain_values
from pipeline.sweep.measurement import Measurement
from pipeline.sweep.severity import (
    above_colder,
    corrected_columns,
    rise_limit,
    worst_moment,
)
from tribo import Criterion
from tribo.types import Array, Indices, Mask

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
    unequal = data.rest["bulk_ratio"].values.tolist() if "bulk_ratio" in data.rest.coords else []
    ratios, shares, done = sorted([*unequal, 0.0]), _tabulated_shares(data, conditions), data.done
    columns = corrected_columns(data.columns, conditions)
    # Axes: load, velocity, bulk ratio, share or quantile, step.
    deciding, quantiles = _tables(columns, data.shares, conditions.criterion, ratios, shares)
    load = data.columns["normal_load"][..., None, None, :]
    worst = worst_moment(deciding, load, data.loads[:, None, None, None, None])
    decisive = np.where(done[..., None, None], _step_values(deciding, worst), np.nan)
    # Each point is shown at the step that decides.
    steps = worst[..., ratios.index(0.0), shares.index(conditions.criterion.share)]
    has_fields = {*FIELDS} <= data.rest.keys()
    chosen = _nearest(data, done, conditions, most_fields) if has_fields else []
    varies = len(ratios) > 1, len(shares) > 1
    return {
        **_page_facts(data),
        **_point_states(data),
        "conditions": _conditions(data, conditions),
        "controls": [*map(asdict, controls(conditions, sweep.scene.friction_heat, *varies))],
        "deciding": conditions.criterion.temperature,
        "times": packed_array(_step_values(data.columns["time"], steps), "<f4"),
        "bulk_ratios": ratios,
        "shares": shares,
        "rises": packed_array(_step_values(quantiles, steps[..., None, None]), "<f4"),
        **_planes(decisive, data, conditions),
        **_model_facts(data),
        "fields": packed_fields(data.rest, chosen, conditions.bulk_ratio)
        | {"stored": int(done.sum()) * has_fields},
    }


def _page_facts(data: Results) -> dict[str, Any]:
    """Data for the page: the scene's name, the values and ranges of its axes, its surfaces."""
    sweep = data.sweep
    return {
        "name": sweep.name,
        "outside": _range_hint(data.loads, data.velocities),
        "origins": _ORIGINS,
        "friction_band": sweep.friction_band,
        "range": {name: range_of(data, name) for name in ("load", "velocity")},
        "codes": {code.name: code for code in Outcome},
        "outcomes": {axis: list(outcomes(axis).values()) for axis in ("velocity", "load")},
        "loads": data.loads.tolist(),
        "velocities": data.velocities.tolist(),
        "quantiles": data.shares.tolist(),
        "surfaces": data.rows["realization"].values.tolist() if data.front else None,
    }


def _test_facts(test: Measurement) -> dict[str, Any]:
    """A test as a dictionary: its fields, and the name of its symbol in the legend."""
    sign = f"test-{test.outcome}" if test.outcome else "transition"
    return test.as_dict() | {"load": test.normal_load, "sign": sign}


def _tests(data: Results, loads: Array, velocities: Array, first: int) -> list[dict[str, Any]]:
    """Tests as dictionaries, each with its nearest grid node, friction and bulk temperature.

    The grid has nodes at all `loads` [N] and `velocities` [m/s]. `first` is the index in
    `velocities` of the sweep's lowest velocity; slower nodes are not taken.
    """
    facts, tests = [], data.sweep.tests
    drawn = reachable_tests(data, number_tests(tests))[0].values()
    for test in tests:
        own = own_conditions(data, test)
        there = _conditions(data, own) | {"strip_friction": test.friction is not None}
        names = ("friction", "bulk_temperature", "disk_temperature", "strip_friction")
        k = _nearest_of(loads, test.normal_load)
        j = first + _nearest_of(velocities[first:], test.velocity)
        facts.append(
            _test_facts(test)
            | {"own": {name: there[name] for name in names if name in there}}
            | {"node": (k, j)}
            | {"isInside": bool(loads[0] <= test.normal_load <= loads[-1])}
            | {"isDrawn": test in drawn}
        )
    return facts


def _nearest_of(places: Array, place: float) -> int:
    return int(np.abs(places - place).argmin())


def _range_hint(loads: Array, velocities: Array) -> str:
    """Hint for the reader: the range of loads and velocities that may be typed."""
    ends = [f"{x[0]:.4g} to {x[-1]:.4g}" for x in (loads, velocities)]
    return f"Type a load and a velocity within the sweep: {ends[0]} N, {ends[1]} m/s."


def _point_states(data: Results) -> dict[str, Any]:
    """Data on each point: the status, whether it was asked for, values of the contact, a message.

    Points are in the flat order (surface, load, velocity).
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


def _tabulated_shares(data: Results, conditions: Conditions) -> list[float]:
    """Failing shares for which the page has rises, ascending; others are interpolated.

    Wear is severe if more than the failing share of the contact area is hotter than the critical
    temperature. If the criterion takes no failing share, the list has one value without effect.
    """
    failing_share = conditions.criterion.share
    if not conditions.criterion.takes_share:
        return [failing_share]
    shares = np.minimum(np.round(1 - data.shares, 12), np.nextafter(1.0, 0.0))
    return [float(share) for share in np.union1d(shares, failing_share)]


def _tables(
    columns: Mapping[str, Array],
    quantile: Array,
    criterion: Criterion,
    ratios: list[float],
    shares: list[float],
) -> tuple[Array, Array]:
    """Two tables: the rise that `criterion` compares with its limit, and quantiles of the rise.

    Rises are per unit friction coefficient [K]. The first table has the axes (..., bulk ratio,
    failing share, step), the second (..., bulk ratio, probability, step).

    - `columns` are variables by name. `quantile` has the probabilities of ``rise_quantile``.
    - `ratios` are bulk ratios [K]: (disk's − pin's bulk temperature)/friction coefficient.
    - `shares` are failing shares: wear is severe if more than such a share of the contact area is
      too hot.
    """
    at_ratios = [{**above_colder(columns, ratio), "quantile": quantile} for ratio in ratios]
    criteria = [replace(criterion, share=share) for share in shares]
    deciding = [np.stack([one.rise(rises) for one in criteria], axis=-2) for rises in at_ratios]
    quantiles = [np.swapaxes(rises["rise_quantile"], -1, -2) for rises in at_ratios]
    return np.stack(deciding, axis=-3), np.stack(quantiles, axis=-3)


def _step_values(values: Array, steps: Indices) -> Array:
    """For each point, its value at one step; `steps` has the index of the step by point.

    `values` have the steps on their last axis.
    """
    chosen: Array = np.take_along_axis(values, steps[..., None], axis=-1)[..., 0]
    return chosen


def _planes(rises: Array, data: Results, conditions: Conditions) -> dict[str, Any]:
    """Data for the page, by name: temperature rises on a fine grid of load and velocity.

    The data have the grid's loads and velocities, the rises, their errors, and whether each rise is
    computed, interpolated or extrapolated. The grid reaches far beyond the sweep's velocities.

    A rise is that of the contact temperature which the criterion compares with the critical
    temperature, per unit friction coefficient. `rises` are those at the sweep's points [K], with
    the axes surface, load, velocity and two others, which are not interpolated. Rises on the grid
    have the same axes.

    If points are missing at a velocity of the sweep, the data also have a curve of rises over load,
    interpolated from the other points at this velocity. On this curve the page finds the critical
    load.
    """
    loads, velocities = data.loads, data.velocities
    rises, done = _with_left_out(rises, data, conditions)
    by_velocity, by_load = pieces_of(len(loads), len(velocities), rises[..., 0, 0, :, :].size)
    fine_loads = divided(loads, by_load)
    heat, nodes = rises_on_finer_grid(rises, loads, velocities, by_velocity, conditions)
    first = int(np.searchsorted(nodes, velocities[0]))
    state = states(done, (by_load, by_velocity), np.arange(len(nodes)) - first)
    plane = along(heat, loads, fine_loads, -4)
    is_beyond = ((nodes < velocities[0]) | (nodes > velocities[-1]))[:, None, None]
    plane = np.where(is_beyond, along(plane, nodes, nodes, -3, continued=True), plane)
    factor = conditions.friction_factor(nodes)
    plane *= factor[:, None, None]
    done = done.reshape(-1, loads.size, velocities.size)
    own_columns = np.argwhere(~done.all(axis=1))
    columns = along(rises, loads, fine_loads, -4).swapaxes(-4, -3)
    columns = columns.reshape(-1, velocities.size, *columns.shape[-3:])[tuple(own_columns.T)]
    within = np.where(np.isfinite(columns).all(axis=(-1, -2)), INTERPOLATED, EXTRAPOLATED)
    own_nodes = first + by_velocity * np.arange(velocities.size)
    own_rows = by_load * np.arange(loads.size)
    beside = by_load * rows_beside(done, by_load) + fine_loads.size * np.arange(len(done))[:, None]
    return {
        "fine": {"velocity": nodes.tolist(), "load": fine_loads.tolist()},
        "first": first,
        "inner": nodes[first : own_nodes[-1] + 1].tolist(),
        "nodes": {"velocity": own_nodes.tolist(), "load": own_rows.tolist()},
        "beside": beside.reshape(2, -1).T.tolist(),
        "measured": _tests(data, fine_loads, nodes[: own_nodes[-1] + 1], first),
        "friction_factors": factor.tolist(),
        "plane": packed_array(np.concatenate([*map(np.ravel, (plane, columns))]), "<f4"),
        "columns": _offsets(own_columns, own_nodes, state.size, fine_loads.size),
        "errors": packed_array(node_errors(point_field(data), fine_loads, nodes), "<f4"),
        "state": "".join(map(digit_string, (state, within))),
        "missing": (data.asked & ~data.done).reshape(done.shape).sum(axis=(1, 2)).tolist(),
    }


def _with_left_out(rises: Array, data: Results, conditions: Conditions) -> tuple[Array, Mask]:
    """Add rises at loads that a search of the boundary has left out, as the answers have them.

    Returns rises and the mask of points that have one, computed or estimated.
    """
    is_left_out = ~(data.asked | data.done).any(axis=-1)
    if not is_left_out.any():
        return rises, data.done
    factor = conditions.friction_factor(data.velocities)[:, None, None]
    planes = np.moveaxis(rises / factor, (-2, -1), (0, 1))
    left_out = np.broadcast_to(is_left_out, planes.shape[:-1])
    filled = fill_left_out(data.loads, data.velocities, planes, left_out)
    filled = np.moveaxis(filled, (0, 1), (-2, -1)) * factor
    return filled, np.asarray(np.isfinite(filled).all(axis=(-2, -1)))


def _offsets(lines: Indices, nodes: Indices, begin: int, width: int) -> dict[str, int]:
    """Index at which each line of temperature rises begins in the page's flat table, by line.

    A line has one surface, one velocity of the sweep, and `width` loads. Lines follow each other;
    the first begins at index `begin`. `lines` (n, 2) are the surface and the velocity of each line,
    as indices in the sweep. `nodes` has the index of each velocity of the sweep on the page's finer
    grid. The key "0 12" is the line of surface 0 at index 12 of the finer grid. An index counts
    nodes in the table; each node has a rise for every bulk ratio and failing share.
    """
    places = (f"{surface} {nodes[k]}" for surface, k in lines.tolist())
    return {place: begin + number * width for number, place in enumerate(places)}


def node_errors(field: PointField, loads: Array, velocities: Array) -> Array:
    """Relative numerical error of the rise at all pairs of `loads` [N] and `velocities` [m/s].

    The shape is (surface, load, velocity).
    """
    nodes = [axis.ravel() for axis in np.meshgrid(loads, velocities, indexing="ij")]
    planes = (replace(field, planes=(plane,)) for plane in field.planes)
    errors = [totals(plane.errors(*nodes)) for plane in planes]
    return np.reshape(errors, (-1, len(loads), len(velocities)))


def _model_facts(data: Results) -> dict[str, Any]:
    """Data for the verdicts of the page, by name.

    - ``model``: distribution of the model's own error, Student's t, as a table over its distances.
      It depends on the number of measured transitions that can be compared with the model, which
      the page counts under the conditions that the reader sets. So each number has a table.
    - ``decided``: two probabilities of severe wear: up to the first a verdict is mild, from the
      second on severe.
    """
    untested = untested_error(data.sweep)
    distances = np.sinh(np.linspace(-_WIDEST, _WIDEST, _STEPS))
    counts = range(len(data.sweep.tests) + 1)
    plain = [ModelError((0.0,) * n, usual=1.0) for n in counts]
    own = [replace(untested, residuals=(0.0,) * n) for n in counts]
    words = [one.text.partition(" % ")[2] for one in own]
    return {
        "model": {
            "distances": distances.tolist(),
            "below": [one.below(distances * one.scales[0]).round(7).tolist() for one in plain],
            "prior": untested.usual,
            "worth": WORTH,
            "words": [own[0].text, *words[1:]],
            "agreed": replace(own[0], reason=AGREED).text,
        },
        "decided": [DECIDED[0], DECIDED[-1]],
    }


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


def _nearest(data: Results, done: Mask, conditions: Conditions, most: int) -> list[tuple[int, ...]]:
    """Indices (surface, load, velocity) of at most `most` done points, nearest to the transition.

    The page shows the fields of these points. `done` is the mask of done points. If the critical
    temperature is not known, the points with the highest rise are taken.
    """
    places = np.argwhere(done)
    if len(places) > most:
        judged = conditions.critical_temperature is not None
        limit = rise_limit(conditions) if judged else math.inf
        rise = np.nan_to_num(data.rises(conditions)[done])
        distance = np.abs(rise - min(limit, rise.max(initial=0.0)))
        places = places[np.sort(np.argsort(distance, kind="stable")[:most])]
    return [tuple(place) for place in places.tolist()]


def digit_string(values: Any) -> str:
    """Write an array of codes 0 to 9 as a string of digits; NaN becomes 0."""
    return "".join(f"{code:.0f}" for code in np.nan_to_num(np.asarray(values, float)).flat)


def packed_array(values: Any, dtype: str) -> str:
    """Convert an array to `dtype`, and its bytes to base64 text."""
    return base64.b64encode(np.asarray(values, dtype=dtype).tobytes()).decode()


_PLACES = np.array([60, 30])  # wanted number of nodes along velocity and load
_MOST = 400_000  # most values of a table: 2 MB of a page
_FAR = 1e6  # velocity of an outermost node over the nearest velocity of the sweep
_PARTS_BEYOND = 16  # parts of an interval of the friction curve beyond the sweep's velocities
_STEPS, _WIDEST = 241, 7.0  # number of tabulated distances, up to sinh of the second number
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


def along(values: Array, x: Array, places: Array, axis: int, continued: bool = False) -> Array:
    """Interpolate values along an axis by cubics (`Curve`): known at `x`, wanted at `places`.

    Values that are not finite are left out. If `continued`, values are extrapolated by power laws.
    """
    fine = Curve(x, np.moveaxis(values, axis, -1))(places, continued)
    return np.moveaxis(fine, -1, axis)


def rises_on_finer_grid(
    rises: Array, loads: Array, velocities: Array, parts: int, conditions: Conditions
) -> tuple[Array, Array]:
    """Interpolate rises to a finer grid of velocities; return rises [K] and velocities [m/s] there.

    `rises` are those of the sweep's points [K], NaN where unknown. The last four axes are load,
    velocity and two others, which are not interpolated. The rises returned are divided by the
    factor by which velocity changes friction.

    The grid divides each interval between `velocities` [m/s] into `parts`, and reaches far beyond
    them. Outside the points of a load, rises follow a power law of velocity. If a load has a single
    point, its rises are estimated from other loads, or are NaN except at the point.
    """
    fine, factor = divided(velocities, parts), conditions.friction_factor
    stated = np.array([place for place, _ in conditions.friction_law.by_velocity], dtype=float)
    known = np.union1d(fine[[0, -1]], stated)
    beyond = divided(known, _PARTS_BEYOND)
    beyond = beyond[(beyond < fine[0]) | (beyond > fine[-1])]
    far = known[0] / _FAR, known[-1] * _FAR
    nodes = np.concatenate([far[:1], np.union1d(fine, beyond), far[1:]])
    heat = np.moveaxis(rises / factor(velocities)[:, None, None], (-2, -1), (0, 1))
    heat = np.moveaxis(filled(heat, loads, velocities), (0, 1), (-2, -1))
    is_row = np.isfinite(heat).sum(axis=-3, keepdims=True) > 1
    on_rows = along(heat, velocities, nodes, -3, continued=True)
    return np.where(is_row, on_rows, along(heat, velocities, nodes, -3)), nodes


def rows_beside(done: Mask, parts: int) -> Indices:
    """Indices of the sweep's loads below and above each load of the page's fine grid.

    Loads with fewer than two computed points are skipped, but for the first and the last. Where the
    grid has a load of the sweep, both indices are of this load. The shape is (2, surface, n_fine).

    `done` is the mask of computed points. The grid divides each interval of loads into `parts`.
    """
    number = np.arange(done.shape[-2])
    has_row, up = done.sum(axis=-1) > 1, np.arange(number[-1] * parts + 1) / parts
    below = np.maximum.accumulate(np.where(has_row, number, 0), axis=-1)
    above = np.minimum.accumulate(np.where(has_row, number, number[-1])[..., ::-1], axis=-1)
    both = below[..., np.floor(up).astype(int)], above[..., ::-1][..., np.ceil(up).astype(int)]
    return np.where(up % 1, both, up).astype(int)


def states(done: Mask, parts: tuple[int, int], numbers: Indices) -> Indices:
    """State of each node (surface, load, velocity) of the page's grid, as a code.

    A computed point is `COMPUTED`. A node is `INTERPOLATED` if the sweep's loads below and above it
    (`rows_beside`) have points on both sides of its velocity; else `EXTRAPOLATED`.

    `done` is the mask (surface, load, velocity) of computed points. `parts` is the pair
    (by load, by velocity) of the numbers of parts into which the grid divides an interval between
    points. `numbers` are the indices of the grid's velocities, counted from the sweep's first
    velocity: 0 there, and negative below it.
    """
    count = done.shape[-1]
    is_any: Mask = np.any(done, axis=-1, keepdims=True)
    low = parts[1] * np.argmax(done, axis=-1)[..., None]
    high = parts[1] * (count - 1 - np.argmax(done[..., ::-1], axis=-1)[..., None])
    is_in = is_any & (numbers >= low) & (numbers <= high)
    in_both = np.logical_and(
        *(np.take_along_axis(is_in, row[..., None], -2) for row in rows_beside(done, parts[0]))
    )
    state = np.where(in_both, INTERPOLATED, EXTRAPOLATED)
    of_points = np.flatnonzero((numbers >= 0) & (numbers % parts[1] == 0))[:count]
    on_points = np.zeros(state.shape, dtype=bool)
    on_points[..., :: parts[0], :][..., of_points] = done
    state[on_points] = COMPUTED
    return state
