"""Statistics of a scan, and the random surface that fits it best."""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from dataclasses import asdict, dataclass, field, replace
from pathlib import Path
from typing import Any, ClassVar

import numpy as np

from pipeline.arguments import in_share, in_si, plain_value, typed_arguments
from pipeline.messages import quoted
from pipeline.quantities import display, display_sides
from pipeline.surface.random_surface import (
    SelfAffineFit,
    average_if_close,
    fit_self_affine,
    roughness_toml,
)
from pipeline.surface.scan import Scan, read_scan
from pipeline.surface.window import filled, form_words
from tribo import Grid, InputError
from tribo.errors import require_positive
from tribo.surface import self_affine
from tribo.surface.areal import ArealRoughness, areal_roughness, remove_form
from tribo.types import Array

MISSING = 0.1
"""Share of missing heights up to which they are filled."""
_UNIT_SIZES = {"um": 1e-6, "nm": 1e-9, "mm": 1e-3, "m": 1.0}
_OBLIQUE_ANGLE = 15.0  # angle to both x and y [°] above which a lay is oblique


@dataclass(frozen=True, slots=True, eq=False)
class SurfaceStatistics:
    """Roughness of a scan from its measured heights, and the random surface that fits it best."""

    file: str  #: File of the scan.
    shape: tuple[int, int]  #: Numbers of heights along x and y.
    pixel_size: tuple[float, float]  #: Sides of a pixel along x and y [m].
    missing: int  #: Number of heights that the instrument did not measure.
    roughness: ArealRoughness  #: Of the scan, by ISO 25178-2.
    fit: SelfAffineFit  #: Best fit of a self-affine spectrum.
    fitted: ArealRoughness  #: Of a random surface by the fit, in the window of the scan.
    heights: Array = field(repr=False)  #: Heights above the form [m], missing ones filled.
    fitted_heights: Array = field(repr=False)  #: Those of the random surface [m].
    scan_tables: str = field(repr=False)  #: Tables of a scene that simulates the scan itself.
    notes: tuple[str, ...] = ()  #: On holes, doubtful units, and arguments that override the file.
    drawn_by: ClassVar = "pipeline.figures.study_figures:draw_surface"

    @property
    def faults_of_fit(self) -> tuple[str, ...]:
        """Why a random surface is a poor substitute for the scan; empty if it is a good one."""
        return tuple(_faults_of_fit(self))

    @property
    def random_tables(self) -> str:
        """Table ``[disk.roughness]`` of a scene, as text, for the random surface."""
        fit = self.fit
        return roughness_toml(self.roughness.sa, fit.hurst_exponent, fit.correlation_length)

    def as_dict(self) -> dict[str, Any]:
        """All statistics as plain data, without heights, and with the table as text."""
        without_heights = replace(self, heights=np.empty(0), fitted_heights=np.empty(0))
        document = asdict(without_heights) | {
            "faults_of_fit": [*self.faults_of_fit],
            "random_tables": self.random_tables,
        }
        return {key: value for key, value in document.items() if not key.endswith("heights")}

    def lines(self) -> Iterator[str]:
        """Yield lines that compare the scan with the random surface."""
        nx, ny = self.shape
        sides = nx * self.pixel_size[0], ny * self.pixel_size[1]
        yield self.file
        yield (
            f"  {nx} × {ny} heights, {display_sides(sides)}, "
            f"pixels {display_sides(self.pixel_size)}"
        )
        yield from (f"  note: {note}" for note in self.notes)
        x, y = np.degrees(np.arctan(self.roughness.slopes))
        removed = f"removed: tilt {x:.2f}° along x, {y:.2f}° along y"
        radii = form_words(self.roughness.radii)
        yield f"  {removed}; curvature, R {radii}" if radii else f"  {removed}"
        yield f"  {'ISO 25178-2':14}{'scan':20}random surface"
        yield from (f"  {name:14}{scan:20}{random}" for name, scan, random in self.rows())
        yield ""
        yield self.words_on_lay
        yield self.words_on_fit

    @property
    def words_on_lay(self) -> str:
        """Direction of the lay relative to sliding, and the lengths of the fit, in sentences."""
        x, y = (
            display(length, "µm", 3) for length in average_if_close(self.fit.correlation_length)
        )
        lengths = f"Correlation length: {x} along sliding (x), {y} across sliding (y)."
        angle = self.roughness.lay
        if angle is None:
            return f"The scan has no lay. {lengths}"
        if abs(angle) <= _OBLIQUE_ANGLE:
            return f"The grooves lie along sliding, at {angle:.0f}° to x. {lengths}"
        if abs(angle) >= 90 - _OBLIQUE_ANGLE:
            return f"The grooves lie across sliding, at {angle:.0f}° to x. {lengths}"
        return f"The grooves lie oblique to sliding, at {angle:.0f}° to x. {lengths}"

    @property
    def words_on_fit(self) -> str:
        """How well the random surface fits, in a sentence."""
        if faults := self.faults_of_fit:
            return f"The random surface fits poorly: {'; '.join(faults)}."
        return "The random surface fits well: its spectrum, gradient and lengths are the scan's."

    @property
    def tables(self) -> str:
        """Tables of a scene as text: the random surface's and the scan's, the better one first."""
        random = "for a random surface by the fit", self.random_tables
        scan = "for the scan itself", self.scan_tables
        tables = (scan, random) if self.faults_of_fit else (random, scan)
        return "\n".join(f"In a scene, {use}:\n\n{toml}" for use, toml in tables)

    def rows(self) -> Iterator[tuple[str, str, str]]:
        """Yield the name of each number, its value for the scan, and for the random surface."""
        fitted_texts = dict(_number_texts(self.fitted))
        for name, text in _number_texts(self.roughness):
            yield name, text, fitted_texts[name]
        if math.isnan(self.fit.misfit):
            yield "spectrum", "", "not compared"
        else:
            yield "spectrum", "", f"within a factor {self.fit.misfit:.2g} of the scan's"

    def __str__(self) -> str:
        return "\n".join([*self.lines(), "", self.tables])


def _faults_of_fit(statistics: SurfaceStatistics) -> Iterator[str]:
    scan, fitted = statistics.roughness, statistics.fitted
    if math.isnan(statistics.fit.misfit):
        yield "the scan has too few heights to compare spectra"
    elif statistics.fit.misfit > 2:
        yield f"its spectrum is off by a factor {statistics.fit.misfit:.2g} at some wavelengths"
    axes = zip(
        statistics.fit.correlation_length, statistics.shape, statistics.pixel_size, strict=True
    )
    if any(not side <= length <= count * side / 2 for length, count, side in axes):
        yield "a correlation length is below a pixel, or above half the scan"
    if abs(scan.ssk) > 0.5:
        yield f"Ssk is {scan.ssk:.2g}, where a random surface has 0"
    if not 2 <= scan.sku <= 5:
        yield f"Sku is {scan.sku:.2g}, where a random surface has 3"
    if abs(scan.sa / fitted.sa - 1) > 0.3:
        yield f"its Sa is {scan.sa / fitted.sa:.2g} times that of the fit above its form"
    if abs(scan.sdq / fitted.sdq - 1) > 0.25:
        yield f"its gradient Sdq is {scan.sdq / fitted.sdq:.2g} times that of the fit"
    # Both are infinite where correlations reach over the scan.
    if not (scan.sal == fitted.sal or abs(scan.sal / fitted.sal - 1) <= 0.5):
        yield f"its Sal is {scan.sal / fitted.sal:.2g} times that of the fit"
    if scan.lay is not None and _OBLIQUE_ANGLE < abs(scan.lay) < 90 - _OBLIQUE_ANGLE:
        yield f"its lay is at {scan.lay:.0f}° to x, which the random surface cannot have"


def _number_texts(roughness: ArealRoughness) -> Iterator[tuple[str, str]]:
    """Yield the name and the value of each number, as text."""
    for name in ("sa", "sq", "sz"):
        yield name.capitalize(), display(getattr(roughness, name), "µm", 4)
    yield "Ssk, Sku", f"{roughness.ssk:.2g}, {roughness.sku:.2g}"
    yield "Sdq", f"{roughness.sdq:.3g}"
    has_length = math.isfinite(roughness.sal)
    yield "Sal", display(roughness.sal, "µm", 3) if has_length else "over half a side"
    aspect = f"{roughness.aspect:.2g}" if roughness.aspect else "lay beyond the scan"
    yield "Str", "unknown" if math.isnan(roughness.aspect) else aspect
    yield "lay", "none" if roughness.lay is None else f"{roughness.lay:.0f}° from x"


@typed_arguments
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
        Roughness of the scan and of the random surface that fits it best; ``random_tables`` has
        the table of this for a scene.

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
    >>> import tomllib
    >>> import numpy as np
    >>> from pipeline import surface_statistics
    >>> from tribo import Grid
    >>> from tribo.surface import self_affine
    >>> heights = self_affine(Grid((256, 256), (1e-6, 1e-6)), 0.3e-6, 0.8, (4e-6, 4e-6), seed=0)
    >>> np.save("results/scan.npy", heights * 1e6)
    >>> statistics = surface_statistics("results/scan.npy", "um", ("1 um", "1 um"))
    >>> roughness = tomllib.loads(statistics.random_tables)["disk"]["roughness"]
    >>> roughness["ra"], roughness["correlation_length"]
    ('0.299 um', '3.25 um')
    """
    unit, sides = _unit_in_si(height_unit), _sides_in_si(pixel_size)
    max_missing = in_share("missing", missing)
    if not 0 <= max_missing < 1:
        raise InputError(f"missing is {missing!r}; give a share from 0 to 1, such as 0.1")
    scan = read_scan(path, unit, sides)
    try:
        statistics = _statistics(str(path), scan, max_missing)
    except InputError as error:
        raise InputError(f"{path}: {error}") from error
    return replace(statistics, scan_tables=_scan_tables(statistics, unit, sides, max_missing))


def _unit_in_si(height_unit: Any) -> float | None:
    """Unit of heights [m] from the argument `height_unit`."""
    unit = plain_value("height_unit", height_unit)
    if unit is None:
        return None
    text = f"1 {unit}" if isinstance(unit, str) and not unit[:1].isdigit() else unit
    metres = in_si("height_unit", text, "1 um")
    require_positive(height_unit=metres)
    return metres


def _sides_in_si(pixel_size: Any) -> tuple[float, float] | None:
    """Sides of a pixel along x and y [m] from the argument `pixel_size`."""
    sides = plain_value("pixel_size", pixel_size)
    if sides is None:
        return None
    if not isinstance(sides, list) or len(sides) != 2:
        raise InputError(f"pixel_size is {pixel_size!r}; give two sides, along x and y")
    x, y = (in_si("pixel_size", side, "1 um") for side in sides)
    require_positive(pixel_size_x=x, pixel_size_y=y)
    return x, y


def _statistics(file: str, scan: Scan, max_missing: float) -> SurfaceStatistics:
    sides, shape = scan.pixel_size, (scan.heights.shape[0], scan.heights.shape[1])
    roughness, notes = areal_roughness(scan.heights, sides), [*scan.notes]
    if scan.missing:
        notes.append(f"{scan.missing_words}: left out of the parameters, filled for the fit")
    notes += _unusual_values(roughness, sides)
    level, *_ = remove_form(filled(scan, max_missing), sides)
    fit = fit_self_affine(level, sides)
    lengths = average_if_close(fit.correlation_length)
    surface = self_affine(Grid(shape, sides), roughness.sa, fit.hurst_exponent, lengths, seed=0)
    fitted = areal_roughness(surface, sides)
    return SurfaceStatistics(
        file, shape, sides, scan.missing, roughness, fit, fitted, level, surface, "", tuple(notes)
    )


def _unusual_values(roughness: ArealRoughness, sides: tuple[float, float]) -> Iterator[str]:
    """Notes on numbers outside the usual range, most likely because of a wrong unit."""
    if not 1e-9 <= roughness.sq <= 5e-5:
        yield f"Sq is {display(roughness.sq, 'µm', 3)}: check the unit of the heights"
    if not 1e-9 <= min(sides) <= max(sides) <= 1e-4:
        yield f"pixels are {display_sides(sides)}: check their size"
    if not 1e-4 <= roughness.sdq <= 3:
        yield (
            f"the gradient Sdq is {roughness.sdq:.2g}: check the unit of heights and the pixels' "
            "size"
        )
    if roughness.sal < min(sides):
        yield "neighbouring heights are hardly correlated: noise, or too coarse pixels"


def _scan_tables(
    statistics: SurfaceStatistics,
    unit: float | None,
    sides: tuple[float, float] | None,
    max_missing: float,
) -> str:
    """Tables of a scene that simulates the scan itself, by the unit and sides that were given."""
    x, y = (f'"{display(side, "um", 6)}"' for side in statistics.pixel_size)
    pixel_size = f"[{x}, {y}]"
    entries = [f"file = {quoted(statistics.file)}"]
    if unit:
        units = (name for name, size in _UNIT_SIZES.items() if math.isclose(size, unit))
        entries.append(f"height_unit = {quoted(next(units, f'{unit:g} m'))}")
    if sides:
        entries.append(f"pixel_size = {pixel_size}")
    entries.append("level = true")
    if max_missing != MISSING:
        entries.append(f"missing = {max_missing:g}")
    return (
        f"disk = {{ roughness = {{ {', '.join(entries)} }} }}\n"
        f"window = {{ pixel_size = {pixel_size} }}\n"
    )
