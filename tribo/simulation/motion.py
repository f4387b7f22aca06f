"""Motion of both bodies through the contact, as in a twin-disc or a ball-on-disc traction rig.

Both surfaces move along x past the contact, which stays where it is: the disk at u₂, the pin,
which rolls, at u₁. They slide on each other at V = |u₂ − u₁|, and the lubricant is entrained at
ū = (u₁ + u₂)/2. The slide-roll ratio is s = (u₂ − u₁)/ū.

**Wear.** In a time t a point of the pin comes through the contact u₁t/L times, where L is the
length of the track around the pin. In each pass it slides V·2b/u₁ on a contact that is 2b wide. It
wears by kV/u₁ ∫p dx, with the specific wear rate k and the pressure p. So all points of the track
wear by the same depth

    h(y) = k S/L ∫ p(x, y) dx,   S = Vt,                                                     (1)

however slowly the pin rolls, as long as it turns many times; the volume on the whole track is
k∫F dS, as for a pin at rest. The pin's profile along x stays round, so that a cylinder does not get
a flat, nor a wider contact.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import NamedTuple

from tribo.errors import InputError, require_number, require_positive

_AT_REST = 1e-12  # share of the sliding velocity below which a body's velocity is rounding


class Velocities(NamedTuple):
    """Velocities of both surfaces along x [m/s].

    Examples
    --------
    >>> rolling = Velocities(pin=1.0, disk=3.0)
    >>> rolling.disk - rolling.pin
    2.0
    """

    pin: float
    disk: float


@dataclass(frozen=True, slots=True, kw_only=True)
class Motion:
    """Motion of both bodies, from which their velocities follow at each sliding velocity.

    Parameters
    ----------
    slide_roll_ratio : float
        Sliding over entrainment velocity, s = (u₂ − u₁)/ū. If it is positive, the disk is faster,
        if negative, the pin. Beyond ±2 the bodies move in opposite directions. At 2 the pin is at
        rest.
    pin_track_length : float, optional
        Length of the track around the pin [m], over which its wear spreads; 2π times its radius if
        not given. It is needed if the pin's radius is the reduced radius of two discs.
    disk_track_length : float, optional
        Length of the track around the disk [m]. It does not change the simulation; answers use it
        to state how much heat of earlier revolutions the scene leaves out.

    Examples
    --------
    >>> Motion(slide_roll_ratio=0.5).velocities(1.0)
    Velocities(pin=1.5, disk=2.5)
    """

    slide_roll_ratio: float
    pin_track_length: float | None = None
    disk_track_length: float | None = None

    def __post_init__(self) -> None:
        require_number(slide_roll_ratio=self.slide_roll_ratio)
        if not math.isfinite(self.slide_roll_ratio):
            raise InputError(f"slide_roll_ratio is {self.slide_roll_ratio!r}; it must be finite")
        if self.slide_roll_ratio == 0:
            raise InputError("slide_roll_ratio is 0: pure rolling has no sliding velocity")
        lengths = {
            "pin_track_length": self.pin_track_length,
            "disk_track_length": self.disk_track_length,
        }
        require_positive(**{name: x for name, x in lengths.items() if x is not None})

    def velocities(self, sliding: float) -> Velocities:
        """Velocities of pin and disk [m/s].

        Disk minus pin is the sliding velocity, or its negative if `slide_roll_ratio` is negative.

        Parameters
        ----------
        sliding : float
            Sliding velocity [m/s]; if it is negative, both velocities change sign.
        """
        mean, share = abs(sliding / self.slide_roll_ratio), self.slide_roll_ratio / 2
        pin, disk = mean * (1 - share), mean * (1 + share)
        if abs(pin) <= _AT_REST * abs(sliding):
            pin = 0.0
        return Velocities(pin, disk) if sliding >= 0 else Velocities(-pin, -disk)
