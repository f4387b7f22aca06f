"""Random surfaces compared with measured heights, and their table of a scene."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator, Mapping
from typing import Any, NamedTuple

import numpy as np

from pipeline.laboratory.spectrum import SelfAffineFit
from pipeline.quantities import display

NEAR = 0.15  # relative difference below which two values are alike
_SCATTERS = 2.0  # two values are also alike within this many standard deviations of surfaces
_UNLIKE = 5  # factor between spectra above which a fit is rejected
_SURFACES = 8  # random surfaces compared with measured heights


class Likeness(NamedTuple):
    """Parameter, such as Rq, of measured heights, and of random surfaces fitted to them."""

    scan: float  # value of the measured heights
    mean: float  # mean over the random surfaces
    scatter: float  # relative standard deviation between the random surfaces

    @property
    def is_like(self) -> bool:
        """True if the measured value is close to the mean over the random surfaces.

        It differs by at most 15 % of the mean, or two standard deviations if these are more.
        """
        reach = max(NEAR, _SCATTERS * self.scatter) * self.mean
        return abs(self.scan - self.mean) <= reach


Likenesses = tuple[tuple[str, Likeness], ...]
"""Measured heights against random surfaces, by the name of the parameter."""


def compare(
    fit: SelfAffineFit,
    measured: Mapping[str, float],
    surface_of: Callable[[int], Mapping[str, float]],
) -> tuple[str, Likenesses]:
    """Compare parameters of measured heights with those of random surfaces by a fitted spectrum.

    `surface_of` has the parameters of the random surface of a seed. Returns why random surfaces
    differ, empty if they do not, and the parameters of both.
    """
    if fit.misfit > _UNLIKE:
        return f"its spectrum is off the best fit by a factor {fit.misfit:.2g}", ()
    surfaces, likeness = [surface_of(seed) for seed in range(_SURFACES)], []
    for name, value in measured.items():
        values = [one[name] for one in surfaces]
        mean = float(np.mean(values))
        scatter = float(np.std(values, ddof=1)) / mean if 0 < mean < math.inf else 0.0
        likeness.append((name, Likeness(value, mean, scatter)))
    unlike = [name for name, one in likeness if not one.is_like]
    fault = f"its {' and '.join(unlike)} {'differ' if unlike[1:] else 'differs'}" if unlike else ""
    return fault, tuple(likeness)


def likeness_lines(likeness: Likenesses, what: str) -> Iterator[tuple[str, str]]:
    """Yield pairs (name, value) in words on parameters of random surfaces and of a `what`."""
    for name, one in likeness:
        shown = "{:.2g}".format if name == "Str" else length_text
        yield (
            f"{name} of the fit",
            f"{shown(one.mean)} ± {100 * one.scatter:.2g} % from surface to surface; {what} "
            f"{shown(one.scan)}{'' if one.is_like else ': unlike'}",
        )


def length_text(length: float) -> str:
    """A length in µm; of an infinite one that it is over half the measured length."""
    return display(length, "µm", 3) if math.isfinite(length) else "over half the scan"


def likeness_entries(likeness: Likenesses) -> dict[str, Any]:
    """Parameters of both as plain data, by name."""
    return {name: one._asdict() | {"is_like": one.is_like} for name, one in likeness}


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
    return (x, y) if abs(x - y) > NEAR * mean else (mean, mean)
