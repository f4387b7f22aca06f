"""Presets of numerical settings (`tribo.Fidelity`), and the error of their critical velocities."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import replace

from pipeline.constants import (
    BOUNDS_OF_HIGHEST,
    BOUNDS_OF_MOST,
    HIGHEST_SHARE,
    MOST_SHARE,
    PRESET_BOUNDS,
)
from pipeline.sweep.sweep import Sweep
from tribo import PRESETS, Fidelity, Scene


def presets_for(scene: Scene, names: Iterable[str]) -> dict[str, Fidelity]:
    """Presets by name; their elements are small enough to tile the scene's grid of pixels."""
    return {name: with_dividing_elements(scene, PRESETS[name]) for name in names}


def with_dividing_elements(scene: Scene, fidelity: Fidelity) -> Fidelity:
    """Return `fidelity` with elements small enough to tile the scene's grid of pixels.

    An element is a block of n × n pixels. Its n is lowered until n divides the numbers of pixels
    along x and along y.
    """
    nx, ny = scene.pixels.shape
    divisors = (n for n in range(fidelity.pixels_per_element, 0, -1) if nx % n == ny % n == 0)
    return replace(fidelity, pixels_per_element=next(divisors))


def preset_of(scene: Scene) -> str | None:
    """Name of the preset that a scene has, adapted to it; None for custom settings."""
    adapted = presets_for(scene, PRESET_BOUNDS).items()
    return next((name for name, fidelity in adapted if fidelity == scene.fidelity), None)


def velocity_error(sweep: Sweep) -> float | None:
    """Bound of the relative error of a sweep's critical velocity; None if unknown.

    It is known only for presets, adapted to the scene.
    """
    return preset_bound(str(_preset(sweep)), sweep.conditions.critical_area_fraction)


def preset_bound(preset: str, share: float) -> float | None:
    """Bound of the relative error of critical velocities with a preset; None without a preset.

    `share` is the critical area fraction.
    """
    bounds = dict[str, float]()
    if share < HIGHEST_SHARE:
        bounds = BOUNDS_OF_HIGHEST
    elif share >= MOST_SHARE:
        bounds = BOUNDS_OF_MOST
    return bounds.get(preset, PRESET_BOUNDS.get(preset))


def has_unknown_error(sweep: Sweep) -> bool:
    """True if a sweep has a boundary of severe wear, but no preset whose error is known."""
    is_judged = sweep.conditions.friction > 0 and sweep.base.is_judged
    return is_judged and any(sweep.velocities) and velocity_error(sweep) is None


def error_in_words(sweep: Sweep) -> str:
    """Describe the discretization error of a sweep."""
    error = velocity_error(sweep)
    if error is None:
        return "custom numerical settings: the error of critical velocities is unknown"
    return (
        f"preset {_preset(sweep)}: discretization error at most {100 * error:g} % of critical "
        "velocities, more where the rise hardly grows with velocity (irg help choosing)"
    )


def _preset(sweep: Sweep) -> str | None:
    """Name of the preset of a sweep; None for custom numerical settings."""
    return sweep.preset or preset_of(sweep.scene)
