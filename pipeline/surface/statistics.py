"""What a scan says in numbers, and the random surface that fits it best."""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Any

import numpy as np

from pipeline.quantities import display, display_sides
from pipeline.surface.fit import SelfAffineFit, fit_self_affine
from pipeline.surface.scan import Scan, read_scan
from pipeline.surface.window import filled, form_words
from pipeline.units import in_si
from tribo import Grid, InputError
from tribo.surface import self_affine
from tribo.surface.areal import ArealRoughness, areal_roughness, remove_form

MISSING = 0.1
"""Share of missing heights up to which they are filled."""
_NEAR = 0.15  # relative difference below which two lengths are alike
_FACTOR = 2.0  # between spectra, above which a fit is poor
_ASKEW, _STEEP, _LONG = 0.5, 0.25, 0.5  # differences of Ssk, Sdq and Sal, above which it is, too
_OBLIQUE = 15.0  # angle of a lay to x and y [°], above which it is, too
_FLATTEST, _ROUGHEST = 1e-10, 1e-4  # plausible range of Sq [m]
_FINEST, _COARSEST = 1e-9, 1e-3  # plausible range of pixel sides [m]


@dataclass(frozen=True, slots=True)
class SurfaceStatistics:
    """Roughness of a scan from its measured heights, and the random surface that fits it best."""

    file: str  #: File of the scan.
    shape: tuple[int, int]  #: Numbers of heights along x and y.
    pixel_size: tuple[float, float]  #: Sides of a pixel along x and y [m].
    missing: int  #: Number of heights that the instrument did not measure.
    roughness: ArealRoughness  #: Of the scan, by ISO 25178-2.
    fit: SelfAffineFit  #: Best fit of a self-affine spectrum.
    fitted: ArealRoughness  #: Of a random surface by the fit, in the window of the scan.
    notes: tuple[str, ...] = ()  #: On holes, doubtful units, and arguments that override the file.

    @property
    def faults_of_fit(self) -> tuple[str, ...]:
        """Why a random surface is a poor substitute for the scan; empty if it is a good one."""
        return tuple(self._faults_of_fit())

    def _faults_of_fit(self) -> Iterator[str]:
        scan, fitted = self.roughness, self.fitted
        if self.fit.misfit > _FACTOR:
            yield f"its spectrum is off by a factor {self.fit.misfit:.2g} at some wavelengths"
        lengths, ends = self.fit.correlation_length, zip(self.shape, self.pixel_size, strict=True)
        if any(not d <= one <= n * d / 2 for one, (n, d) in zip(lengths, ends, strict=True)):
            yield "a correlation length is below a pixel, or above half the scan"
        if abs(scan.ssk) > _ASKEW:
            yield f"Ssk is {scan.ssk:.2g}, where a random surface has 0"
        if abs(scan.sdq / fitted.sdq - 1) > _STEEP:
            yield f"its gradient Sdq is {scan.sdq / fitted.sdq:.2g} times that of the fit"
        if not (scan.sal == fitted.sal or abs(scan.sal / fitted.sal - 1) <= _LONG):
            yield f"its Sal is {scan.sal / fitted.sal:.2g} times that of the fit"
        if scan.lay is not None and _OBLIQUE < abs(scan.lay) < 90 - _OBLIQUE:
            yield f"its lay is at {scan.lay:.0f}° to x; turn the sample to sliding"

    @property
    def toml(self) -> str:
        """Table ``[disk.roughness]`` of a scene, as text, for the random surface."""
        fit = self.fit
        return roughness_toml(self.roughness.sa, fit.hurst_exponent, fit.correlation_length)

    def as_dict(self) -> dict[str, Any]:
        """All statistics as plain data, with the table as text."""
        return asdict(self) | {"faults_of_fit": [*self.faults_of_fit], "toml": self.toml}

    def lines(self) -> Iterator[str]:
        """Yield lines that describe the scan beside the random surface, and the table of this."""
        sides = (n * side for n, side in zip(self.shape, self.pixel_size, strict=True))
        yield (
            f"{self.file}: {self.shape[0]} × {self.shape[1]} heights, {display_sides(sides)}, "
            f"pixels {display_sides(self.pixel_size)}"
        )
        yield from (f"  note: {note}" for note in self.notes)
        tilt, curved = np.degrees(np.arctan(self.roughness.slopes)), self.roughness.radii
        yield "  removed: tilt {:.2g}° along x, {:.2g}° along y".format(*tilt) + (
            f"; curvature, R {form_words(curved)}" if form_words(curved) else ""
        )
        yield f"  {'ISO 25178-2':14}{'scan':20}random surface"
        rows = zip(_rows(self.roughness), _rows(self.fitted), strict=True)
        yield from (f"  {name:14}{text:20}{other}" for (name, text), (_, other) in rows)
        yield f"  spectrum      within a factor {self.fit.misfit:.2g} of the random surface's"
        yield ""
        if faults := self.faults_of_fit:
            yield f"The random surface fits poorly: {'; '.join(faults)}."
            yield f'Simulate the scan itself: disk.roughness.file = "{self.file}"'
        else:
            yield "The random surface fits well."
        yield from ["", *self.toml.splitlines()]

    def __str__(self) -> str:
        return "\n".join(self.lines())


def _rows(rough: ArealRoughness) -> Iterator[tuple[str, str]]:
    for name in ("sa", "sq", "sz"):
        yield name.capitalize(), display(getattr(rough, name), "µm", 4)
    yield "Ssk, Sku", f"{rough.ssk:.2g}, {rough.sku:.2g}"
    yield "Sdq", f"{rough.sdq:.3g}"
    is_known = math.isfinite(rough.sal)
    yield "Sal", display(rough.sal, "µm", 3) if is_known else "over half a side"
    yield "Str", f"{rough.aspect:.2g}"
    yield "lay", "none" if rough.lay is None else f"{rough.lay:.0f}° from x"


@np.errstate(under="ignore")
def surface_statistics(
    path: str | Path,
    height_unit: float | str | None = None,
    pixel_size: Sequence[float | str] | None = None,
    missing: float = MISSING,
) -> SurfaceStatistics:
    """Measure the roughness of a scan by ISO 25178-2, and fit a random surface to it.

    Parameters
    ----------
    path : str or Path
        Matrix of heights, as .npy or text; or an instrument's file, which needs the optional
        packages ``surfaces``.
    height_unit : float or str, optional
        Unit of the heights, such as ``"um"``, or its length in m. It replaces the unit of the
        file.
    pixel_size : two of float or str, optional
        Sides of a pixel along x and y, as numbers in m or text with a unit. They replace the sizes
        in the file.
    missing : float, optional
        Share of missing heights up to which they are filled for the fit.

    Returns
    -------
    SurfaceStatistics
        Roughness of the scan and of the random surface that fits it best; ``toml`` has the table of
        this for a scene.

    Raises
    ------
    InputError
        If the file cannot be read, is no map, lacks a unit or the size of its pixels, or too many
        heights are missing.

    Notes
    -----
    The mean plane is removed, and a significant curvature. Missing heights are left out, except in
    the fit.

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
    sides = [in_si("pixel_size", side, "1 um") for side in pixel_size or ()]
    scan = read_scan(path, unit, (sides[0], sides[1]) if sides else None)
    try:
        return _statistics(str(path), scan, missing)
    except InputError as error:
        raise InputError(f"{path}: {error}") from error


def _statistics(file: str, scan: Scan, missing: float) -> SurfaceStatistics:
    sides, shape = scan.pixel_size, (scan.heights.shape[0], scan.heights.shape[1])
    rough, notes = areal_roughness(scan.heights, sides), [*scan.notes]
    if scan.missing:
        notes.append(f"{scan.missing_words} and left out; the fit has them filled")
    if not _FLATTEST <= rough.sq <= _ROUGHEST:
        notes.append(f"Sq is {display(rough.sq, 'µm', 3)}: check the unit of the heights")
    if not _FINEST <= min(sides) <= max(sides) <= _COARSEST:
        notes.append("check the size of the pixels")
    if rough.sal < min(sides):
        notes.append("neighbouring heights are hardly correlated: noise, or too coarse pixels")
    level, *_ = remove_form(filled(scan, missing), sides)
    fit = fit_self_affine(level, sides)
    lengths = nearly_equal(fit.correlation_length)
    surface = self_affine(Grid(shape, sides), rough.sa, fit.hurst_exponent, lengths, seed=0)
    fitted = areal_roughness(surface, sides)
    return SurfaceStatistics(file, shape, sides, scan.missing, rough, fit, fitted, tuple(notes))


def roughness_toml(ra: float, hurst_exponent: float, lengths: tuple[float, float]) -> str:
    """Table ``[disk.roughness]`` of a scene for random surfaces; `ra` and `lengths` are in m.

    Nearly equal correlation lengths along x and y become their geometric mean.
    """
    x, y = nearly_equal(lengths)
    texts = [f'"{display(one, "um", 3)}"' for one in (x, y)]
    length = texts[0] if texts[0] == texts[1] else f"[{', '.join(texts)}]"
    return (
        f'[disk.roughness]\nra = "{display(ra, "um", 4)}"\n'
        f"hurst_exponent = {hurst_exponent:.3g}\ncorrelation_length = {length}\n"
    )


def nearly_equal(lengths: tuple[float, float]) -> tuple[float, float]:
    """Lengths along x and y; both their geometric mean if they are nearly equal."""
    x, y = lengths
    mean = math.sqrt(x * y)
    return (x, y) if abs(x - y) > _NEAR * mean else (mean, mean)
