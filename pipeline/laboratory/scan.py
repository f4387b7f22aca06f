"""Statistics of a measured surface, and the random roughness that is like it."""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Any

import numpy as np

from pipeline.laboratory.surfaces import (
    Flip,
    MeasuredSurface,
    axis_note,
    filled,
    levelled,
    oriented,
    read_surface,
    tilt_doubts,
    tilts,
)
from pipeline.quantities import display, display_sides, shown_in
from pipeline.scene.units import in_si
from pipeline.sweep.shown import shown
from tribo import InputError
from tribo.surface import (
    AutocorrelationLengths,
    SelfAffineFit,
    autocorrelation_lengths,
    average_roughness,
    fit_self_affine,
    rms_height,
)
from tribo.types import Array

_ASKEW = 0.5  # skewness beyond which a random surface is a poor likeness
_UNLIKE = 5  # factor between spectra, beyond which a fit stands for no scan
_SHORT = 10.0  # correlation lengths along a side, below which few of them are seen
_LAY = 0.5  # Str of ISO 25178, below which a surface has a lay
_FLATTEST, _ROUGHEST = 1e-10, 1e-4  # Rq [m], beyond which the unit of heights is doubted
_FINEST, _COARSEST = 1e-9, 1e-3  # sides of a pixel [m], beyond which their unit is doubted
_HIGHEST = 1.0  # height [m], above which the unit is wrong
_ROUNDING = 1e-9  # share of the heights below which what is left above their plane is rounding
_DEGREES = 10.0  # angle of a lay to an axis beyond which the fit along the axes is another surface


@shown
@dataclass(frozen=True, slots=True)
class SurfaceStatistics:
    """Roughness of a scan, above its least-squares plane."""

    file: str  #: File of the scan.
    shape: tuple[int, int]  #: Numbers of heights along x and y.
    pixel_size: tuple[float, float]  #: Sides of a pixel along x and y [m].
    missing: int  #: Heights that the instrument has not, filled smoothly from around them.
    ra: float  #: Average roughness [m].
    rq: float  #: Root mean square roughness [m].
    skewness: float  #: Of the heights; 0 on a random surface.
    kurtosis: float  #: Of the heights; 3 on a random surface.
    tilt: tuple[float, float]  #: Of the plane along x and y that was taken off [°].
    fit: SelfAffineFit  #: Correlation lengths, Hurst exponent and lay, with standard errors.
    lengths: AutocorrelationLengths  #: Where the autocorrelation has fallen to 1/e.
    axis: str = ""  #: Direction of sliding in the file.
    notes: tuple[str, ...] = ()  #: What the file says, and the arguments say otherwise.

    @property
    def has_lay(self) -> bool:
        """True if the correlation lengths differ by more than three standard errors.

        Where the fit failed, the autocorrelation tells.
        """
        if not self.is_self_affine:
            return self.lengths.shortest < _LAY * self.lengths.longest
        (x, y), (error_x, error_y) = self.fit.correlation_length, self.fit.length_error
        return bool(abs(np.log(x / y)) > 3 * np.hypot(error_x / x, error_y / y))

    @property
    def toml(self) -> str:
        """Table ``[disk.roughness]`` of a scene, whose surfaces have these statistics."""
        x, y = (f'"{display(length, "um", 3)}"' for length in self.fit.correlation_length)
        mean = f'"{display(float(np.sqrt(np.prod(self.fit.correlation_length))), "um", 3)}"'
        return (
            "[disk.roughness]\n"
            f'ra = "{display(self.ra, "um", 4)}"\n'
            f"hurst_exponent = {self.fit.hurst_exponent:.3g}\n"
            f"correlation_length = {f'[{x}, {y}]' if self.has_lay else mean}\n"
        )

    @property
    def warnings(self) -> tuple[str, ...]:
        """Reasons why a random surface may differ from the scan."""
        return tuple(self._warnings())

    def _warnings(self) -> Iterator[str]:
        yield from self.notes
        if not _FLATTEST <= self.rq <= _ROUGHEST:
            rq = display(self.rq, "µm", 3)
            yield f"Rq is {rq}: check the unit of the heights (--height-unit)"
        if not _FINEST <= min(self.pixel_size) <= max(self.pixel_size) <= _COARSEST:
            yield "check the size of the pixels (--pixel-size)"
        if self.lengths.shortest < min(self.pixel_size):
            yield "neighbouring heights hardly depend on each other: noise, or too coarse pixels"
        yield from tilt_doubts(self.tilt)
        if self.missing:
            share = 100 * self.missing / np.prod(self.shape)
            yield f"{self.missing} heights ({share:.2g} %) are missing and were filled"
        if abs(self.skewness) > _ASKEW:
            yield (
                f"skewness {self.skewness:.2g}: a random surface has 0; simulate the scan itself: "
                f'disk.roughness.file = "{self.file}"'
            )
        askew = abs((self.fit.lay + 45) % 90 - 45)
        is_askew = self.is_self_affine and askew > max(_DEGREES, 3 * self.fit.lay_error)
        if self.has_lay and is_askew:
            yield (
                f"the lay runs at {self.fit.lay:.0f}° from x, and [disk.roughness] has lays along "
                "x or y alone: turn the scan, or simulate the scan itself"
            )
        along = self.lengths.along_x, self.lengths.along_y
        for axis, count, side, length in zip("xy", self.shape, self.pixel_size, along, strict=True):
            if count * side < _SHORT * length:
                many = f"{count * side / length:.2g}" if math.isfinite(length) else "under 2"
                yield f"the scan is {many} 1/e lengths long along {axis}: measure a larger area"
        if 2 < self.fit.misfit <= _UNLIKE:
            yield (
                f"the fitted spectrum is off by a factor {self.fit.misfit:.2g} at some wavelengths:"
                " the scan is not self-affine, or its instrument filters it"
            )

    @property
    def fault_of_fit(self) -> str:
        """Why no random roughness can stand for the scan; empty if one can."""
        if self.fit.misfit > _UNLIKE:
            return f"not self-affine: the best fit is off by a factor {self.fit.misfit:.2g}"
        lengths = zip(self.fit.correlation_length, self.fit.length_error, strict=True)
        if any(error > length for length, error in lengths):
            return (
                "too few heights, or too coarse pixels: the fit's lengths err by more than they are"
            )
        return ""

    @property
    def is_self_affine(self) -> bool:
        """True where a random roughness can stand for the scan."""
        return not self.fault_of_fit

    def as_dict(self) -> dict[str, Any]:
        """Return the statistics by name, with the table as text."""
        fitted = self.is_self_affine
        return asdict(self) | {
            "fit": asdict(self.fit) if fitted else None,
            "lengths": asdict(self.lengths) | {"texture_aspect": self.lengths.texture_aspect},
            "toml": self.toml if fitted else None,
            "warnings": list(self.warnings),
        }

    def lines(self) -> Iterator[str]:
        """Describe the scan, a line for each quantity."""
        lengths = (n * side for n, side in zip(self.shape, self.pixel_size, strict=True))
        yield (
            f"{self.file}: {self.shape[0]} × {self.shape[1]} heights, {display_sides(lengths)}, "
            f"pixels {display_sides(self.pixel_size)}"
        )
        yield f"  {self.axis}"
        yield from (f"  {name:20}{value}" for name, value in self._quantities())
        yield from (f"  {'warning':20}{warning}" for warning in self.warnings)

    def _quantities(self) -> Iterator[tuple[str, str]]:
        """Quantities of the scan, in words; those of the fit if it did not fail."""
        fit, lengths = self.fit, self.lengths
        percent = f"  ± {100 * fit.rms_error:.2g} % from surface to surface of this size"
        yield "Ra", f"{display(self.ra, 'µm', 4)}{percent * self.is_self_affine}"
        yield "Rq", display(self.rq, "µm", 4)
        yield "skewness, kurtosis", f"{self.skewness:.2g}, {self.kurtosis:.2g}"
        yield "tilt", "{:.2g}° along x, {:.2g}° along y, taken off".format(*self.tilt)
        lay = f"{lengths.direction:.0f}° from x"
        if self.is_self_affine:
            lay = f"{fit.lay:.0f}° from x ± {fit.lay_error:.1g}°"
        yield "lay", lay if self.has_lay else "none"
        x, y = (_worded(length) for length in (lengths.along_x, lengths.along_y))
        yield "1/e lengths", f"{x} along x, {y} along y, of the autocorrelation"
        aspect, sal = lengths.texture_aspect, _worded(lengths.shortest)
        ratio = "not known" if math.isnan(aspect) else f"{aspect:.2g}"
        yield "Sal, Str", f"{sal}, {ratio} (ISO 25178, at 1/e for its usual 0.2)"
        if not self.is_self_affine:
            yield "spectrum", f"{self.fault_of_fit}; so it gives no length and no Hurst exponent"
            return
        x, y = (
            f"{shown_in(length, 'µm'):.3g} ± {display(error, 'µm', 1)}"
            for length, error in zip(fit.correlation_length, fit.length_error, strict=True)
        )
        yield "correlation length", f"{x} along x, {y} along y, of the fitted spectrum"
        yield "Hurst exponent", f"{fit.hurst_exponent:.3g} ± {fit.hurst_error:.1g}"
        yield "spectrum", f"within a factor {fit.misfit:.2g} of that of the fit"

    def __str__(self) -> str:
        return "\n".join(self.lines())


def surface_statistics(
    path: str | Path,
    height_unit: float | str | None = None,
    pixel_size: Sequence[float | str] | None = None,
    transpose: bool = False,
    flip: Flip = "no",
) -> SurfaceStatistics:
    """Find the roughness of a scan, and the random roughness that is like it.

    Parameters
    ----------
    path : str or Path
        Plain array (.npy, .csv), or the file of an instrument, with the extra ``surfaces``.
    height_unit : float or str, optional
        Unit of the heights, such as ``"um"``, where the file gives none or a wrong one. A
        name, or a length in m.
    pixel_size : two of float or str, optional
        Sides of a pixel along x and y after any exchange, where the file gives none. Numbers in m,
        or text with a unit.
    transpose : bool
        Exchange x and y of the file.
    flip : {"no", "x", "y", "heights"}
        Reverse an axis, or the heights, as of a replica.

    Raises
    ------
    InputError
        If the file cannot be read, or lacks a unit or the size of its pixels; or if it has fewer
        than 16 heights along a side.

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
    surface = oriented(read_surface(path, unit), transpose, flip)
    if pixel_size is not None:
        x, y = (in_si("pixel_size", side, "1 um") for side in pixel_size)
        surface = surface.replace_pixels((x, y))
    if surface.pixel_size is None or min(surface.pixel_size) <= 0:
        raise InputError(f"{path}: no size of a pixel; give pixel_size, such as 0.8 um")
    try:
        return _described(path, surface, surface.pixel_size, axis_note(transpose))
    except InputError as error:
        raise InputError(f"{path}: {error}") from error


def _described(
    path: str | Path, surface: MeasuredSurface, sides: tuple[float, float], axis: str
) -> SurfaceStatistics:
    """Statistics of a surface whose pixels are known."""
    highest = np.abs(surface.heights[np.isfinite(surface.heights)]).max(initial=0.0)
    if highest > _HIGHEST:
        raise InputError(f"heights of {highest:.3g} m; give the unit that they are in, height_unit")
    holes = int(np.count_nonzero(~np.isfinite(surface.heights)))
    heights = filled(surface.heights)
    if min(heights.shape) < 2:
        raise InputError("a profile; give a map of heights")
    level = levelled(heights)
    if rms_height(level) <= _ROUNDING * highest:
        raise InputError("the heights are a plane, without any roughness; give another file")
    return SurfaceStatistics(
        file=str(path),
        shape=(level.shape[0], level.shape[1]),
        pixel_size=sides,
        missing=holes,
        ra=average_roughness(level),
        rq=rms_height(level),
        skewness=_moment(level, 3),
        kurtosis=_moment(level, 4),
        tilt=tilts(heights, level, sides),
        fit=fit_self_affine(level, sides),
        lengths=autocorrelation_lengths(level, sides),
        axis=axis,
        notes=surface.notes,
    )


def _worded(length: float) -> str:
    return display(length, "µm", 3) if math.isfinite(length) else "over half the scan"


def _moment(level: Array, order: int) -> float:
    return float(np.mean((level / rms_height(level)) ** order))
