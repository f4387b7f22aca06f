"""Roughness of measured profiles by ISO 21920, and of random surfaces like a data sheet's."""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Any

import numpy as np
from scipy.ndimage import convolve1d
from scipy.optimize import brentq

from pipeline.laboratory.instruments import RawScan
from pipeline.laboratory.likeness import (
    Likenesses,
    compare,
    likeness_entries,
    likeness_lines,
    roughness_toml,
)
from pipeline.laboratory.spectrum import SelfAffineFit, fit_profiles, profile_spectrum
from pipeline.quantities import display
from tribo import Grid, InputError
from tribo.surface import self_affine
from tribo.types import Array

CUTOFFS = (0.02e-6, 0.08e-3), (0.1e-6, 0.25e-3), (2e-6, 0.8e-3), (10e-6, 2.5e-3), (math.inf, 8e-3)
"""Highest Ra [m], and the nesting index λc [m] up to it (ISO 21920-3)."""
SECTIONS = 5
_ALPHA = math.sqrt(math.log(2) / math.pi)  # of the Gaussian filter, ISO 16610-21
_FEWEST = 8  # heights of a profile
_HEIGHT = 0.1  # least height of a profile element, over Rz
_ROUNDED = 0.75  # deviation of rounded places from even ones, at most, in steps
_HURST, _SURFACES = 0.8, 4  # of random surfaces like a data sheet's
_COMPARED = "Rq", "Rp", "Rv", "RSm"
_ROUNDING = 1e-9  # share of the heights; a smaller deviation from their line is rounding
_WINDOW = 512  # pixels of a side of these surfaces


@dataclass(frozen=True, slots=True)
class ProfileStatistics:
    """Roughness of one or more profiles by ISO 21920-2; means over the profiles."""

    file: str  #: File of the profiles.
    shape: tuple[int, int]  #: Numbers of heights along a profile, and of profiles.
    step: float  #: Distance of neighbouring heights [m].
    cutoff: float | None  #: Nesting index λc [m]; None without a filter.
    ra: float  #: Mean height [m].
    rq: float  #: Root mean square height [m].
    rz: float  #: Mean over the sections of the range of heights [m].
    rsm: float | None  #: Mean spacing of profile elements [m]; None for fewer than two.
    fit: SelfAffineFit | None = None  #: Best fit of a self-affine spectrum.
    fault_of_fit: str = ""  #: Why no random surface is like the profiles; empty if one is.
    likeness: Likenesses = ()  #: Profiles against those of random surfaces, by quantity.
    toml: str | None = None  #: Table ``[disk.roughness]`` of random surfaces like the profiles.
    notes: tuple[str, ...] = ()

    def as_dict(self) -> dict[str, Any]:
        """All statistics as plain data."""
        return asdict(self) | {"likeness": likeness_entries(self.likeness)}

    def lines(self) -> Iterator[str]:
        """Yield lines that describe the profiles."""
        count, profiles = self.shape
        several = f"{profiles} profiles" if profiles > 1 else "a profile"
        length = display((count - 1) * self.step, "mm", 4)
        yield f"{self.file}: {several} of {count} heights, {length}"
        cutoff = display(self.cutoff, "mm", 3) if self.cutoff else "none: unfiltered"
        rsm = "none: fewer than two elements" if self.rsm is None else display(self.rsm, "µm", 4)
        named = {name: display(getattr(self, name), "µm", 4) for name in ("ra", "rq", "rz")}
        rows = {name.capitalize(): text for name, text in named.items()} | {"RSm": rsm}
        yield from (f"  {name:16}{text}" for name, text in ({"λc": cutoff} | rows).items())
        for name, text in likeness_lines(self.likeness, "profile"):
            yield f"  {name:16}{text}"
        yield from (f"  {'note':16}{note}" for note in self.notes)
        yield ""
        if self.toml:
            yield from ["random surfaces like it, in a scene:", "", *self.toml.splitlines()]
        else:
            why = f"no random surface is like it ({self.fault_of_fit})"
            yield f"{why}: a scene needs a map of heights"

    def __str__(self) -> str:
        return "\n".join(self.lines())


def profile_statistics(
    file: str, places: Array, heights: Array, cutoff: float | None = None, lay: float | None = None
) -> ProfileStatistics:
    """Roughness of profiles (n, n_profile) [m] at places (n,) [m], and random surfaces like them.

    `cutoff` is λc [m], by default by the profile's own Ra; infinite for no filter. `lay` is the
    correlation length [m] of these surfaces along a lay, across which profiles run; None without.
    """
    step, level, notes = _even(places, heights)
    cutoff = _own_cutoff(level, step) if cutoff is None else cutoff
    rough, count, used, more = _roughness_sections(level, step, cutoff)
    notes += more
    found = _parameters(rough, step, count)
    if found["Rq"] <= _ROUNDING * float(np.nanmax(np.abs(heights))):
        raise InputError("the profile is a straight line, without any roughness; give another file")
    fit: SelfAffineFit | None = None
    fault, likeness, toml = "", Likenesses(), None
    try:
        fit = fit_profiles(rough, step, used)
    except InputError as error:
        fault = str(error)
    if fit:
        fault, likeness = compare(
            fit,
            {name: found[name] for name in _COMPARED},
            lambda seed: _parameters(_random_lines(fit, rough, step, used, seed), step, count),
        )
    if fit and not fault:
        length = fit.correlation_length[0]
        toml = roughness_toml(found["Ra"], fit.hurst_exponent, (length, lay or length))
        notes.append(
            "assumed: isotropic; --lay states a lay, across which the profile runs"
            if lay is None
            else "assumed: x runs across the lay, as the profile; else exchange both lengths"
        )
    ra, rq, rz, rsm = (found[name] for name in ("Ra", "Rq", "Rz", "RSm"))
    return ProfileStatistics(
        file, (len(level), level.shape[1]), step, used, ra, rq, rz,
        rsm if math.isfinite(rsm) else None, fit, fault, likeness, toml, tuple(notes),
    )  # fmt: skip


def _roughness_sections(
    level: Array, step: float, cutoff: float
) -> tuple[Array, int, float | None, list[str]]:
    """Roughness profile in up to five sections of λc, their number, λc used, and notes."""
    length = step * len(level)
    if length < cutoff * (1 - 1e-3):
        short = (
            f"shorter than one section of λc {display(cutoff, 'mm', 3)}: unfiltered; measure "
            f"{display(SECTIONS * cutoff, 'mm', 3)}, or give --cutoff"
        )
        return level, SECTIONS, None, [short] * math.isfinite(cutoff)
    count = min(SECTIONS, int((length + step) / cutoff * (1 + 1e-3)))
    used = min(len(level), round(count * cutoff / step))
    begin = (len(level) - used) // 2
    notes = [f"{count} of {SECTIONS} sections: the profile is short"] * (count < SECTIONS)
    return _roughness(level, step, cutoff)[begin : begin + used], count, cutoff, notes


def _parameters(rough: Array, step: float, count: int) -> dict[str, float]:
    """Ra, Rq, Rp, Rv, Rz and RSm [m] of roughness in `count` sections; RSm may be infinite."""
    pieces = np.array_split(rough, count)
    rp, rv = (float(np.mean([(way * one).max(axis=0) for one in pieces])) for way in (1, -1))
    rz = rp + rv
    spacings = [spacing_of(line, step, _HEIGHT * rz) for line in rough.T]
    known = [one for one in spacings if one is not None]
    ra, rq = float(np.abs(rough).mean()), float(np.sqrt((rough**2).mean()))
    rsm = float(np.mean(known)) if known else math.inf
    return {"Ra": ra, "Rq": rq, "Rp": rp, "Rv": rv, "Rz": rz, "RSm": rsm}


def _random_lines(
    fit: SelfAffineFit, like: Array, step: float, cutoff: float | None, seed: int
) -> Array:
    """Filtered profiles of random surfaces by a fit; their shape and Ra are those of `like`."""
    noise = np.random.default_rng(seed).standard_normal(like.shape)
    q = (2 * np.pi * np.fft.rfftfreq(len(like), step)).astype(np.float64)
    spectrum = profile_spectrum(q, fit.correlation_length[0], fit.hurst_exponent, cutoff)
    modes = np.fft.rfft(noise, axis=0) * np.sqrt(spectrum)[:, None]
    modes[0] = 0.0
    lines: Array = np.fft.irfft(modes, n=len(like), axis=0)
    lines *= np.abs(like).mean() / np.abs(lines).mean()
    return lines


def _even(places: Array, heights: Array) -> tuple[float, Array, list[str]]:
    """Step [m] and heights at even places, above a fitted straight line; and notes."""
    notes = list[str]()
    if (count := int(np.isfinite(heights).sum(axis=0).min())) < _FEWEST:
        raise InputError(f"a profile of {count} heights; give {_FEWEST} or more")
    order = np.argsort(places, kind="stable")
    places, heights = places[order], heights[order].astype(float)
    if not (np.diff(places) > 0).all():  # of NaN, too
        raise InputError(
            "a profile has two heights at one place, or one without a place; give each place once"
        )
    even = np.linspace(places[0], places[-1], len(places))
    step = float(even[1] - even[0])
    holes = int(np.isnan(heights).sum())
    if holes:
        notes.append(f"{holes} missing heights are filled by straight lines")
    is_uneven = np.abs(places - even).max() > _ROUNDED * step
    if is_uneven:
        notes.append("uneven places: heights between them are interpolated")
    lines = []
    for line in heights.T:
        known = np.isfinite(line)
        at = places if is_uneven else even
        filled = np.interp(even, at[known], line[known])
        lines.append(filled - np.polyval(np.polyfit(even, filled, 1), even))
    return step, np.stack(lines, axis=1), notes


def _own_cutoff(level: Array, step: float) -> float:
    """Nesting index λc [m] that fits Ra of the profile that it filters."""
    for most, cutoff in CUTOFFS:
        rough = _roughness(level, step, cutoff) if step * len(level) > cutoff else level
        if np.abs(rough).mean() <= most:
            return cutoff
    return CUTOFFS[-1][1]


def _roughness(level: Array, step: float, cutoff: float) -> Array:
    """Profile less its waviness, by the Gaussian filter with weights that end with the profile."""
    reach = min(round(cutoff / step), len(level) - 1)
    x = step * np.arange(-reach, reach + 1) / (_ALPHA * cutoff)
    weights = np.exp(-np.pi * x**2)
    total = convolve1d(np.ones(len(level)), weights, mode="constant")
    waviness = convolve1d(level, weights, axis=0, mode="constant") / total[:, None]
    rough: Array = level - waviness
    return rough


def spacing_of(line: Array, step: float, least: float) -> float | None:
    """RSm [m]: mean spacing of profile elements, whose peak and valley are `least` high.

    None for fewer than two elements.

    Examples
    --------
    >>> x = np.arange(4000) * 0.5e-6
    >>> f"{1e6 * spacing_of(np.sin(2 * np.pi * x / 60e-6), 0.5e-6, 0.2):.2f} µm"
    '60.00 µm'
    """
    side = np.where(line > least, 1, np.where(line < -least, -1, 0))
    rows = np.flatnonzero(side)
    if rows.size < 2:
        return None
    turns = np.flatnonzero(np.diff(side[rows]))
    crossings: list[list[float]] = [[], []]
    for k in turns:
        low, high = rows[k], rows[k + 1]
        signs = np.flatnonzero(np.diff(np.signbit(line[low : high + 1])))
        row = low + int(signs[-1])
        at = row + line[row] / (line[row] - line[row + 1])
        crossings[int(side[high] > 0)].append(float(at))
    spans = [((one[-1] - one[0]), len(one) - 1) for one in crossings if len(one) > 1]
    if not spans:
        return None
    return step * sum(span for span, _ in spans) / sum(count for _, count in spans)


def data_sheet_toml(ra: float, rsm: float, pixel: float) -> tuple[str, list[str]]:
    """``[disk.roughness]`` of random surfaces with Ra and RSm [m], and the assumptions.

    RSm is that of profiles of random surfaces in pixels [m].
    """
    grid = Grid((_WINDOW, _WINDOW), (pixel, pixel))

    def excess(length: float) -> float:
        found = list[float]()
        for seed in range(_SURFACES):
            heights = self_affine(grid, ra, _HURST, (length, length), seed=seed)
            for line in heights.T[::16]:
                rz = float(np.mean([np.ptp(one) for one in np.array_split(line, SECTIONS)]))
                found.append(spacing_of(line, pixel, _HEIGHT * rz) or _WINDOW * pixel)
        return math.log(float(np.mean(found)) / rsm)

    ends = 0.3 * pixel, _WINDOW * pixel / 12
    below, above = (rsm * math.exp(excess(one)) for one in ends)
    if not below < rsm < above:
        raise InputError(
            f"RSm is {display(rsm, 'µm', 3)}; with pixels of {display(pixel, 'µm', 3)} profiles of "
            f"random surfaces have {display(below, 'µm', 3)} to {display(above, 'µm', 3)}; give "
            f"{'smaller' if rsm < below else 'larger'} pixels, --pixel-size"
        )
    length = math.exp(float(brentq(lambda x: excess(math.exp(x)), *map(math.log, ends), xtol=0.01)))
    toml = roughness_toml(ra, _HURST, (length, length))
    return toml, [
        f"assumed: Hurst exponent {_HURST}",
        "assumed: isotropic, without a lay",
        f"assumed: RSm is that of profiles of random surfaces in pixels of "
        f"{display(pixel, 'µm', 3)}",
    ]


def profiles_in(
    path: Path, raw: RawScan, units: tuple[float | None, float | None], step: float | None
) -> tuple[Array, Array]:
    """Places (n,) and heights (n, n_profile) [m] of the profiles that a file has.

    `units` are those of heights and lengths that the user gave [m], and `step` the distance of
    heights without places [m].
    """
    height, length = units[0] or raw.unit, units[1] or raw.place_unit
    places = np.asarray(raw.places, dtype=float)
    is_numbered = bool(np.array_equal(places, np.arange(len(places))))
    if is_numbered and step:
        length = step
    lacks = ['--height-unit "um"'] * (height is None)
    if length is None:
        lacks += ['--pixel-size "0.5 um"' if is_numbered else '--length-unit "mm"']
    if height is None or length is None:
        raise InputError(f"{path}: a profile without units; give {' and '.join(lacks)}")
    return places * length, raw.heights * height
