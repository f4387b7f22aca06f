"""One point of a scene, at a load and a velocity as a user gives them."""

from __future__ import annotations

from collections.abc import Callable

from pipeline.scene.quantities import in_si
from pipeline.scene.scenefile import SceneLike, sweep_of
from pipeline.sweep import plan


def run_point(
    sweep: SceneLike,
    load: float | str,
    velocity: float | str,
    realization: int | None = None,
    sample: int | None = None,
    trunk: plan.Trunk | None = None,
    progress: Callable[[int, int], None] | None = None,
    own_laws: bool = False,
) -> plan.PointResult:
    """Simulate one point.

    Parameters
    ----------
    sweep : Sweep, str or path
        The scene, or its path.
    load : float or str
        Normal load on the whole pin at the end of the ramp [N], or text with a unit, such as
        ``"600 N"``.
    velocity : float or str
        Sliding velocity [m/s], or text with a unit.
    realization : int, optional
        Seed of the random surface in place of the sweep's own.
    sample : int, optional
        Number of the sample whose inputs stand in place of the sweep's own.
    trunk : Trunk, optional
        Trunk of a lower load at the same velocity on the same surface, to continue; the start of
        the ramp if not given. The result is the same.
    progress : callable, optional
        Called after each step with how many of the point's steps are done, and how many there are.
    own_laws : bool
        See `pipeline.load_scene`.

    Raises
    ------
    TriboError
        If text is not a load or a velocity, and what `tribo.simulate` raises.

    Examples
    --------
    >>> import pipeline
    >>> scene = pipeline.load_scene("workflows/first_try.toml")
    >>> point = pipeline.run_point(scene, "600 N", "1.5 m/s")
    >>> verdict = point.verdict(scene.conditions)
    >>> verdict.is_severe, f"{verdict.max_temperature - 273.15:.0f} °C"
    (False, '158 °C')
    """
    place = in_si("load", load, "600 N"), in_si("velocity", velocity, "1.5 m/s")
    named = {"realization": realization, "variant": sample}
    variant = tuple((name, value) for name, value in named.items() if value is not None)
    return plan.run_point(sweep_of(sweep, own_laws), *place, variant, trunk, progress)
