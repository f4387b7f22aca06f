"""Choose the cheapest preset that promises an error of a scene's boundary."""

from __future__ import annotations

import math
from dataclasses import replace

from pipeline.constants import PRESET_BOUNDS
from pipeline.scene.scenefile import SceneLike, sweep_of
from pipeline.scene.units import share_of
from pipeline.scene.written import with_fidelity
from pipeline.sweep.model import Sweep
from pipeline.sweep.remarks import Remark
from pipeline.sweep.selection import presets_for, velocity_error
from pipeline.sweep.severity import rise_limit
from pipeline.tradeoff.probe import present_heat_beside_boundary
from tribo import InputError


def choose_accuracy(sweep: SceneLike, accuracy: float | str) -> Sweep:
    """Return a sweep with the cheapest preset that keeps the critical velocity within `accuracy`.

    `accuracy` is a relative error, such as 0.02 or "2%". Heat acts at its own time if the scene
    says so, or if heat that is taken to act since the start would make a contact beside the
    boundary too warm by more than a third of `accuracy`.

    Raises
    ------
    InputError
        If the accuracy is not between 0 and 1, or if no preset promises it.

    Examples
    --------
    >>> import pipeline
    >>> pipeline.choose_accuracy("first_try", "2%").preset
    'standard'
    """
    sweep, accuracy = sweep_of(sweep), share_of(accuracy)
    if not 0 < accuracy < 1:
        raise InputError(f"accuracy is {accuracy!r}; it must be between 0 and 1, such as 0.02")
    for name, fidelity in presets_for(sweep.scene, PRESET_BOUNDS).items():
        chosen = with_fidelity(sweep, fidelity, name)
        if (velocity_error(chosen) or 0.0) <= accuracy:
            return _with_whole_history(chosen, name, accuracy)
    best = 100 * min(PRESET_BOUNDS.values())
    raise InputError(f"accuracy is {accuracy:g}; no preset promises less than {best:g} %")


_LARGE = 1 / 3  # share of the accuracy from which the error of present heat counts


def _with_whole_history(sweep: Sweep, preset: str, accuracy: float) -> Sweep:
    """The sweep with heat that acts at its own time, if present heat would err by too much."""
    limited = sweep.conditions.critical_temperature is not None
    if not limited or sweep.scene.remembers_heat or not math.isfinite(rise_limit(sweep.conditions)):
        return sweep
    excess = present_heat_beside_boundary(sweep)
    if excess <= _LARGE * accuracy:
        return sweep
    history = replace(sweep.scene.fidelity, heat_model="history")
    words = (
        '"history", as heat that acts since the start would make contacts '
        f"{100 * excess:.2g} % too warm beside the boundary"
    )
    note = Remark("fidelity.heat_model", "note", words)
    chosen = with_fidelity(sweep, history, preset)
    return replace(chosen, notes=(*chosen.notes, note))
