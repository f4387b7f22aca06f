"""Choose the cheapest preset that promises an error of a scene's boundary."""

from __future__ import annotations

from pipeline.scene.scenefile import SceneLike, sweep_of
from pipeline.scene.units import share_of
from pipeline.scene.written import with_fidelity
from pipeline.sweep.accuracy import velocity_error
from pipeline.sweep.model import Sweep
from pipeline.sweep.selection import PRESET_BOUNDS, presets_for
from tribo import InputError


def choose_accuracy(sweep: SceneLike, accuracy: float | str) -> Sweep:
    """Return a sweep with the cheapest preset that keeps the critical velocity within `accuracy`.

    `accuracy` is a relative error, such as 0.02 or "2%". The scene's heat model is kept.

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
            return chosen
    best = 100 * min(PRESET_BOUNDS.values())
    raise InputError(f"accuracy is {accuracy:g}; no preset promises less than {best:g} %")
