"""Largest elements that the summits of a surface and their number in a contact allow.

Large elements falsify the temperature of summits that are one element wide, and of a contact of few
summits. Width and number are known before a contact is solved. The width of summits follows from
the heights, as the mean length of runs of pixels among the highest tenth. The area that touches
follows from the load F in closed form, F/p with the mean pressure of a rough contact

    p = min(H, E* h′/√(2π)),                                                              (1)

with the hardness H, the contact modulus E* and the root mean square slope h′ (Bush, Gibson &
Thomas, Wear 35, 1975, for light loads). The area is at most the nominal area after Hertz. If Eq.
(1) gives twice the nominal area, the contact is treated as that of smooth bodies. Steps before the
last act only through the wear, and so have larger elements if enough of these touch.

Where the contact is dense, wear moves pressure over the whole of it, and each step is cut into
parts: under smooth bodies, where Eq. (1) gives twice the nominal area, and under flat tops, such as
plateaus.

The elements of a point depend on no other point: loads that share a ramp use the elements for the
lowest of these loads.
"""

from __future__ import annotations

import math
from dataclasses import replace
from typing import NamedTuple

import numpy as np

from tribo.constants import (
    DENSE_PARTS,
    ELEMENTS_OF_HISTORY,
    ELEMENTS_PER_SUMMIT,
    FEWEST_ACROSS,
    FEWEST_ROWS,
    FLAT_TOP,
    FULL_SHARE,
    FULL_TOLERANCE_ELEMENTS,
    HISTORY_COARSENING,
    POSITION_SIZE_FACTOR,
    STEPS_TIMES_IMPRINT,
    SUMMIT_QUANTILE,
    SUMMITS_PER_ELEMENT,
    TIGHTEST_TOLERANCE,
)
from tribo.loading import MeasuredLoad, Stages
from tribo.material import contact_modulus
from tribo.simulation.cache import cached_heights, cached_summits
from tribo.simulation.disk_positions import position_count
from tribo.simulation.scene import Scene
from tribo.surface import rms_slope
from tribo.types import Mask


class Summits(NamedTuple):
    """Summits of a surface: mean widths along x and y, root mean square slope, and their tops."""

    widths: tuple[float, float]  # along x and y, in pixels
    slope: float  # root mean square
    are_flat: bool  # the highest pixel is little above the others


class _ExpectedContact(NamedTuple):
    """Size of a contact at the lowest load of a ramp, as estimated before it is solved.

    Lengths and areas are in pixels of the disk's height map.
    """

    across: float  # width of the smooth contact along x
    touching: float  # pixels; squared for a plane scene, as if y were divided like x
    is_smooth: bool  # all of the nominal area touches


SMOOTH = Summits((math.inf, math.inf), 0.0, are_flat=False)


def fit_elements(scene: Scene, normal_load: float) -> Scene:
    """Scene with elements small enough for its surface, at a load [N] and at all steps before.

    ``fewest_elements`` of the fidelity is the number of elements that touch. If few elements will
    touch, the contact tolerance and ``imprint`` are made smaller, too. The scene is returned
    unchanged if ``fewest_elements`` is 0.

    Examples
    --------
    Summits two pixels wide allow no larger elements, although the fidelity would:

    >>> import tribo
    >>> from dataclasses import replace
    >>> at_most = replace(scene.fidelity, pixels_per_element=2, fewest_elements=10)
    >>> narrow = tribo.SelfAffineRoughness(1e-7, 0.8, (2 * scene.pixels.spacing[0],) * 2, seed=0)
    >>> narrow_scene = replace(scene, fidelity=at_most, roughness=narrow)
    >>> fit_elements(narrow_scene, 10.0).fidelity.pixels_per_element
    1
    """
    fidelity = scene.fidelity
    if not fidelity.fewest_elements:
        return scene
    lowest, summits = _lowest_load(scene, normal_load), _cached_summits(scene)
    expected = _expected_contact(scene, summits, lowest)
    max_across = expected.across / (FEWEST_ROWS if scene.pin.length else FEWEST_ACROSS)
    # Elements along a long summit are equally warm, and count once per width of the summit.
    equivalent_count, widths = expected.touching, summits.widths
    max_size, fewest = max_across, fidelity.fewest_elements
    if not expected.is_smooth:
        equivalent_count *= min(widths) / max(widths)
        summit_count = expected.touching / math.prod(widths)
        max_width = summit_width(scene) / ELEMENTS_PER_SUMMIT
        if scene.sweeps_over:  # the temperature is (almost) a mean over positions
            summit_count, max_width = (
                summit_count * position_count(scene, lowest),
                POSITION_SIZE_FACTOR * max_width,
            )
        max_size = (
            min(max_across, max_width) if summit_count >= SUMMITS_PER_ELEMENT * fewest else 1.0
        )
    block = fidelity.pixels_per_element
    sizes = (
        n for n in range(block, 1, -1) if block % n == 0 and n * n * fewest <= equivalent_count
    )
    size = next((n for n in sizes if n <= max_size), 1)
    max_coarsening = (
        min(math.sqrt(equivalent_count / (ELEMENTS_OF_HISTORY * fewest)), max_across) / size
    )
    # Stages wear the pin so much that a coarser grid of earlier steps errs by up to 3.5 %.
    coarsening_limit = 1 if isinstance(scene.loading, Stages) else HISTORY_COARSENING
    parts = min(DENSE_PARTS, math.ceil(STEPS_TIMES_IMPRINT / fidelity.increments))
    parts = parts if expected.is_smooth or summits.are_flat else 1
    if scene.wears_by_strips:
        parts = max(parts, fidelity.parts)
    # With few elements, a loose tolerance or a long step must not miss any of them.
    share = min(1.0, expected.touching / size**2 / FULL_TOLERANCE_ELEMENTS)
    tolerance = fidelity.contact_tolerance
    fitted = replace(
        fidelity,
        pixels_per_element=size,
        history_coarsening=max(1, min(coarsening_limit, int(max_coarsening))),
        contact_tolerance=max(share * tolerance, min(tolerance, TIGHTEST_TOLERANCE)),
        imprint=share * STEPS_TIMES_IMPRINT / (fidelity.increments * parts),
        parts=parts,
    )
    return scene if fitted == fidelity else replace(scene, fidelity=fitted)


def summit_width(scene: Scene) -> float:
    """Width of the part of a summit that touches, along its narrower axis, in pixels.

    A yielding summit touches over its whole width, an elastic summit over half the width. The
    result is infinite for smooth bodies.
    """
    summits = _cached_summits(scene)
    modulus = contact_modulus(scene.pin.material, scene.disk)
    yields = modulus * summits.slope / (math.sqrt(2 * math.pi) * scene.hardness)
    return min(summits.widths) * min(max(yields, 0.5), 1.0)


def _lowest_load(scene: Scene, normal_load: float) -> float:
    """Lowest load [N] that shares its ramp with `normal_load` [N]; of stages the last load."""
    loading = scene.loading
    if isinstance(loading, Stages):
        return loading.loads[-1]
    return normal_load if isinstance(loading, MeasuredLoad) else loading.lowest(normal_load)


def _expected_contact(scene: Scene, summits: Summits, normal_load: float) -> _ExpectedContact:
    """Size and shape of the contact at a load [N] by Eq. (1), on the disk's `summits`."""
    modulus, pin = contact_modulus(scene.pin.material, scene.disk), scene.pin
    window_load = normal_load / pin.windows(scene.grid)
    hertz = pin.hertz(normal_load, modulus)
    nominal_area = window_load / (hertz.peak_pressure * (math.pi / 4 if pin.length else 2 / 3))
    slope = summits.slope or math.inf
    rough_area = window_load * max(1 / scene.hardness, math.sqrt(2 * math.pi) / (modulus * slope))
    is_smooth = summits is SMOOTH or rough_area >= FULL_SHARE * nominal_area
    rough_area = min(rough_area, nominal_area)
    pixels = (nominal_area if is_smooth else rough_area) / scene.pixels.element_area
    across = 2 * hertz.half_width / scene.pixels.spacing[0]
    return _ExpectedContact(across, pixels**2 if scene.is_plane else pixels, is_smooth)


def _cached_summits(scene: Scene) -> Summits:
    return cached_summits(scene, lambda: _summits(scene))


def _summits(scene: Scene) -> Summits:
    heights = cached_heights(scene)
    if heights is None:
        return SMOOTH
    level = np.quantile(heights, SUMMIT_QUANTILE)
    is_high = heights >= level
    widths = _run_length(is_high, 0), _run_length(is_high, 1)
    peak_height = heights.max() - level
    are_flat = bool(peak_height < FLAT_TOP * heights.std())
    return Summits(widths, rms_slope(heights, scene.pixels.spacing), are_flat)


def _run_length(is_high: Mask, axis: int) -> float:
    """Mean length of runs of high pixels along an axis, the width of summits [pixels]."""
    begins = is_high & ~np.roll(is_high, 1, axis)
    return float(np.count_nonzero(is_high)) / max(1, int(np.count_nonzero(begins)))
