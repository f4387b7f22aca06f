"""A pair of gears, and its duty: torque, speed and temperature."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass, replace
from typing import Any

from pipeline.gears.involute import Involutes
from pipeline.gears.pairfile import PairFile
from pipeline.sweep.condition_words import critical_in_words
from pipeline.sweep.remarks import Remark
from pipeline.sweep.sources import FromLibrary
from tribo import Material, Oil

UNTESTED = (
    "not validated: no scuffing test of gears was compared with this model of boundary lubrication"
)
_LIMITS = (
    UNTESTED,
    "gears run in mixed lubrication: the load carried by the film is not counted, nor tip relief",
    "pressure, flash and film are those of smooth flanks, in closed form",
)
_RQ_OF_RA = math.sqrt(math.pi / 2)  # Rq/Ra of normally distributed heights


@dataclass(frozen=True, slots=True)
class Duty:
    """Duty of a gear pair: pinion torque and speed, bulk temperature of the teeth, load factor."""

    torque: float  #: Torque on the pinion [N m].
    speed: float  #: Angular velocity of the pinion [rad/s].
    bulk: float  #: Bulk temperature of the teeth [K].
    #: Factor on the tooth load: product of those for application, dynamics and face load.
    load_factor: float = 1.0

    @property
    def turns(self) -> float:
        """Speed of the pinion [rpm]."""
        return self.speed * 30 / math.pi


@dataclass(frozen=True, slots=True, kw_only=True)
class Pair:
    """A pair of gears, as returned by `read_pair`; tuples have the pinion first."""

    title: str
    file: PairFile  #: Tables of its file in SI.
    gears: Involutes
    materials: tuple[Material, Material]
    oil: Oil | None
    duty: Duty
    written: Mapping[str, Any]  #: Entries as text with units; library materials in full.
    sources: tuple[FromLibrary, ...]
    notes: tuple[Remark, ...] = ()

    @property
    def critical(self) -> float | None:
        """Critical temperature of the lubricant [K]; None if not given."""
        return self.file.temperature.critical

    @property
    def roughness(self) -> tuple[float, float]:
        """Ra of both flanks [m]."""
        return self.file.pinion.roughness, self.file.wheel.roughness

    @property
    def rms_roughness(self) -> float:
        """Combined Rq of both flanks, for normally distributed heights [m]."""
        return _RQ_OF_RA * math.hypot(*self.roughness)

    @property
    def caveats(self) -> tuple[str, ...]:
        """Restrictions on every answer about this pair, one line each."""
        if self.critical is None:
            return _LIMITS
        return *_LIMITS, critical_in_words(self.critical, self.file.temperature.critical_sd)

    def with_critical(self, kelvin: float, sd: float | None) -> Pair:
        """Copy with another critical temperature, and its standard deviation [K] or None."""
        temperature = replace(self.file.temperature, critical=kelvin, critical_sd=sd)
        return replace(self, file=replace(self.file, temperature=temperature))
