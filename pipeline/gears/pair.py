"""A pair of gears, and what it transmits."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass, replace
from typing import Any

from pipeline.gears.involute import Involutes
from pipeline.sweep.about import FromLibrary
from pipeline.sweep.caveats import critical_in_words
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

    name: str
    title: str
    gears: Involutes
    materials: tuple[Material, Material]
    roughness: tuple[float, float]  #: Ra of the flanks [m].
    duty: Duty
    quality: int = 6
    critical: float | None = None  #: Critical temperature of the lubricant [K].
    critical_sd: float | None = None  #: Its standard deviation [K]; None if it is not known.
    friction: float | None = None  #: None by the rule of the standard.
    lubricant_factor: float = 1.0
    oil: Oil | None = None
    oil_temperature: float | None = None  #: By which the bulk follows [K]; None if that is given.
    correlation_length: tuple[float, float]  #: [m].
    hurst_exponent: float
    specific_wear_rate: float  #: Of the pinion [m²/N].
    written: Mapping[str, Any]  #: Materials and oil with units, those of the library in full.
    sources: tuple[FromLibrary, ...] = ()

    @property
    def rms_roughness(self) -> float:
        """Rq of both flanks together, of heights distributed normally [m]."""
        return _RQ_OF_RA * math.hypot(*self.roughness)

    @property
    def caveats(self) -> tuple[str, ...]:
        """What a reader of each answer must know, in a line each."""
        if self.critical is None:
            return _LIMITS
        return *_LIMITS, critical_in_words(self.critical, self.critical_sd)

    def changed(self, **fields: Any) -> Pair:
        """The pair with some fields replaced."""
        return replace(self, **fields)
