"""Contact of the flanks along the path of contact: velocities, load, pressure, heat and film.

Everything here is for smooth flanks, in closed form. The rough, worn contact is simulated from the
scene that `pipeline.gears.scene` writes.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from pipeline.gears.involute import Involutes
from pipeline.gears.pair import Duty, Pair
from pipeline.gears.rules import Integral, friction_coefficient, integral_temperature
from tribo import analytic, contact_modulus
from tribo.analytic.heat import ROLLING_SLIDING_PEAK
from tribo.material import minimum_line_film


@dataclass(frozen=True, slots=True)
class MeshPlace:
    """The contact of pinion (1) and wheel (2) at one place on the path of contact.

    Radii are normal to the line of contact. Velocities of the flanks are relative to this line.
    """

    letter: str  #: Letter of the place, A to E; empty for places in between.
    position: float  #: Distance from the pitch point, positive towards the pinion's tip [m].
    radius_1: float  #: Radius of curvature of the pinion's flank [m].
    radius_2: float  #: Radius of curvature of the wheel's flank [m].
    reduced_radius: float  #: ρ1 ρ2/(ρ1 + ρ2) [m].
    rolling_1: float  #: Velocity of the pinion's flank [m/s].
    rolling_2: float  #: Velocity of the wheel's flank [m/s].
    sliding: float  #: rolling_1 − rolling_2, positive where the pinion's flank is faster [m/s].
    share: float  #: Share of the load that this pair of teeth carries.
    load: float  #: Normal load on this pair of teeth [N].
    load_per_length: float  #: Load per length of the line of contact [N/m].
    half_width: float  #: Half-width of the Hertz contact [m].
    pressure: float  #: Maximum Hertz pressure [Pa].
    flash: float  #: Maximum flash temperature after Blok [K].
    temperature: float  #: Bulk temperature + flash temperature [K].
    #: Minimum film thickness [m]; None without an oil, or if its pressure coefficient is unknown.
    film: float | None = None
    film_parameter: float | None = None  #: Λ, film over the combined Rq; None without a film.


@dataclass(frozen=True, slots=True)
class Mesh:
    """Contact at places along the path of contact of a pair of gears, at one duty."""

    pair: Pair
    duty: Duty
    friction: float  #: Mean coefficient of friction, given or by ISO/TR 13989-2.
    normal_load: float  #: Load on all pairs of teeth in mesh, normal to the flanks [N].
    places: tuple[MeshPlace, ...]

    @property
    def integral(self) -> Integral | None:
        """Integral temperatures by ISO/TR 13989-2; None without an oil."""
        return None if self.pair.oil is None else integral_temperature(self.pair, self.duty)


def mesh(pair: Pair, places: int = 25, duty: Duty | None = None) -> Mesh:
    """Compute the contact along the path of contact.

    The pinion has torque T and angular velocity ω1. In the transverse section the flanks have the
    velocities ui = ωi ρi, with their radii of curvature ρi. The load normal to the flanks is
    K T/(rb1 cos βb), with the load factor K, the pinion's base radius rb1 and the base helix angle
    βb. A pair of teeth carries the share `load_share` of this load, on a line of length b/cos βb,
    with the face width b. The Hertz contact is after Johnson, *Contact Mechanics*, Eqs. 4.43 and
    4.45, the flash temperature after Blok (`flash_rise`), and the film after Dowson & Higginson
    (`tribo.material.minimum_line_film`), with the oil at the bulk temperature.

    Parameters
    ----------
    pair : Pair
        Pair of gears from `read_pair`.
    places : int
        Number of evenly spaced places along the path, in addition to A to E.
    duty : Duty, optional
        Torque, speed and temperatures that replace the pair's own.

    Returns
    -------
    Mesh
        The mesh, with places in the order of their position. Between B and D a single pair of
        teeth is in contact; with a contact ratio of 2 or more, B and D are left out.

    Raises
    ------
    InputError
        If the pair has neither a coefficient of friction nor an oil.

    Examples
    --------
    >>> import pipeline.gears
    >>> mesh = pipeline.gears.mesh(pipeline.gears.read_pair("fzg_a"))
    >>> tip = mesh.places[-1]
    >>> f"{tip.letter}: {tip.sliding:.2f} m/s, {1e-6 * tip.pressure:.0f} MPa"
    'E: 5.59 m/s, 1140 MPa'
    """
    duty, gears = duty or pair.duty, pair.gears
    at = gears.path
    letters = {at.a: "A", at.b: "B", 0.0: "C", at.d: "D", at.e: "E"}
    if gears.contact_ratio >= 2:
        letters = {at.a: "A", 0.0: "C", at.e: "E"}
    even = np.linspace(at.a, at.e, max(places, 2)).tolist()
    positions = sorted({*even, *letters})
    coefficient = friction_coefficient(pair, duty)
    total = duty.load_factor * duty.torque / gears.base_radii[0]
    normal = total / math.cos(gears.base_helix_angle)
    found = tuple(
        _place(pair, duty, coefficient, normal, position, letters.get(position, ""))
        for position in positions
    )
    return Mesh(pair, duty, coefficient, normal, found)


def _place(
    pair: Pair, duty: Duty, friction: float, normal: float, position: float, letter: str
) -> MeshPlace:
    gears, cosine = pair.gears, math.cos(pair.gears.base_helix_angle)
    radius_1, radius_2 = gears.radii(position)
    reduced_radius = radius_1 * radius_2 / (radius_1 + radius_2)
    # Velocities need the radii in the transverse section.
    rolling = duty.speed * radius_1 * cosine, duty.speed / gears.ratio * radius_2 * cosine
    # Exactly 0 at the pitch point, where the difference of rolling velocities would be rounding.
    sliding = position * duty.speed * (1 + 1 / gears.ratio)
    share = load_share(gears, position, pair.file.mesh.quality)
    line, modulus = share * normal * cosine / gears.face_width, contact_modulus(*pair.materials)
    half_width = analytic.hertz_line_half_width(line, reduced_radius, modulus)
    pressure = analytic.hertz_line_peak_pressure(line, reduced_radius, modulus)
    effusivities = pair.materials[0].thermal_effusivity, pair.materials[1].thermal_effusivity
    flash = flash_rise(friction, line, half_width, rolling, effusivities) if sliding else 0.0
    film = parameter = None
    if pair.oil is not None and pair.oil.pressure_coefficients is not None:
        thick = pair.oil.viscosity(duty.bulk), pair.oil.pressure_coefficient(duty.bulk)
        film = minimum_line_film(sum(rolling) / 2, *thick, line, reduced_radius, modulus)
        parameter = film / pair.rms_roughness
    return MeshPlace(
        letter, position, radius_1, radius_2, reduced_radius, *rolling, sliding, share,
        share * normal, line, half_width, pressure, flash, duty.bulk + flash, film, parameter,
    )  # fmt: skip


def load_share(gears: Involutes, position: float, quality: int) -> float:
    """Share of the load that one pair of teeth carries at a place.

    For spur gears without tip relief it is 1 between B and D, rises from 1/3 at A to 2/3 at B, and
    falls from 2/3 at D to 1/3 at E (AGMA 925-A03, Eqs. 45 to 47), so that both pairs together carry
    the load. For tolerance classes Q above 7 it is (Q − 2)/15 at the ends, and 1/3 more at B and D,
    at most 1 (ISO/TR 13989-1:2000, 9.2). With a contact ratio of 2 or more, all pairs in mesh have
    equal shares. For helical gears with an overlap ratio εβ of at least 1 it is 1/εα, the mean
    along all lines of contact (ISO/TR 13989-1, 9.6). For a smaller εβ it is interpolated linearly
    in εβ between spur and helical gears, as Zε² of ISO 6336-2. The ends of helical teeth carry
    more, by the factor `buttressing`.

    Parameters
    ----------
    gears : Involutes
        The pair.
    position : float
        Place on the path of contact, from the pitch point [m].
    quality : int
        Flank tolerance class of ISO 1328-1.

    Examples
    --------
    >>> import pipeline.gears
    >>> gears = pipeline.gears.read_pair("fzg_a").gears
    >>> [round(load_share(gears, place, 5), 3) for place in (gears.path.a, 0.002, gears.path.e)]
    [0.333, 1.0, 0.333]
    """
    at, pitch = gears.path, gears.base_pitch
    ratio, overlap = gears.contact_ratio, min(gears.overlap_ratio, 1.0)
    if ratio >= 2:
        turns = np.arange(-math.ceil(ratio), math.ceil(ratio) + 1) * pitch + position
        inside = (turns >= at.a - 1e-12) & (turns <= at.e + 1e-12)
        alone = 1 / int(inside.sum())
    elif at.b <= position <= at.d:
        alone = 1.0
    else:
        at_end = (max(quality, 7) - 2) / 15
        far = (position - at.a) if position < at.b else (at.e - position)
        alone = min(at_end + far / (at.b - at.a) / 3, 1.0)
    return ((1 - overlap) * alone + overlap / ratio) * buttressing(gears, position)


def buttressing(gears: Involutes, position: float) -> float:
    """Factor on the load near both ends of the path of contact, where helical teeth are stiffer.

    `position` is the distance along the path from the pitch point [m]. At the ends A and E the
    factor is 1 + 0.3 εβ, with the overlap ratio εβ, or 1.3 if εβ is above 1. The factor falls
    linearly to 1 over a length of 0.2 l sin βb from each end. Here βb is the base helix angle, and
    l the distance from the pitch point to the tangent point on the pinion's base circle (ISO/TR
    13989-1:2000, Eqs. 49 to 56, quoted from a secondary source). The load elsewhere is not reduced,
    which is on the safe side.

    Examples
    --------
    >>> import pipeline.gears
    >>> spur = ["mesh.centre_distance", "pinion.tip_diameter", "wheel.tip_diameter"]
    >>> helical = {"without": spur, "mesh.helix_angle": "20 deg", "mesh.face_width": "50 mm"}
    >>> gears = pipeline.gears.read_pair("fzg_a", helical).gears
    >>> [round(buttressing(gears, place), 3) for place in (gears.path.a, 0.0, gears.path.e)]
    [1.3, 1.0, 1.3]
    """
    width = 0.2 * math.sin(gears.base_helix_angle) * gears.tangents[0]
    inside = min(position - gears.path.a, gears.path.e - position)
    near = max(1 - inside / width, 0.0) if width else 0.0
    return 1 + 0.3 * min(gears.overlap_ratio, 1.0) * near


def flash_rise(
    friction: float,
    load_per_length: float,
    half_width: float,
    velocities: tuple[float, float],
    effusivities: tuple[float, float],
) -> float:
    """Maximum flash temperature of a line contact of two rolling and sliding bodies [K].

    ``θ = 1.11 µ w |u1 − u2|/((e1 √u1 + e2 √u2) √(2b))`` with the friction µ, the load per length w
    [N/m], the velocities u [m/s] of both surfaces, the half-width b [m] and the effusivities e =
    √(Kρc) (Blok 1937, for a Hertz pressure; ISO/TR 13989-1:2000, Eq. (3) and AGMA 925-A03). For
    equal bodies it equals `tribo.analytic.heat.rolling_sliding_rise`.

    Examples
    --------
    >>> f"{flash_rise(0.05, 1e5, 1e-4, (15.0, 25.0), (12844.05, 12844.05)):.1f} K"
    '34.5 K'
    """
    (u1, u2), (e1, e2) = velocities, effusivities
    heat = friction * load_per_length * abs(u1 - u2)
    spread = e1 * math.sqrt(u1) + e2 * math.sqrt(u2)
    return ROLLING_SLIDING_PEAK["hertz"] * heat / (spread * math.sqrt(2 * half_width))
