"""A pair of gears, and what it transmits."""

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
    "gears run in mixed lubrication: what a film carries is not counted, nor is tip relief",
    "pressure, flash and film are of smooth flanks, in closed form",
)
_RQ_OF_RA = math.sqrt(math.pi / 2)  # where heights are distributed normally


@dataclass(frozen=True, slots=True)
class Duty:
    """What a pair transmits, and how hot its teeth are before they meet."""

    torque: float  #: On the pinion [N m].
    speed: float  #: Angular velocity of the pinion [rad/s].
    bulk: float  #: [K].
    load_factor: float = 1.0

    @property
    def turns(self) -> float:
        """Speed of the pinion in turns a minute."""
        return self.speed * 30 / math.pi


@dataclass(frozen=True, slots=True, kw_only=True)
class Pair:
    """A pair of gears of `read_pair`, the pinion first in each tuple."""

    title: str
    file: PairFile  #: Its tables in SI.
    gears: Involutes
    materials: tuple[Material, Material]
    oil: Oil | None
    duty: Duty
    written: Mapping[str, Any]  #: Entries with units, materials of the library in full.
    sources: tuple[FromLibrary, ...]
    notes: tuple[Remark, ...] = ()

    @property
    def critical(self) -> float | None:
        """Critical temperature of the lubricant [K]."""
        return self.file.temperature.critical

    @property
    def roughness(self) -> tuple[float, float]:
        """Ra of the flanks [m]."""
        return self.file.pinion.roughness, self.file.wheel.roughness

    @property
    def rms_roughness(self) -> float:
        """Rq of both flanks together, of heights distributed normally [m]."""
        return _RQ_OF_RA * math.hypot(*self.roughness)

    @property
    def caveats(self) -> tuple[str, ...]:
        """What a reader of each answer must know, in a line each."""
        if self.critical is None:
            return _LIMITS
        return *_LIMITS, critical_in_words(self.critical, self.file.temperature.critical_sd)

    def with_critical(self, kelvin: float, sd: float | None) -> Pair:
        """The pair with another critical temperature, and its standard deviation [K]."""
        temperature = replace(self.file.temperature, critical=kelvin, critical_sd=sd)
        return replace(self, file=replace(self.file, temperature=temperature))
