"""Wear rates that a scene knows at several bulk temperatures, beside the one it computes with.

Contact and wear know no temperature, so that another bulk temperature needs no new run where the
wear rate stays. The seed's white oil has 0.37 at 25 °C and 0.88 × 10⁻⁶ mm³/(N m) at 100 °C, which
is +13 % of velocity.
"""

from __future__ import annotations

import itertools
from dataclasses import replace

import numpy as np

from pipeline.quantities import display, shown_in
from pipeline.sweep.conditions import PATHS, celsius_text
from pipeline.sweep.model import Sweep
from pipeline.sweep.samples import SPECIFIC_WEAR_RATE as WEAR_RATE
from tribo import Wear

_ALIKE = 0.05  # by which two wear rates may differ
_MOST_ROWS = 1000  # that are asked


def note_on_wear(sweep: Sweep) -> str | None:
    """Say that a row of a sweep wears at a rate of another bulk temperature; None if none does."""
    if not sweep.about.wear_by_temperature:
        return None
    rows = (sweep.variant(name) for name in itertools.islice(sweep.variants.given, _MOST_ROWS))
    bulks, rates = (_unknown_ends(sweep, path) for path in (PATHS["bulk_temperature"], WEAR_RATE))
    if bulks:
        rows = (
            one.changed(conditions=replace(one.conditions, bulk_temperature=bulk))
            for one in rows
            for bulk in bulks
        )
    notes = (_note(row, rates) for row in rows)
    found = next(filter(None, notes), None)
    if found and len(bulks) > 1:
        return (
            f"temperature.bulk is unknown, and {found}, or let wear.specific_wear_rate be unknown "
            "between both"
        )
    return found


def _unknown_ends(sweep: Sweep, path: str) -> tuple[float, ...]:
    """Ends of the range in which an input lies with 90 % [SI]; its value where that is fixed."""
    draw = sweep.variants.draw
    for one in draw.fixed if draw else ():
        if one.unknown.path == path:
            return (one.value,)
    for unknown in sweep.variants.unknown:
        if unknown.path == path:
            return tuple(unknown.quantile(np.array([0.05, 0.95])).tolist())
    return ()


def _note(sweep: Sweep, unknown_rates: tuple[float, ...]) -> str | None:
    known, wear = sorted(sweep.about.wear_by_temperature), sweep.scene.wear
    if not isinstance(wear, Wear) or not wear.specific_wear_rate:
        return None
    bulk = sweep.conditions.mean_bulk_temperature
    temperatures, rates = np.array(known).T
    beyond = "," if temperatures[0] <= bulk <= temperatures[-1] else ", as at the nearest known,"
    rate = float(np.exp(np.interp(bulk, temperatures, np.log(rates))))
    own = unknown_rates or (wear.specific_wear_rate,)
    if (1 - _ALIKE) * min(own) < rate < (1 + _ALIKE) * max(own):
        return None
    ends = " to ".join(f"{shown_in(one, 'mm³/(N m)'):.3g}" for one in own)
    return (
        f"the wear rate at the bulk temperature, {celsius_text(bulk)}{beyond} is "
        f"{display(rate, 'mm³/(N m)', 3)} by wear.by_temperature, and the contacts have {ends}; "
        f'run the scene again with --set "wear.specific_wear_rate={display(rate, "mm^3/(N m)", 3)}"'
    )
