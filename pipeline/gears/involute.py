"""Geometry of a pair of external involute gears, spur or helical, in the transverse section.

A place on the path of contact is its distance g [m] from the pitch point along the line of action,
positive towards the tip of the pinion. Equations and letters are those of ISO 21771:2007: contact
runs from A, the tip of the wheel, to E, the tip of the pinion. From B to D a single pair of teeth
is in contact.
"""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
import scipy

from pipeline.quantities import display
from tribo import InputError

_TOOL_ADDENDUM = 1.0  # straight part of a standard rack's tooth above its pitch line, in modules
_MISFIT = 0.1  # largest error of the centre distance against the profile shifts, in modules


class Path(NamedTuple):
    """Places on the path of contact, from the pitch point [m]: A, B, D and E.

    Contact begins at A and ends at E. A single pair of teeth touches from B to D.
    """

    a: float
    b: float
    d: float
    e: float


def involute(angle: float) -> float:
    """Involute function inv α = tan α − α of an angle [rad].

    Examples
    --------
    >>> f"{involute(math.radians(20)):.6f}"
    '0.014904'
    """
    return math.tan(angle) - angle


def involute_angle(value: float) -> float:
    """Angle [rad] whose involute function has the value `value`, at least 0.

    Examples
    --------
    >>> f"{math.degrees(involute_angle(0.034317)):.4f}"
    '26.0888'
    """
    root = scipy.optimize.brentq(lambda x: involute(x) - value, 0.0, 1.5, xtol=1e-15)
    return float(root)


@dataclass(frozen=True, slots=True)
class Involutes:
    """Two external involute gears in mesh: the pinion first, the wheel second.

    Parameters
    ----------
    module : float
        Normal module [m].
    pressure_angle : float
        Normal pressure angle [rad].
    helix_angle : float
        Helix angle at the reference circle [rad]; 0 for spur gears.
    teeth : tuple of int
        Numbers of teeth.
    profile_shifts : tuple of float
        Profile shift coefficients x.
    centre_distance : float
        Centre distance [m].
    tip_diameters : tuple of float
        Tip diameters [m].
    face_width : float
        Common face width [m].

    Raises
    ------
    InputError
        If the pair cannot run. The message names the fault, the value and what is allowed.

    Examples
    --------
    The test gears A of FZG:

    >>> pair = Involutes(
    ...     module=4.5e-3, pressure_angle=math.radians(20), helix_angle=0.0, teeth=(16, 24),
    ...     profile_shifts=(0.8532, -0.5), centre_distance=91.5e-3,
    ...     tip_diameters=(88.77e-3, 112.5e-3), face_width=20e-3,
    ... )
    >>> f"{pair.contact_ratio:.2f}, {math.degrees(pair.working_angle):.2f}°"
    '1.36, 22.44°'
    """

    module: float
    pressure_angle: float
    helix_angle: float
    teeth: tuple[int, int]
    profile_shifts: tuple[float, float]
    centre_distance: float
    tip_diameters: tuple[float, float]
    face_width: float

    def __post_init__(self) -> None:
        for fault in self._faults():
            raise InputError(fault)

    @property
    def transverse_angle(self) -> float:
        """Pressure angle in the transverse section, tan αt = tan αn/cos β [rad]."""
        return math.atan(math.tan(self.pressure_angle) / math.cos(self.helix_angle))

    @property
    def reference_radii(self) -> tuple[float, float]:
        """Radii of the reference circles, r = z mn/(2 cos β) [m]."""
        half = self.module / math.cos(self.helix_angle) / 2
        return self.teeth[0] * half, self.teeth[1] * half

    @property
    def base_radii(self) -> tuple[float, float]:
        """Radii of the base circles, r cos αt [m]."""
        first, second = self.reference_radii
        return first * math.cos(self.transverse_angle), second * math.cos(self.transverse_angle)

    @property
    def working_angle(self) -> float:
        """Working transverse pressure angle, cos αwt = (rb1 + rb2)/a [rad]."""
        return math.acos(sum(self.base_radii) / self.centre_distance)

    @property
    def base_helix_angle(self) -> float:
        """Helix angle on the base circle, sin βb = sin β cos αn [rad]."""
        return math.asin(math.sin(self.helix_angle) * math.cos(self.pressure_angle))

    @property
    def base_pitch(self) -> float:
        """Transverse base pitch, 2π rb1/z1 [m]."""
        return 2 * math.pi * self.base_radii[0] / self.teeth[0]

    @property
    def ratio(self) -> float:
        """Gear ratio z2/z1."""
        return self.teeth[1] / self.teeth[0]

    @property
    def path(self) -> Path:
        """Places A, B, D and E on the path of contact, from the pitch point [m]; see `Path`."""
        (rb1, rb2), (da1, da2) = self.base_radii, self.tip_diameters
        first, second = self.tangents
        e = math.sqrt(da1**2 / 4 - rb1**2) - first
        a = second - math.sqrt(da2**2 / 4 - rb2**2)
        return Path(a, e - self.base_pitch, a + self.base_pitch, e)

    @property
    def tangents(self) -> tuple[float, float]:
        """Distances from the pitch point to the tangent points on both base circles [m]."""
        tangent = math.tan(self.working_angle)
        return self.base_radii[0] * tangent, self.base_radii[1] * tangent

    @property
    def contact_ratio(self) -> float:
        """Transverse contact ratio εα: path of contact over base pitch."""
        return (self.path.e - self.path.a) / self.base_pitch

    @property
    def overlap_ratio(self) -> float:
        """Overlap ratio εβ = b sin β/(π mn)."""
        return self.face_width * math.sin(self.helix_angle) / (math.pi * self.module)

    def radii(self, place: float) -> tuple[float, float]:
        """Radii of curvature of both flanks at a place g, normal to the line of contact [m].

        The place is counted on the path of contact from the pitch point [m]. In the transverse
        section ρ1 = rb1 tan αwt + g and ρ2 = rb2 tan αwt − g. Normal to the line of contact, which
        is inclined by βb, they are larger by 1/cos βb.
        """
        first, second = self.tangents
        cosine = math.cos(self.base_helix_angle)
        return (first + place) / cosine, (second - place) / cosine

    def _faults(self) -> Iterator[str]:
        """Yield reasons why the gears cannot run; each check assumes that earlier ones passed."""
        distance, tolerance = self.centre_distance, _MISFIT * self.module
        fitting = fitting_distance(
            self.module, self.pressure_angle, self.helix_angle, self.teeth, self.profile_shifts
        )
        if abs(distance - fitting) > tolerance or distance <= sum(self.base_radii):
            yield (
                f"mesh.centre_distance is {_mm(distance)}, but the profile shifts fit "
                f"{_mm(fitting)}; give a distance within {_mm(tolerance)} of it, or other shifts"
            )
        for name, tip, base in zip(_GEARS, self.tip_diameters, self.base_radii, strict=True):
            if tip <= 2 * base:
                yield (
                    f"{name}.tip_diameter is {_mm(tip)}, inside the base circle, where there is no "
                    f"involute; give more than {_mm(2 * base)}"
                )
        if self.contact_ratio < 1 or not self.path.a < 0 < self.path.e:
            yield (
                f"the transverse contact ratio is {self.contact_ratio:.3g}, with contact from "
                f"{_mm(self.path.a)} to {_mm(self.path.e)}; give other tip diameters or profile "
                "shifts, for a ratio of at least 1 and contact at 0 mm, the pitch point"
            )
        # Radii of curvature where the tip of the other gear begins contact.
        begins = self.tangents[0] + self.path.a, self.tangents[1] - self.path.e
        for k, (begin, name) in enumerate(zip(begins, _GEARS, strict=True)):
            if begin <= 0 or begin < self.undercut(k):
                yield (
                    f"{name}.profile_shift is {self.profile_shifts[k]:g}: contact begins at a "
                    f"radius of curvature of {_mm(begin)}, and the involute at "
                    f"{_mm(self.undercut(k))}; give a larger shift, more teeth, or a smaller "
                    f"{_GEARS[1 - k]}.tip_diameter"
                )

    def undercut(self, gear: int) -> float:
        """Radius of curvature [m] below which the involute is undercut; 0 without undercut.

        `gear` is 0 for the pinion, 1 for the wheel. The tool is a standard rack, whose corner is a
        depth H below the pitch line. When the gear has turned by φ, the corner is at
        (rφ − H tan αt, r − H), with the reference radius r and the transverse pressure angle αt.
        The corner cuts away the flank below the point where the corner's path meets the flank.
        """
        r, rb, angle = self.reference_radii[gear], self.base_radii[gear], self.transverse_angle
        depth = (_TOOL_ADDENDUM - self.profile_shifts[gear]) * self.module
        if depth <= r * math.sin(angle) ** 2:
            return 0.0
        turned = np.linspace(-1.5, 1.5, 20001)
        along, above = r * turned - depth * math.tan(angle), r - depth
        radius = np.hypot(along, above)
        flank = np.sqrt(np.maximum((radius / rb) ** 2 - 1, 0.0))
        # Polar angles from the pitch point: of the corner, and of the flank at the same radius.
        corner = np.arctan2(along, above) - turned
        cut = corner - (flank - np.arctan(flank)) + involute(angle)
        inside = (radius > rb) & (radius < r) & (cut > 0)
        return float(rb * flank[inside].max()) if inside.any() else 0.0


_GEARS = ("pinion", "wheel")


def fitting_distance(
    module: float,
    pressure_angle: float,
    helix_angle: float,
    teeth: tuple[int, int],
    profile_shifts: tuple[float, float],
) -> float:
    """Centre distance without backlash [m], a = (r1 + r2) cos αt/cos αwt (ISO 21771:2007).

    The working angle follows from inv αwt = inv αt + 2 tan αn (x1 + x2)/(z1 + z2), with the numbers
    of `teeth` z and the profile shifts x of pinion and wheel. The module [m] and the pressure angle
    αn are in the normal section; angles are in radians. Raises an `InputError` if no distance fits.

    Examples
    --------
    >>> f"{fitting_distance(3e-3, math.radians(20), 0.0, (12, 24), (0.6, 0.36)):.6f}"
    '0.056500'
    """
    transverse = math.atan(math.tan(pressure_angle) / math.cos(helix_angle))
    shift = 2 * math.tan(pressure_angle) * sum(profile_shifts) / sum(teeth)
    value = involute(transverse) + shift
    if value <= 0:
        raise InputError(
            f"profile shifts of {profile_shifts[0]:g} and {profile_shifts[1]:g} fit no centre "
            "distance; their sum is too small for so few teeth"
        )
    reference = module / math.cos(helix_angle) * sum(teeth) / 2
    return reference * math.cos(transverse) / math.cos(involute_angle(value))


def _mm(length: float) -> str:
    return display(length, "mm", 4)
