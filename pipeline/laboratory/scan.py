"""Roughness of a measured surface by ISO 25178, and random surfaces similar to it."""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Any

import numpy as np

from pipeline.laboratory.likeness import (
    NEAR,
    Likenesses,
    compare,
    length_text,
    likeness_entries,
    likeness_lines,
    nearly_equal,
    roughness_toml,
)
from pipeline.laboratory.spectrum import SelfAffineFit, fit_self_affine
from pipeline.laboratory.surfaces import axis_note, form_words, oriented, read_surface
from pipeline.quantities import display, display_sides
from pipeline.units import in_si
from tribo import Grid, InputError
from tribo.surface import self_affine
from tribo.surface.areal import ArealRoughness, areal_roughness, remove_form
from tribo.types import Array

_ASKEW = 0.5  # skewness above which a random surface is a poor substitute
_FLATTEST, _ROUGHEST = 1e-10, 1e-4  # plausible range of Rq [m]
_FINEST, _COARSEST = 1e-9, 1e-3  # plausible range of pixel sides [m]
_HIGHEST = 1.0  # height [m] above which the unit must be wrong
_COMPARED = {"Rq": "rq", "Sal": "sal", "Str": "aspect"}


@dataclass(frozen=True, slots=True)
class SurfaceStatistics:
    """Roughness of a scan, after removal of its form, from measured heights only."""

    file: str  #: File of the scan.
    shape: tuple[int, int]  #: Numbers of heights along x and y.
    pixel_size: tuple[float, float]  #: Sides of a pixel along x and y [m].
    missing: int  #: Number of heights that the instrument did not measure; they are left out.
    roughness: ArealRoughness  #: Ra, Rq, Sal, Str, lay and form.
    fit: SelfAffineFit | None = None  #: Best fit of a self-affine spectrum.
    fault_of_fit: str = ""  #: Why random surfaces cannot replace the scan; empty if they can.
    likeness: Likenesses = ()  #: Scan against random surfaces, by quantity.
    axis: str = ""  #: Direction of sliding in the file, in words.
    notes: tuple[str, ...] = ()  #: Notes on holes, and on arguments that override the file.

    @property
    def ra(self) -> float:
        """Average roughness Ra [m]."""
        return self.roughness.ra

    @property
    def rq(self) -> float:
        """Root mean square roughness Rq [m]."""
        return self.roughness.rq

    @property
    def is_like(self) -> bool:
        """True if random surfaces with the fitted spectrum may be simulated instead of the scan.

        Their spectrum, Rq, Sal and Str must be close to those of the scan.
        """
        return not self.fault_of_fit

    @property
    def toml(self) -> str:
        """Table ``[disk.roughness]`` of a scene, as text, for random surfaces like the scan.

        The text is empty if random surfaces cannot replace the scan.
        """
        if self.fit is None or not self.is_like:
            return ""
        return roughness_toml(self.ra, self.fit.hurst_exponent, self.fit.correlation_length)

    @property
    def warnings(self) -> tuple[str, ...]:
        """Reasons why the numbers, or random surfaces, may differ from the scan."""
        return tuple(self._warnings())

    def _warnings(self) -> Iterator[str]:
        rough, sal = self.roughness, self.roughness.sal
        yield from self.notes
        if not _FLATTEST <= self.rq <= _ROUGHEST:
            rq = display(self.rq, "µm", 3)
            yield f"Rq is {rq}: check the unit of the heights (--height-unit)"
        if not _FINEST <= min(self.pixel_size) <= max(self.pixel_size) <= _COARSEST:
            yield "check the size of the pixels (--pixel-size)"
        if sal < min(self.pixel_size):
            yield "neighbouring heights are hardly correlated: noise, or too coarse pixels"
        if self.missing:
            share = 100 * self.missing / math.prod(self.shape)
            yield f"{self.missing} heights ({share:.2g} %) are missing and left out"
        if abs(rough.skewness) > _ASKEW:
            yield (
                f"skewness {rough.skewness:.2g}: a random surface has 0; simulate the scan itself: "
                f'disk.roughness.file = "{self.file}"'
            )
        widest = max((one.scatter for _, one in self.likeness), default=0.0)
        if widest > NEAR:
            sides = np.multiply(self.shape, self.pixel_size)
            many = widest / NEAR * min(sides) / sal
            yield (
                f"single surfaces of this size differ by {100 * widest:.0f} %: measure at least "
                f"{many:.2g} correlation lengths (of {display(sal, 'µm', 3)}) along each side"
            )

    def as_dict(self) -> dict[str, Any]:
        """All statistics as plain data, with the scene table as text."""
        rough = self.roughness
        return asdict(self) | {
            "roughness": asdict(rough) | {"str": rough.aspect},
            "likeness": likeness_entries(self.likeness),
            "toml": self.toml or None,
            "warnings": list(self.warnings),
        }  # fmt: skip

    def lines(self) -> Iterator[str]:
        """Yield lines that describe the scan, then scene lines for similar random surfaces."""
        sides = (n * side for n, side in zip(self.shape, self.pixel_size, strict=True))
        yield (
            f"{self.file}: {self.shape[0]} × {self.shape[1]} heights, {display_sides(sides)}, "
            f"pixels {display_sides(self.pixel_size)}"
        )
        yield f"  {self.axis}"
        yield from (f"  {name:20}{value}" for name, value in self._quantities())
        yield from (f"  {'warning':20}{warning}" for warning in self.warnings)
        yield ""
        if self.is_like:
            yield from ["random surfaces like it, in a scene:", "", *self.toml.splitlines()]
        else:
            yield f"no random surface is like it ({self.fault_of_fit}): use the scan itself"

    def _quantities(self) -> Iterator[tuple[str, str]]:
        """Yield pairs (name, value) of the scan's quantities, as text."""
        rough, curved = self.roughness, form_words(self.roughness.radii)
        yield "Ra", display(self.ra, "µm", 4)
        yield "Rq", display(self.rq, "µm", 4)
        yield "skewness, kurtosis", f"{rough.skewness:.2g}, {rough.kurtosis:.2g}"
        tilt = np.degrees(np.arctan(rough.slopes))
        yield "tilt", "{:.2g}° along x, {:.2g}° along y, removed".format(*tilt)
        if curved:
            yield "curvature", f"R {curved}, removed; give a pin's radius as pin.radius"
        yield "lay", "none" if rough.lay is None else f"{rough.lay:.0f}° from x"
        yield (
            "Sal, Str",
            f"{length_text(rough.sal)}, {rough.aspect:.2g} (ISO 25178, at 1/e for 0.2)",
        )
        yield from likeness_lines(self.likeness, "scan")

    def __str__(self) -> str:
        return "\n".join(self.lines())


@np.errstate(under="ignore")
def surface_statistics(
    path: str | Path,
    height_unit: float | str | None = None,
    pixel_size: Sequence[float | str] | None = None,
    transpose: bool = False,
) -> SurfaceStatistics:
    """Measure the roughness of a scan by ISO 25178, and fit the spectrum of random surfaces to it.

    Parameters
    ----------
    path : str or Path
        Plain array (.npy), text, or an instrument's file, which may need the optional packages
        ``surfaces``.
    height_unit : float or str, optional
        Unit of the heights, such as ``"um"``, or its length in m. It replaces the unit of the
        file.
    pixel_size : two of float or str, optional
        Sides of a pixel along x and y after any transposition, as numbers in m or text with a
        unit. They replace the sizes in the file.
    transpose : bool
        Exchange x and y of the file.

    Returns
    -------
    SurfaceStatistics
        Roughness of the scan, the fit, and whether random surfaces with the fitted spectrum can
        replace the scan. If they can, ``toml`` has their entries for a scene.

    Raises
    ------
    InputError
        If the file cannot be read, is a profile, or lacks a unit or the size of its pixels.

    Notes
    -----
    The mean plane is removed, and a significant curvature. Holes are left out. If the scan's
    spectrum is within a factor of 5 of the fit, eight random surfaces are made with the fitted
    spectrum in the window of the scan. They are like the scan if its Rq, Sal and Str are within
    15 %, or twice the scatter, of the means over these surfaces.

    Examples
    --------
    >>> import numpy as np
    >>> from pipeline import surface_statistics
    >>> from tribo import Grid
    >>> from tribo.surface import self_affine
    >>> heights = self_affine(Grid((256, 256), (1e-6, 1e-6)), 0.3e-6, 0.8, (4e-6, 4e-6), seed=0)
    >>> np.save("results/scan.npy", heights * 1e6)
    >>> print(surface_statistics("results/scan.npy", "um", ("1 um", "1 um")).toml)
    [disk.roughness]
    ra = "0.299 um"
    hurst_exponent = 0.876
    correlation_length = "3.25 um"
    <BLANKLINE>
    """
    unit = height_unit
    if isinstance(unit, str):
        unit = in_si("height_unit", unit if unit[:1].isdigit() else f"1 {unit}", "1 um")
    surface = oriented(read_surface(path, unit), transpose)
    if pixel_size is not None:
        x, y = (in_si("pixel_size", side, "1 um") for side in pixel_size)
        surface = surface.replace_pixels((x, y))
    if surface.pixel_size is None or min(surface.pixel_size) <= 0:
        raise InputError(f"{path}: no size of a pixel; give pixel_size, such as 0.8 um")
    heights, sides = surface.heights, surface.pixel_size
    highest = np.abs(heights[np.isfinite(heights)]).max(initial=0.0)
    if highest > _HIGHEST:
        raise InputError(f"{path}: heights of {highest:.3g} m; give the unit, height_unit")
    try:
        rough = areal_roughness(heights, sides)
        compared = _compare(heights, sides, rough)
    except InputError as error:
        raise InputError(f"{path}: {error}") from error
    shape, missing = (heights.shape[0], heights.shape[1]), int(np.isnan(heights).sum())
    note = axis_note(transpose)
    return SurfaceStatistics(
        str(path), shape, sides, missing, rough, *compared, note, surface.notes
    )


def _compare(
    heights: Array, sides: tuple[float, float], rough: ArealRoughness
) -> tuple[SelfAffineFit | None, str, Likenesses]:
    """Fit of random surfaces to a scan, why it differs from them (or empty), what is compared."""
    level, *_ = remove_form(heights, sides)
    holes = ~np.isfinite(level)
    try:
        fit = fit_self_affine(np.where(holes, 0.0, level), sides)
    except InputError as error:
        return None, str(error), ()
    grid, lengths = Grid(level.shape, sides), nearly_equal(fit.correlation_length)

    def parameters(of: ArealRoughness) -> dict[str, float]:
        return {name: getattr(of, quantity) for name, quantity in _COMPARED.items()}

    def of_surface(seed: int) -> dict[str, float]:
        other = self_affine(grid, rough.ra, fit.hurst_exponent, lengths, seed=seed)
        return parameters(areal_roughness(np.where(holes, np.nan, other), sides))

    return fit, *compare(fit, parameters(rough), of_surface)
