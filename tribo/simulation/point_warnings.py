"""Warnings about the result of a point: their kinds, and the rules that find them."""

from __future__ import annotations

from collections.abc import Iterator
from enum import IntFlag
from typing import NamedTuple

import numpy as np

from tribo.constants import (
    FEW_ELEMENTS,
    FEW_PIXELS,
    FEW_SWEPT,
    FEW_WORN,
    FEWEST_ACROSS,
    FEWEST_PIXELS,
    FEWEST_ROWS,
    FEWEST_TURNS,
    HEAVY_WEAR,
    HOT_END,
    LEAST_SUMMIT,
    MAX_ELAPSED_HEAT_ERROR,
    SLOWEST,
    WIDEST,
)
from tribo.errors import require_instance
from tribo.material import contact_modulus
from tribo.simulation.cache import elastic_bodies
from tribo.simulation.conditions import Conditions
from tribo.simulation.elapsed_heat import elapsed_heat_excess
from tribo.simulation.element_size import summit_width
from tribo.simulation.pin_ends import end_length, end_rise_ratio
from tribo.simulation.pins import Ball
from tribo.simulation.scene import Scene
from tribo.simulation.state import State, touching_elements
from tribo.simulation.usual_values import unusual_values
from tribo.surface import SelfAffineRoughness, average_roughness
from tribo.thermal.quantiles import rise_exceeded
from tribo.types import Array

SLOW = (
    "the rise grows more slowly than velocity^0.3, so the error of the critical velocity is "
    "two to three times that of the preset; use --accuracy"
)


class WarningKind(IntFlag):
    """Kinds of warnings; each is a bit, so that one number holds all kinds of a point.

    Attributes
    ----------
    UNUSUAL_VALUE
        A value is outside its usual range. Found by `warnings` and `judge`; a scene of ``pipeline``
        has this warning when it is read.
    CONTACT_AT_EDGE
        The contact reaches an edge of the window.
    FEW_NODES
        Few elements touch, so that the temperature is uncertain.
    FEW_STEPS
        Too few steps lead to the load to resolve the shape of the wear.
    PRESENT_HEAT
        Assuming that the present heat flux acted from the start overestimates the rise by 1 % or
        more (safe side).
    COARSE_PIXELS
        Elements are too large for the contact or its summits, or pixels for the roughness.
    BEYOND_SHAPE
        The contact is too wide, or the wear too deep, for a pin taken as a parabola.
    FEW_TURNS
        A rolling pin turns fewer than 10 times, or stands still at this velocity although it turns
        at other velocities.
    SLOW_RISE
        The rise hardly grows with velocity. Found from neighbouring points of a sweep; for a worn
        ball at a single point, too.
    HOT_ENDS
        An end of a pin that is computed with its ends is clearly hotter than the whole pin.

    Examples
    --------
    >>> [kind.label for kind in WarningKind(6)]
    ['contact at edge', 'few nodes']
    """

    UNUSUAL_VALUE = 1
    CONTACT_AT_EDGE = 2
    FEW_NODES = 4
    FEW_STEPS = 8
    PRESENT_HEAT = 16
    COARSE_PIXELS = 32
    BEYOND_SHAPE = 64
    FEW_TURNS = 128
    SLOW_RISE = 256
    HOT_ENDS = 512

    @property
    def label(self) -> str:
        """The kind in words."""
        return (self.name or "").lower().replace("_", " ")


Reason = tuple[WarningKind, str]


class PointWarning(NamedTuple):
    """Reason for caution about the result of a point.

    Attributes
    ----------
    kind : WarningKind
        Kind of the reason.
    text : str
        Fault, its size, and a remedy.

    Examples
    --------
    >>> import tribo
    >>> PointWarning(tribo.WarningKind.CONTACT_AT_EDGE, "give a wider window").kind.label
    'contact at edge'
    """

    kind: WarningKind
    text: str

    def __str__(self) -> str:
        return self.text


def warnings(
    scene: Scene, state: State, conditions: Conditions | None = None
) -> list[PointWarning]:
    """Reasons for caution about a state, its scene, and the conditions that judge it.

    They are values outside their usual range, such as a number in GPa instead of Pa, and limits of
    the model or of the numerical choices, such as a contact that reaches an edge of the window.

    Examples
    --------
    >>> import tribo
    >>> *_, state = tribo.simulate(scene, normal_load=10.0, velocity=0.065)
    >>> [warning.kind.label for warning in tribo.warnings(scene, state)]
    []
    >>> celsius = tribo.Conditions(0.1, bulk_temperature=25.0)
    >>> print(*tribo.warnings(scene, state, celsius))  # doctest: +NORMALIZE_WHITESPACE
    conditions.bulk_temperature: 25 K is unusual (-50 to 250 °C is common): convert the number to
    SI, if it is in °C
    """
    require_instance(Scene, scene=scene)
    require_instance(State, state=state)
    if conditions is not None:
        require_instance(Conditions, conditions=conditions)
    texts = unusual_values(scene, state.normal_load, state.speed, conditions, state.time)
    unusual = [PointWarning(WarningKind.UNUSUAL_VALUE, text) for text in texts]
    return [*unusual, *point_warnings(scene, state)]


@np.errstate(under="ignore")
def point_warnings(scene: Scene, state: State) -> list[PointWarning]:
    """Reasons for caution about the result of a state, other than unusual values."""
    rules = (
        _warn_few_steps,
        _warn_edge,
        _warn_few_elements,
        _warn_present_heat,
        _warn_coarse_pixels,
        _warn_shape,
        _warn_few_turns,
        _warn_slow_rise,
        _warn_hot_ends,
    )
    return [PointWarning(*reason) for rule in rules for reason in rule(scene, state)]


def _warn_edge(scene: Scene, state: State) -> Iterator[Reason]:
    """Warn if the contact reaches an edge of the window, so that the window is too narrow."""
    if edges := touched_edges(scene, state):
        yield (
            WarningKind.CONTACT_AT_EDGE,
            f"the contact reaches the {' and '.join(edges)} of the window at "
            f"{state.normal_load:g} N; a wider window would carry load there as well",
        )


def touched_edges(scene: Scene, state: State) -> list[str]:
    """Edges of the window that the contact reaches, such as "x edge"; not the ends of the pin."""
    axes = ("x", "y") if scene.pin.length is None else ("x",)
    return [
        f"{name} edge"
        for axis, name in enumerate(axes)
        if np.take(state.pressure, (0, -1), axis=axis).any()
    ]


def _warn_coarse_pixels(scene: Scene, state: State) -> Iterator[Reason]:
    """Warn if elements are too large for the contact, or pixels too large for the roughness."""
    axes = (0, 1) if scene.pin.length is None else (0,)
    fewest = FEWEST_ROWS if len(axes) == 1 else FEWEST_ACROSS
    min_extent = min(_extent(state.pressure, axis) for axis in axes)
    if 0 < min_extent < fewest:
        smaller = "pixels" if elements_are_pixels(scene, state) else "elements"
        yield (
            WarningKind.COARSE_PIXELS,
            f"the contact is only {min_extent} elements wide at {state.normal_load:g} N; with "
            f"fewer than {fewest} the rise is usually 5 to 70 % too low, whatever the preset: use "
            f"smaller {smaller}",
        )
    block = scene.pixels.shape[0] // len(state.pressure)
    summit_elements = summit_width(scene) / block
    if block > 1 and summit_elements < LEAST_SUMMIT and not scene.sweeps_over:
        yield (
            WarningKind.COARSE_PIXELS,
            f"contacting summits are {summit_elements:.2g} elements wide; below {LEAST_SUMMIT:g} "
            "the rise is up to 16 % too low: set pixels_per_element = 1, or use a preset",
        )
    if isinstance(scene.roughness, SelfAffineRoughness):
        lengths = zip("xy", scene.roughness.correlation_length, scene.pixels.spacing, strict=True)
        short_lengths = [
            f"{length / size:.2g} pixels along {name}"
            for name, length, size in lengths
            if length < FEWEST_PIXELS * size * (1 - 1e-9)
        ]
        if short_lengths:
            yield (
                WarningKind.COARSE_PIXELS,
                f"the correlation length of the roughness is {' and '.join(short_lengths)}; below "
                f"{FEWEST_PIXELS:g} pixels the slopes depend on the pixel size: use smaller "
                "pixels or a longer correlation length",
            )


def _warn_shape(scene: Scene, state: State) -> Iterator[Reason]:
    """Warn if the contact is too wide, or the wear too deep, for a parabola on a half-space."""
    radius, depth = scene.pin.radius, float(state.wear_depth.max())
    width = _extent(state.pressure, 0) / len(state.pressure) * scene.grid.size[0]
    if width > 2 * WIDEST * radius:
        size = f"the contact is {1e3 * width:.3g} mm wide"
    elif depth > WIDEST**2 / 2 * radius:
        size = f"the pin is worn {1e3 * depth:.3g} mm deep"
    else:
        return
    yield (
        WarningKind.BEYOND_SHAPE,
        f"{size} at {state.normal_load:g} N, with a pin radius of {1e3 * radius:.3g} mm; the "
        f"model allows a width of {2 * WIDEST:g} radii and a depth of {WIDEST**2 / 2:.2g} radii "
        "at most: check specific_wear_rate and the load, or shorten the test",
    )


def _warn_few_turns(scene: Scene, state: State) -> Iterator[Reason]:
    """Warn if a rolling pin turns only a few times."""
    if not scene.motion or not scene.wears or not state.sliding_distance:
        return
    pin_speed = abs(scene.velocities_at(state.speed).pin)
    turns = pin_speed * state.time / scene.track_length
    if 0 < turns < FEWEST_TURNS:
        yield (
            WarningKind.FEW_TURNS,
            f"the pin makes only {turns:.2g} revolutions, while its wear is assumed even around "
            f"its circumference; at least {FEWEST_TURNS} are needed: leave such velocities out, or "
            "choose a motion in which the pin rotates faster or not at all",
        )


def _warn_slow_rise(scene: Scene, state: State) -> Iterator[Reason]:
    """Warn if a worn ball's rise grows more slowly than velocity to the power of `SLOWEST`."""
    if not isinstance(scene.pin, Ball) or scene.motion or not state.sliding_distance:
        return
    volume = float(state.wear_depth.mean()) * scene.nominal_area
    if not volume or state.pressure[[0, -1]].any():
        return
    velocity = state.speed
    radius = _extent(state.pressure, 0) / len(state.pressure) * scene.grid.size[0] / 2
    modulus = contact_modulus(scene.pin.material, scene.disk)
    unworn = scene.pin.hertz(state.normal_load, modulus).half_width
    worn = 4 * scene.pin.radius * volume / np.pi
    # rise ∝ flux a/√(4/π + Pe) (Tian & Kennedy 1994), with a ∝ the fourth root of the worn
    # volume: within 0.09 of the exponent at 96 simulated points.
    widening = worn / (worn + unworn**4) / 4  # d ln(a)/d ln(V)
    peclet = velocity * radius / (2 * scene.disk.thermal_diffusivity)
    peclet_root = np.sqrt(4 / np.pi + peclet)
    conductivities = scene.pin.material.thermal_conductivity, scene.disk.thermal_conductivity
    conductance = conductivities[0] * np.sqrt(4 / np.pi) + conductivities[1] * peclet_root
    cooling = conductivities[1] * peclet / (2 * peclet_root * conductance)
    if 1 - widening - (1 + widening) * cooling < SLOWEST:
        yield WarningKind.SLOW_RISE, SLOW


def _warn_hot_ends(scene: Scene, state: State) -> Iterator[Reason]:
    """Warn if wear would become severe at an end of the pin before it does on the whole pin."""
    excess = float(rise_exceeded(end_rise_ratio(scene, state), 0.1)) - 1
    if excess > HOT_END:
        yield (
            WarningKind.HOT_ENDS,
            f"on the hottest tenth of its contact, an end of {1e3 * end_length(scene):.2g} mm of "
            f"the pin has a rise {100 * excess:.0f} % above that of the whole pin, by which the "
            "verdict is given; wear becomes severe there first: relieve the ends, or let them wear",
        )


def _warn_few_elements(scene: Scene, state: State) -> Iterator[Reason]:
    """Warn if so few elements touch that the temperature of the contact is uncertain."""
    are_pixels, is_worn = elements_are_pixels(scene, state), _is_heavily_worn(scene, state)
    min_count = FEW_ELEMENTS
    if is_worn:
        min_count = FEW_WORN
    elif are_pixels:
        passes_rim = scene.sweeps_over and scene.pin.length is None
        min_count = FEW_SWEPT if passes_rim else FEW_PIXELS
    elif scene.fidelity.fewest_elements:  # the largest that the surface allows
        min_count //= (scene.pixels.shape[0] // len(state.pressure)) ** 2
    if not 0 < touching_elements(scene, state) < min_count or (are_pixels and not scene.roughness):
        return
    text = f"only {np.count_nonzero(state.pressure)} elements touch at {state.normal_load:g} N; "
    if are_pixels or is_worn:
        smaller = "smaller pixels" if are_pixels else "pixels_per_element = 1"
        text += (
            "the governing temperature is that of the hottest few and varies by several percent "
            "between surface realizations and with element size: simulate several realizations, "
            f"or use a larger window or {smaller}"
        )
    else:
        text += (
            "with so few, critical velocities of random scenes were off by 0.4 to 100 % (median "
            "10 %); use a preset, or pixels_per_element = 1"
        )
    yield WarningKind.FEW_NODES, text


def _is_heavily_worn(scene: Scene, state: State) -> bool:
    """True under a ball if wear averaged over positions is much deeper than the roughness."""
    heights = elastic_bodies(scene).heights
    if not scene.sweeps_over or scene.pin.length is not None or heights is None:
        return False
    return bool(state.wear_depth.max() > HEAVY_WEAR * average_roughness(heights))


def elements_are_pixels(scene: Scene, state: State) -> bool:
    """True if the elements of a state are as small along x as the pixels of the disk's surface."""
    return len(state.pressure) == scene.pixels.shape[0]


def _extent(pressure: Array, axis: int) -> int:
    """Number of elements from the first to the last in contact along an axis."""
    touching_rows = np.flatnonzero(pressure.any(axis=1 - axis))
    return int(np.ptp(touching_rows)) + 1 if touching_rows.size else 0


def _warn_few_steps(scene: Scene, state: State) -> Iterator[Reason]:
    """Warn if a single step leads to this state; from two on the rise is right to about 10 %."""
    if not scene.wears or state.index != 1:
        return
    yield (
        WarningKind.FEW_STEPS,
        f"{state.normal_load:g} N is reached in a single step, too few to resolve the worn shape; "
        "increase increments so that at least 2 steps lead to this load",
    )


def _warn_present_heat(scene: Scene, state: State) -> Iterator[Reason]:
    """Warn if the rise is too high, since there was less friction heat before the present."""
    excess = elapsed_heat_excess(scene, state)
    if excess < MAX_ELAPSED_HEAT_ERROR:
        return
    yield (
        WarningKind.PRESENT_HEAT,
        "treating the present friction heat as if it had acted since the start overestimates "
        f"the rise by about {100 * excess:.1f} %; the critical velocity is then too low, mostly "
        "by one to two times as much, which is on the safe side",
    )
