"""A certificate of samples: how far the emulator is off from direct simulations.

Boundaries of random inputs are sought by simulations at loads anywhere in the sweep; further runs
at its loads, between them and at the ends of the velocities tell whether bands are too narrow.
"""

from __future__ import annotations

from dataclasses import asdict, dataclass

import numpy as np

from pipeline.sweep.unknown import OF_90
from pipeline.uncertain.emulator import band_factor, outer
from tribo.types import Array

COUNT = 25
"""Boundaries of a certificate, and runs of each kind."""


@dataclass(frozen=True, slots=True)
class Certificate:
    """Boundaries found directly, beside those of the emulator, and runs anywhere."""

    loads: tuple[float, ...]  # of the boundaries [N]
    found: tuple[float, ...]  # critical velocities by simulations [m/s]
    emulated: tuple[float, ...]
    errors: tuple[float, ...]  # standard errors of these, relative
    # Differences of emulated rises from simulated ones over their stated error.
    at_loads: tuple[float, ...]  # of the samples, amid the velocities
    between_loads: tuple[float, ...]  # likewise
    at_ends: tuple[float, ...]  # of the velocities

    @property
    def off(self) -> Array:
        """How far the emulator's velocities are off, relative."""
        off: Array = np.log(np.array(self.emulated) / np.array(self.found))
        return off

    @property
    def error(self) -> float:
        """Root mean square of how far they are off."""
        return float(np.sqrt(np.mean(self.off**2)))

    @property
    def held(self) -> int:
        """Number of boundaries that the emulator's bands of 90 % hold."""
        return int(np.sum(np.abs(self.off) <= OF_90 * np.array(self.errors)))

    def factors(self, along: Array) -> Array:
        """Factors on errors, by share of the way between the ends of ln(velocity)."""
        amid, ends = (
            band_factor(np.array(scores), len(scores))
            for scores in (self.at_loads + self.between_loads, self.at_ends)
        )
        return np.asarray(amid + outer(along) * (ends - amid))

    def as_dict(self) -> dict[str, object]:
        """Return the summary and all boundaries as plain data."""
        return {"error": self.error, "held": self.held, "count": len(self.found)} | asdict(self)

    def __str__(self) -> str:
        return (
            f"{len(self.found)} boundaries were found directly: the emulator's are "
            f"{100 * self.error:.2g} % off, its 90 % bands hold {self.held}"
        )
