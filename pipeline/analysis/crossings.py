"""Where a sweep crosses from mild to severe wear, as plain arrays.

Friction, bulk temperature, critical temperature and failing share enter only here, by
`pipeline.sweep.criterion`.
"""

from __future__ import annotations

from collections.abc import Iterable

import numpy as np
from numpy.typing import NDArray

from pipeline.analysis.attributes import attributes_of
from pipeline.analysis.band import CROSSES, MILD, SEVERE, UNKNOWN, with_band
from pipeline.analysis.conditions import Bulk, conditions_of, of_sample
from pipeline.analysis.interpolation import crossing, exponent
from pipeline.analysis.labelled import Labelled, Variable, stacked
from pipeline.analysis.results import Results, decisive_plane
from pipeline.sweep.criterion import Conditions, rise_limit
from pipeline.sweep.lubrication import Lubrication
from tribo import InputError
from tribo.types import Array


def crossings(
    results: Results,
    friction: float | Iterable[float] | None = None,
    bulk_temperature: Bulk | None = None,
    critical_temperature: float | str | None = None,
    share: float | str | None = None,
) -> Labelled:
    """Critical velocity for each load and critical load for each velocity.

    Parameters
    ----------
    results : Results
        What the sweep has computed.
    friction, bulk_temperature, critical_temperature, share
        See `pipeline.boundary`.

    Returns
    -------
    Labelled
        What `pipeline.boundary` gives.
    """
    if isinstance(friction, str):
        raise InputError(f'friction: "{friction}" is text; give a number such as 0.1, or several')
    others = (bulk_temperature, critical_temperature, share)
    if isinstance(friction, Iterable):
        values = [float(value) for value in friction]
        each = [crossings(results, value, *others) for value in values]
        own = {"units": "1", "long_name": "friction coefficient"}
        axis = Variable(("friction",), np.array(values), own)
        alike = {k: v for k, v in each[0].attrs.items() if all(e.attrs[k] == v for e in each)}
        return stacked(each, "friction", axis, alike)
    conditions = conditions_of(results, friction, *others)
    found = [
        _on_surface(part, of_sample(part, conditions, (friction, *others)))
        for part in results.parts()
    ]
    if (name := results.leading) is None:
        return found[0]
    numbers = np.array([place[name] for place in results.places])
    attrs = conditions.as_dict() | {  # a sample's are its own
        "missing_points": sum(each.attrs["missing_points"] for each in found)
    }
    return with_band(stacked(found, name, Variable((name,), numbers, {}), attrs))


def _on_surface(part: Results, conditions: Conditions) -> Labelled:
    """The boundary on one surface."""
    loads, velocities, r = decisive_plane(part.at(conditions), conditions.failing_share)
    limit = rise_limit(conditions)
    missing = ~np.isfinite(r) & part.asked()
    lubrication = Lubrication.stored(attributes_of(part))
    critical = {
        "load": np.array([crossing(velocities, row, limit) for row in r]),
        "velocity": np.array([crossing(loads, column, limit) for column in r.T]),
    }
    found = {
        "critical_velocity": Variable(
            ("load",),
            critical["load"],
            {"units": "m/s", "long_name": "velocity at the transition to severe wear"},
        ),
        "critical_load": Variable(
            ("velocity",),
            critical["velocity"],
            {"units": "N", "long_name": "normal load at the transition to severe wear"},
        ),
    }
    found["rise_exponent_at_load"] = Variable(
        ("load",),
        np.array([exponent(velocities, *each) for each in zip(r, critical["load"], strict=True)]),
        {"units": "1", "long_name": "d ln(rise) / d ln(velocity) at the crossing"},
    )
    for name, axis in (("load", 1), ("velocity", 0)):
        at = critical[name]
        outcome = _outcome(at, r, limit, axis)
        found[f"outcome_at_{name}"] = Variable((name,), outcome, _OUTCOME_ATTRS)
        found[f"missing_at_{name}"] = Variable(
            (name,),
            np.count_nonzero(missing, axis=axis),
            {"units": "1", "long_name": f"pending or failed points at this {name}"},
        )
        if lubrication:
            at_load, at_velocity = (loads, at) if name == "load" else (at, velocities)
            mean_bulk = conditions.mean_bulk_temperature
            found[f"film_parameter_at_{name}"] = Variable(
                (name,),
                lubrication.film_parameter(at_load, at_velocity, mean_bulk),
                {"units": "1", "long_name": "film parameter at the crossing"},
            )
    axes = {
        "load": Variable(("load",), loads, {}),
        "velocity": Variable(("velocity",), velocities, {}),
    }
    missed = int(np.count_nonzero(missing))
    return Labelled(found, axes, conditions.as_dict() | {"missing_points": missed})


_OUTCOME_ATTRS = {
    "long_name": "why there is no crossing",
    "flag_values": np.array([CROSSES, MILD, SEVERE, UNKNOWN], dtype=np.int8),
    "flag_meanings": "crosses mild_throughout severe_from_the_lowest unknown",
}


def _outcome(found: Array, r: Array, limit: float, axis: int) -> NDArray[np.int8]:
    known = np.isfinite(r)
    lowest = np.take_along_axis(r, np.expand_dims(known.argmax(axis), axis), axis).squeeze(axis)
    outcome = np.where(lowest > limit, SEVERE, MILD)
    outcome[~known.any(axis)] = UNKNOWN
    outcome[np.isfinite(found)] = CROSSES
    return outcome.astype(np.int8)
