"""Wear rates that a scene knows at several bulk temperatures, beside the one it computes with.

Contact and wear know no temperature, so that another bulk temperature needs no new run where the
wear rate stays. The seed's white oil has 0.37 at 25 °C and 0.88 × 10⁻⁶ mm³/(N m) at 100 °C, which
is +13 % of velocity.
"""

from __future__ import annotations

import itertools

import numpy as np

from pipeline.sweep.conditions import celsius_text
from pipeline.sweep.model import Sweep
from tribo import Wear

_ALIKE = 0.05  # by which two wear rates may differ
_MOST_ROWS = 1000  # that are asked


def note_on_wear(sweep: Sweep) -> str | None:
    """Say that a row of a sweep wears at a rate of another bulk temperature; None if none does."""
    if not sweep.about.wear_by_temperature:
        return None
    rows = (sweep.variant(name) for name in itertools.islice(sweep.variants.given, _MOST_ROWS))
    return next(filter(None, map(_note, rows)), None)


def _note(sweep: Sweep) -> str | None:
    known, wear = sorted(sweep.about.wear_by_temperature), sweep.scene.wear
    if not isinstance(wear, Wear) or not wear.specific_wear_rate:
        return None
    bulk = sweep.conditions.mean_bulk_temperature
    temperatures, rates = np.array(known).T
    beyond = "," if temperatures[0] <= bulk <= temperatures[-1] else ", as at the nearest known,"
    rate = float(np.exp(np.interp(bulk, temperatures, np.log(rates))))
    if abs(rate / wear.specific_wear_rate - 1) < _ALIKE:
        return None
    return (
        f"the wear rate at the bulk temperature, {celsius_text(bulk)}{beyond} is {1e9 * rate:.3g} "
        "mm³/(N m) by wear.by_temperature, and the contacts have "
        f"{1e9 * wear.specific_wear_rate:.3g}; run "
        f'the scene again with --set "wear.specific_wear_rate={1e9 * rate:.3g} mm^3/(N m)"'
    )
