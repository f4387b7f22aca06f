"""How well a jackknife of one contact estimates how surface realizations differ.

The jackknife (`tribo.thermal.quantiles`) takes the groups of elements (`surface_groups`) for
independent samples of the surface. Grooves that run through several groups make these alike, and
then they differ less than realizations do. Hot spots are taken to be a random field with the
correlation

    K = max(ρ, 0)⁴,                                                                       (1)

where ρ is the autocorrelation of the disk's heights. It gives the covariance of the means over the
groups, and that of the means without each group. With the eigenvalues λ of the latter, about their
mean and times 7/8, the jackknife's variance is Σλ in the mean. It scatters like one with
(Σλ)²/Σλ² degrees of freedom (Satterthwaite, Biometrics Bull. 2, 1946).

A scan that is mirrored at its edges fills the window more than once. The hot spots of an element
and of its mirror images are the same, so that fewer groups are independent.
"""

from __future__ import annotations

import functools
import math
from dataclasses import replace

import numpy as np

from tribo.constants import (
    FREEDOM_OF_CELLS,
    FREEDOM_OF_LOCAL_WEAR,
    HOT_SPOT_POWER,
    LOCAL_WEAR_FACTOR,
    MAX_GROUP_FACTOR,
)
from tribo.simulation.scene import Scene
from tribo.simulation.surface_groups import surface_groups
from tribo.surface import SelfAffineRoughness, block_average, self_affine_amplitude
from tribo.thermal.quantiles import GROUPS, JackknifeQuality
from tribo.types import Array, Indices


def jackknife_quality(scene: Scene) -> JackknifeQuality:
    """Quality of the jackknife of one realization of a scene.

    There are no degrees of freedom if the groups hardly differ, because grooves run through them.
    Then one realization does not show how realizations differ.

    Examples
    --------
    Longer grooves along y, under a cylinder:

    >>> import tribo
    >>> window = tribo.Grid((96, 96), (4e-6, 4e-6), (False, True))
    >>> line = replace(scene, pin=tribo.Cylinder(2e-3, 3.4e-3, scene.disk), pixels=window)
    >>> for length in (10e-6, 40e-6, 80e-6, 400e-6):
    ...     ground = tribo.SelfAffineRoughness(0.27e-6, 0.8, (10e-6, length))
    ...     freedom, factor = jackknife_quality(replace(line, roughness=ground))
    ...     print(f"{1e6 * length:.0f} µm: {freedom:.1f} degrees, factor {factor:.2f}")
    10 µm: 7.0 degrees, factor 1.05
    40 µm: 6.4 degrees, factor 1.26
    80 µm: 4.7 degrees, factor 1.69
    400 µm: 0.0 degrees, factor 1.00
    """
    if scene.roughness is None:
        return JackknifeQuality()
    rough = scene.roughness
    if isinstance(rough, SelfAffineRoughness):  # all realizations have the same autocorrelation
        rough = replace(rough, ra=1.0, seed=0)
    quality = _quality_by_correlation(replace(scene, roughness=rough, wear=None, motion=None))
    if not quality.freedom:
        return quality
    if scene.wear is not None and scene.wear.pattern == "local":
        return JackknifeQuality(FREEDOM_OF_LOCAL_WEAR, LOCAL_WEAR_FACTOR * quality.factor)
    if not scene.grid.periodic[1]:
        return quality._replace(freedom=min(quality.freedom, FREEDOM_OF_CELLS))
    return quality


@functools.lru_cache(maxsize=32)  # called for each point of a sweep
def _quality_by_correlation(scene: Scene) -> JackknifeQuality:
    spots = np.maximum(_autocorrelation(scene), 0.0) ** HOT_SPOT_POWER
    groups = surface_groups(scene)
    if scene.grid.periodic[1]:  # strips, which cross the window along x
        spots, groups = spots.sum(axis=0, keepdims=True), groups[:1]
    masks = groups == np.arange(GROUPS)[:, None, None]
    modes = np.fft.fft2(_without_mirror_images(scene, masks)).reshape(GROUPS, -1)
    covariance = ((modes * np.fft.fft2(spots).ravel()) @ modes.conj().T).real  # of sums over groups
    sizes = masks.sum(axis=(1, 2))
    weights = (1 - np.eye(GROUPS)) / np.maximum(sizes.sum() - sizes, 1)[:, None]
    weights -= weights.mean(axis=0)  # of the means without each group, about their mean
    deviations = (GROUPS - 1) / GROUPS * weights @ covariance @ weights.T
    variance, estimate = covariance.sum() / sizes.sum() ** 2, float(np.trace(deviations))
    if not variance:  # a flat disk
        return JackknifeQuality()
    if estimate * MAX_GROUP_FACTOR**2 < variance:
        return JackknifeQuality(freedom=0.0)
    freedom = np.clip(estimate**2 / np.square(deviations).sum(), 1.0, GROUPS - 1.0)
    return JackknifeQuality(float(freedom), math.sqrt(variance / estimate))


def _without_mirror_images(scene: Scene, masks: Array) -> Array:
    """Numbers of each element's images in each group, (GROUPS, nx, ny), at the element itself."""
    if isinstance(scene.roughness, SelfAffineRoughness):
        return masks
    heights, block = np.asarray(scene.heights()), scene.fidelity.pixels_per_element
    for axis, size in enumerate(masks.shape[1:]):
        if size > 1:  # strips have one element along x
            images = _mirrored_positions(heights.swapaxes(0, axis))
            elements = images[block // 2 :: block][:size] // block
            counts = np.zeros(masks.shape)
            np.add.at(counts.swapaxes(0, 1 + axis), elements, masks.swapaxes(0, 1 + axis))
            masks = counts
    return masks


def _mirrored_positions(heights: Array) -> Indices:
    """Position along the first axis whose heights each position repeats; itself if unmirrored."""
    positions = np.arange(len(heights))
    is_edge = (heights[1:] == heights[:-1]).all(axis=1)  # of a scan that is mirrored there
    for edge in (np.flatnonzero(is_edge) + 1).tolist():
        images: Indices = np.pad(positions[:edge], (0, len(heights) - edge), "symmetric")
        if (heights[images] == heights).all():
            return images
    return positions


def _autocorrelation(scene: Scene) -> Array:
    """Autocorrelation of the heights at each lag in elements, on a surface that repeats itself."""
    grid, rough = scene.grid, scene.roughness
    if isinstance(rough, SelfAffineRoughness):
        half = self_affine_amplitude(grid, rough.hurst_exponent, rough.correlation_length)
        amplitude = np.concatenate([half, half[1 : (grid.shape[0] + 1) // 2][::-1]])
    else:
        heights = block_average(np.asarray(scene.heights()), scene.fidelity.pixels_per_element)
        amplitude = np.abs(np.fft.rfft2(heights - heights.mean()))
    covariance: Array = np.fft.irfft2(amplitude**2, grid.shape)
    covariance /= covariance[0, 0] if covariance[0, 0] > 0 else 1.0
    return covariance
