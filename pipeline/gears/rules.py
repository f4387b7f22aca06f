"""The scuffing rule of ISO/TR 13989-2: the integral temperature.

ISO/TR 13989-2:2000 was before it DIN 3990-4, and is now ISO/TS 6336-21:2022. Equations are numbered
as there. They were taken from programs that cite the standard, not from the standard itself. They
hold for external gears with contact ratios up to 2.5 and pitch line velocities from 1 to 50 m/s.
The rule was fitted to tests of gears; oils are rated by load stages of FZG's test.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, replace

from pipeline.gears.pair import Duty, Pair
from pipeline.quantities import display
from pipeline.scene.library import library
from tribo import InputError, contact_modulus

STAGES: tuple[float, ...] = tuple(library()["machines"]["FZG"]["stages"])
"""Torque on the pinion in FZG's test A/8.3/90, by load stage from 1 on [N m] (ISO 14635-1)."""
_LEAST_LOAD = 150.0  # load per face width [N/mm] below which friction is constant (clause 5.1)
_FASTEST = 50.0  # pitch line velocity [m/s] above which the rule takes friction as constant
_BULK_SHARE, _WEIGHT = 0.7, 1.5  # C1 and C2
_ROUNDS = 10  # iterations; friction and bulk temperature converge within 1e-9 K


@dataclass(frozen=True, slots=True)
class Integral:
    """Integral temperature of a pair by ISO/TR 13989-2 [K], and the values that it follows from.

    `friction` is the mean coefficient of friction. `tip_flash` is the rise above the bulk [K] at
    the pinion's tip under the whole load. `mean_flash` is the mean rise along the path of contact.
    """

    friction: float  #: Mean coefficient of friction, Eq. (1).
    tip_flash: float  #: Flash temperature at the pinion's tip under the whole load, Eq. (19).
    mean_flash: float  #: Mean flash temperature along the path of contact, Eq. (18).
    integral: float  #: Integral temperature: bulk + 1.5 × mean flash, Eq. (17).


def stage_torque(stage: int) -> float:
    """Torque on the pinion in a load stage of FZG's test A/8.3/90 [N m].

    Examples
    --------
    >>> stage_torque(12)
    534.5
    """
    if not 1 <= stage <= len(STAGES):
        raise InputError(f"load stage is {stage}; FZG A/8.3/90 has 1 to {len(STAGES)}")
    return STAGES[stage - 1]


def stage_bulk(stage: int, lubricant_factor: float = 1.0) -> float:
    """Bulk temperature of FZG's test gears in a load stage [K], ISO/TR 13989-2, Eq. (95).

    The temperature is 80 °C + 0.23 T1 XL with the torque T1 [N m] and the lubricant factor XL, 1
    for mineral oils.

    Examples
    --------
    >>> f"{stage_bulk(12) - 273.15:.1f} °C"
    '202.9 °C'
    """
    return 273.15 + 80 + 0.23 * stage_torque(stage) * lubricant_factor


def scuffing_integral(
    stage: int,
    viscosity_40: float,
    lubricant_factor: float = 1.0,
    welding_factor: float = 1.0,
) -> float:
    """Scuffing integral temperature [K] of an oil that fails in a load stage of FZG's test.

    ISO/TR 13989-2, Eq. (94): θ = θM + 1.5 XW θfl with θM of `stage_bulk` and, by Eq. (96), θfl =
    0.2 T1 (100/ν40)^0.02 XL. T1 is the torque on the pinion [N m], and ν40 is in mm²/s.

    Parameters
    ----------
    stage : int
        Failure load stage in FZG A/8.3/90.
    viscosity_40 : float
        Kinematic viscosity at 40 °C [m²/s].
    lubricant_factor, welding_factor : float
        XL: 1 mineral, 0.8 polyalphaolefin, 0.7 or 0.6 polyglycol, 1.3 phosphate ester, 1.5 traction
        fluid; XW: 1 case-hardened steel, 1.5 nitrided steel.

    Examples
    --------
    >>> f"{scuffing_integral(10, 100e-6) - 273.15:.1f} °C"
    '277.5 °C'
    """
    torque = stage_torque(stage)
    thin: float = (100 / (1e6 * viscosity_40)) ** 0.02
    flash = 0.2 * torque * thin * lubricant_factor
    return stage_bulk(stage, lubricant_factor) + _WEIGHT * welding_factor * flash


def friction_coefficient(pair: Pair, duty: Duty) -> float:
    """Mean coefficient of friction of a mesh: from the file, else by ISO/TR 13989-2, Eq. (1).

    µ = 0.045 (w KBγ/(vΣC ρC))^0.2 η^−0.05 XR XL, with the load per face width w [N/mm], at least
    150; the helical load factor KBγ; the lubricant factor XL; the sum velocity vΣC [m/s] and the
    reduced radius ρC [mm] at the pitch point; the oil's viscosity η [mPa s], here at the bulk
    temperature; and XR = 2.2 (Ra/ρC)^0.25 with the mean Ra [µm] of both flanks. vΣC is that at a
    pitch line velocity of at most 50 m/s. Raises an `InputError` if the rule is needed, but there
    is no oil.
    """
    if pair.file.friction.coefficient is not None:
        return pair.file.friction.coefficient
    if pair.oil is None:
        raise InputError(
            "friction.coefficient is not given, and its rule needs an oil; give the coefficient "
            "or [oil]"
        )
    gears = pair.gears
    load = _unit_load(pair, duty) * 1e-3  # [N/mm]
    speed = min(_line_velocity(pair, duty), _FASTEST)
    total = 2 * speed * math.tan(gears.working_angle) * math.cos(gears.transverse_angle)
    first, second = gears.radii(0.0)
    radius = 1e3 * first * second / (first + second)  # [mm]
    rough = 2.2 * (1e6 * sum(pair.roughness) / 2 / radius) ** 0.25
    thin = (1e3 * pair.oil.viscosity(duty.bulk)) ** -0.05
    helical = _helical_load(gears.contact_ratio + gears.overlap_ratio)
    loaded = (max(load, _LEAST_LOAD) * helical / (total * radius)) ** 0.2
    return float(0.045 * loaded * thin * rough * pair.file.friction.lubricant_factor)


def integral_temperature(pair: Pair, duty: Duty) -> Integral:
    """Integral temperature of a pair at a duty, by ISO/TR 13989-2, Eqs. (17) to (45).

    The teeth have no tip relief. The bulk temperature is given by the duty; `warm_duty` computes it
    from the oil temperature.
    """
    gears = pair.gears
    friction = friction_coefficient(pair, duty)
    (rb1, _), tip_radius = gears.base_radii, gears.tip_diameters[0] / 2
    u, a, working = gears.ratio, gears.centre_distance, gears.working_angle
    tip = 1e3 * math.sqrt(tip_radius**2 - rb1**2)  # [mm]
    other = 1e3 * a * math.sin(working) - tip
    geometry = (
        0.51 * math.sqrt(u + 1) * (math.sqrt(tip) - math.sqrt(other / u)) / (tip * other) ** 0.25
    )
    angle = (
        1.22 * (math.sin(working) * math.cos(gears.pressure_angle) * math.cos(gears.helix_angle))
        ** 0.25 / math.sqrt(math.cos(working) * math.cos(gears.transverse_angle))
    )  # fmt: skip
    # XM of Eq. (11), with the mean effusivity of different bodies; 50.0 for the standard's steel.
    effusivity = sum(body.thermal_effusivity for body in pair.materials) / 2
    modulus = 2 * contact_modulus(*pair.materials) * 1e-6  # E/(1 − ν²) [N/mm²]
    heat = math.sqrt(1000) * modulus**0.25 / (effusivity * 1e-3)
    eps1, eps2 = gears.path.e / gears.base_pitch, -gears.path.a / gears.base_pitch
    load = 1e-3 * _unit_load(pair, duty) * _helical_load(gears.contact_ratio + gears.overlap_ratio)
    top = max(eps1, eps2)
    relief = 1 + 0.06 * top + 0.02 * top**2
    approach = min(max(1.4 - 4 / 15 * eps2 / eps1, 0.6), 1.0)
    at_tip = (
        friction * heat * geometry * angle * load**0.75 * math.sqrt(_line_velocity(pair, duty))
        / (1e3 * a) ** 0.25 / (approach * relief)
    )  # fmt: skip
    mean = at_tip * _contact_ratio_factor(eps1, eps2)
    return Integral(friction, at_tip, mean, duty.bulk + _WEIGHT * mean)


def warm_duty(
    pair: Pair,
    torque: float,
    speed: float,
    bulk: float | None = None,
    load_factor: float | None = None,
    oil: float | None = None,
) -> Duty:
    """Duty of a pair, with its bulk temperature given or computed.

    If `bulk` is None, an oil temperature θ gives the bulk temperature θ + 0.7 × mean flash
    temperature (ISO/TR 13989-2, Eq. 20). It is found by iteration, as friction depends on the
    viscosity at the bulk temperature. Without θ the bulk temperature is the pair's, but only for
    the pair's own duty.

    Parameters
    ----------
    pair : Pair
        The pair.
    torque, speed : float
        Torque [N m] and angular velocity [rad/s] of the pinion.
    bulk : float, optional
        Bulk temperature of the teeth [K].
    load_factor : float, optional
        Factor on the load; the pair's by default.
    oil : float, optional
        Temperature of the oil [K]; the pair's by default.

    Raises
    ------
    InputError
        If a duty other than the pair's has neither bulk nor oil temperature.
    """
    duty = Duty(torque, speed, bulk or pair.duty.bulk, load_factor or pair.duty.load_factor)
    oil = oil or pair.file.temperature.oil
    if bulk or (oil is None and duty == pair.duty):
        return duty
    if oil is None:
        raise InputError(
            f"the bulk temperature of the file, {display(duty.bulk, '°C', 4)}, holds for its own "
            "duty, and another duty heats the teeth differently; give the bulk temperature of this "
            "duty, or the temperature of the oil"
        )
    for _ in range(_ROUNDS):
        warmer = _BULK_SHARE * integral_temperature(pair, duty).mean_flash
        duty = replace(duty, bulk=oil + warmer)
    return duty


def _unit_load(pair: Pair, duty: Duty) -> float:
    """Tangential load on the reference circle per face width [N/m], ISO/TR 13989-2, Eq. (4)."""
    radius = pair.gears.reference_radii[0]
    return duty.load_factor * duty.torque / radius / pair.gears.face_width


def _line_velocity(pair: Pair, duty: Duty) -> float:
    return duty.speed * pair.gears.reference_radii[0]


def _helical_load(ratio: float) -> float:
    """Helical load factor KBγ from the total contact ratio, ISO/TR 13989-2, Eq. (5).

    >>> [round(_helical_load(ratio), 4) for ratio in (1.5, 2.0, 2.5, 3.5, 4.0)]
    [1.0, 1.0, 1.2236, 1.3, 1.3]
    """
    if ratio <= 2:
        return 1.0
    return 1 + 0.2 * math.sqrt((ratio - 2) * (5 - ratio)) if ratio < 3.5 else 1.3


def _contact_ratio_factor(eps1: float, eps2: float) -> float:
    """Contact ratio factor Xε of ISO/TR 13989-2, Eqs. (39) to (44).

    Xε is the mean flash temperature along the path of contact, over the flash temperature at the
    pinion's tip under the whole load. `eps1` and `eps2` are the addendum contact ratios of pinion
    and wheel, whose sum is the transverse contact ratio.
    """
    total, long, short = eps1 + eps2, max(eps1, eps2), min(eps1, eps2)
    if total < 2 and long < 1:
        value = 0.70 * (eps1**2 + eps2**2) - 0.22 * total + 0.52 - 0.60 * eps1 * eps2
    elif total < 2:
        value = 0.18 * long**2 + 0.70 * short**2 + 0.82 * long - 0.52 * short - 0.30 * long * short
    else:
        value = 0.44 * long**2 + 0.59 * short**2 + 0.30 * (long - short) - 0.15 * long * short
    return value / (2 * total * eps1)
