"""Error to expect of a sweep's critical velocity, from its numerical choices."""

from __future__ import annotations

from pipeline.constants import BOUNDS_OF_HIGHEST, HIGHEST_SHARE, PRESET_BOUNDS
from pipeline.sweep.model import Sweep
from pipeline.sweep.selection import preset_of


def velocity_error(sweep: Sweep) -> float | None:
    """Largest relative error to expect of a sweep's critical velocity; None if unknown.

    It is known for presets of numerical choices alone, adapted to the scene.
    """
    preset, criterion = str(_preset(sweep)), sweep.conditions.criterion
    is_highest = criterion.name == "highest"
    if is_highest or (criterion.name == "share" and criterion.share < HIGHEST_SHARE):
        return BOUNDS_OF_HIGHEST.get(preset, PRESET_BOUNDS.get(preset))
    return PRESET_BOUNDS.get(preset)


def has_unknown_error(sweep: Sweep) -> bool:
    """True if a sweep has a boundary of severe wear whose error is not known.

    The error is known for a preset.
    """
    is_judged = sweep.conditions.friction > 0 and sweep.conditions.critical_temperature is not None
    return is_judged and any(sweep.velocities) and velocity_error(sweep) is None


def error_in_words(sweep: Sweep) -> str:
    """Describe the error of a sweep's critical velocity, and how the error is known."""
    error = velocity_error(sweep)
    if error is None:
        return (
            "own numerical choices: how far boundary velocities err is not known (irg trade SCENE)"
        )
    by = f"{100 * error:g} % (irg help choosing)"
    return f"preset {_preset(sweep)}: boundary velocities may be off by up to {by}"


def _preset(sweep: Sweep) -> str | None:
    """Name of the preset whose numbers a sweep has; None for numerical choices of one's own."""
    return sweep.preset or preset_of(sweep.scene)
