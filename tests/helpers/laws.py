"""Wear laws and surfaces as a user would write them."""

from dataclasses import dataclass, field

import numpy as np

import tribo


@dataclass(frozen=True)
class ByPressure:
    """A rate in proportion to the pressure over the velocity, `rate` at 1 Pa and 1 m/s."""

    rate: float = 2e-24
    pattern: str = "local"

    def mean_wear(self, begin, end, pressure, velocity):
        return tribo.Wear(rate_at(self.rate, pressure) / velocity, self.pattern)


def rate_at(rate, pressure):
    return rate * pressure


@dataclass(frozen=True)
class Table:
    """Rates at sliding distances."""

    distances: tuple = (0.0, 1.0, 5.0)
    rates: tuple = (4e-15, 2e-15, 1e-15)


@dataclass(frozen=True)
class Tabled:
    """A rate that is interpolated in a table."""

    table: Table = field(default_factory=Table)
    pattern: str = "swept"

    def mean_wear(self, begin, end, pressure, velocity):
        rate = np.interp((begin + end) / 2, self.table.distances, self.table.rates)
        return tribo.Wear(float(rate), self.pattern)


@dataclass(frozen=True)
class Grooves:
    """Grooves across the sliding direction."""

    depth: float = 0.5e-6

    def heights(self, pixels):
        nx, ny = pixels.shape
        return np.tile(self.depth * np.cos(2 * np.pi * np.arange(nx) / 8)[:, None], (1, ny))
