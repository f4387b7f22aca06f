"""The contact along the mesh: velocities, shares, pressure, heat, film; and the standard's rule."""

import math
from dataclasses import replace

import numpy as np
import pytest

import pipeline.gears as gears
from pipeline.gears.contact import buttressing, flash_rise, load_share
from tribo import Material, analytic, contact_modulus

FZG = "fzg_a"
STEEL = Material(206e9, 0.3, 50.0, 7850.0, 3.8e6 / 7850)  # as in ISO/TR 13989-2, clause 5.3
PRESSURES = 146, 295, 474, 621, 773, 927, 1080, 1232, 1386, 1539, 1691, 1841
"""At the pitch point by load stage [MPa], as tables of the test give them, of one pair alone."""


def place_named(mesh, letter):
    return next(place for place in mesh.places if place.letter == letter)


def stage_duty(pair, stage):
    return gears.Duty(gears.stage_torque(stage), pair.duty.speed, gears.stage_bulk(stage))


@pytest.fixture(scope="module")
def fzg():
    return gears.read_pair(FZG)


@pytest.fixture(scope="module")
def mesh(fzg):
    return gears.mesh(fzg)


def test_sliding_is_none_at_the_pitch_point_and_grows_as_the_distance_from_it(mesh):
    assert place_named(mesh, "C").sliding == 0
    assert place_named(mesh, "C").flash == 0
    turning = 2170 * 2 * math.pi / 60 * (1 + 16 / 24)
    for place in mesh.places:
        assert place.sliding == pytest.approx(place.position * turning)
        assert place.rolling_1 - place.rolling_2 == pytest.approx(place.sliding, abs=1e-12)
    assert place_named(mesh, "E").sliding == pytest.approx(5.59, abs=5e-3)


def test_pressures_of_the_load_stages_are_those_of_the_tables_of_the_test(fzg):
    of_steel = replace(fzg, materials=(STEEL, STEEL))
    for stage, printed in enumerate(PRESSURES, 1):
        pitch = place_named(gears.mesh(of_steel, duty=stage_duty(fzg, stage)), "C")
        alone = 1e-6 * pitch.pressure / math.sqrt(pitch.share)
        assert alone == pytest.approx(printed, rel=0.01)


@pytest.mark.parametrize("quality", [3, 7])
def test_two_pairs_carry_all_of_the_load_wherever_two_are_in_mesh(fzg, quality):
    path, pitch = fzg.gears.path, fzg.gears.base_pitch
    for place in np.linspace(path.a + 1e-6, path.b - 1e-6, 7):
        both = [load_share(fzg.gears, where, quality) for where in (place, place + pitch)]
        assert sum(both) == pytest.approx(1.0)
    assert load_share(fzg.gears, 0.5 * (path.b + path.d), quality) == 1.0


def test_a_wide_helical_pair_has_a_mean_load_on_lines_that_lean():
    helical = {"mesh.helix_angle": "25 deg", "mesh.centre_distance": "100 mm",
               "mesh.face_width": "60 mm", "pinion.profile_shift": 0.3,
               "wheel.profile_shift": -0.14, "pinion.tip_diameter": "90 mm",
               "wheel.tip_diameter": "126 mm"}  # fmt: skip
    pair = gears.read_pair(FZG, helical)
    mesh, toothing = gears.mesh(pair), pair.gears
    assert toothing.overlap_ratio > 1
    inner = [place for place in mesh.places if buttressing(toothing, place.position) == 1]
    assert 20 < len(inner) < len(mesh.places)
    for place in inner:
        assert place.share == pytest.approx(1 / toothing.contact_ratio)
        assert place.rolling_1 - place.rolling_2 == pytest.approx(place.sliding, abs=1e-9)
        # On average the lines of contact are together εα b/cos βb long, and carry the whole load.
        lines = toothing.contact_ratio * 60e-3 / math.cos(toothing.base_helix_angle)
        assert place.load_per_length * lines == pytest.approx(mesh.normal_load)
    torque = mesh.normal_load * math.cos(toothing.base_helix_angle) * toothing.base_radii[0]
    assert torque == pytest.approx(pair.duty.torque)


def test_pressure_and_width_are_those_of_hertz(mesh, fzg):
    for place in mesh.places:
        total = math.pi / 2 * place.pressure * place.half_width
        assert total == pytest.approx(place.load_per_length)
        reduced = 1 / (1 / place.radius_1 + 1 / place.radius_2)
        modulus = contact_modulus(*fzg.materials)
        width = 2 * math.sqrt(place.load_per_length * reduced / (math.pi * modulus))
        assert place.half_width == pytest.approx(width)


def test_the_flash_is_bloks_of_like_and_of_unlike_bodies(mesh, fzg):
    effusivity = fzg.materials[0].thermal_effusivity
    tip = place_named(mesh, "E")
    alike = analytic.heat.rolling_sliding_rise(
        mesh.friction, tip.load_per_length, 2 * tip.half_width, (tip.rolling_1, tip.rolling_2),
        effusivity,
    )  # fmt: skip
    assert tip.flash == pytest.approx(alike)
    # Against an insulator all heat goes into the first body, whose own velocity counts.
    against = flash_rise(0.1, 1e5, 1e-4, (4.0, 1.0), (12000.0, 0.0))
    own = 1.11 * 0.1 * 1e5 * 3.0 / (12000 * 2.0 * math.sqrt(2e-4))
    assert against == pytest.approx(own, rel=5e-3)


def test_the_film_is_over_the_roughness_of_both_flanks(mesh, fzg):
    rq = math.sqrt(math.pi / 2) * math.hypot(0.35e-6, 0.35e-6)
    for place in mesh.places:
        assert place.film_parameter == pytest.approx(place.film / rq)
    # By hand at E: U 3.73·2.34e-3/(226.8e9·5.09e-3), G 9.4e-9·226.8e9, W 1.836e5/(226.8e9·5.09e-3).
    thick = fzg.oil.viscosity(fzg.duty.bulk), fzg.oil.pressure_coefficient(fzg.duty.bulk)
    modulus, radius = 2 * contact_modulus(*fzg.materials), place_named(mesh, "E").reduced_radius
    speed = (place_named(mesh, "E").rolling_1 + place_named(mesh, "E").rolling_2) / 2
    film = 2.65 * (thick[0] * speed / (modulus * radius)) ** 0.7 * (thick[1] * modulus) ** 0.54
    film *= (place_named(mesh, "E").load_per_length / (modulus * radius)) ** -0.13 * radius
    assert place_named(mesh, "E").film == pytest.approx(film)


def test_the_rule_for_a_pair_meets_the_rule_for_the_test_gears(fzg):
    """0.2 T1 of Eq. (96) was fitted to Eqs. (1) to (45) for these gears, so both must agree."""
    rig = replace(fzg, materials=(STEEL, STEEL))
    for stage in range(5, 13):
        found = gears.integral_temperature(rig, stage_duty(rig, stage))
        assert found.mean_flash == pytest.approx(0.2 * gears.stage_torque(stage), rel=0.04)


def test_stages_grow_as_their_squares_and_limits_with_them():
    """T1 = 3.726 (stage)², Eq. (97), within the rounding of the table; the first stages differ."""
    for stage in range(4, 13):
        assert gears.stage_torque(stage) == pytest.approx(3.726 * stage**2, rel=0.02)
    limits = [gears.scuffing_integral(stage, 100e-6) for stage in range(1, 13)]
    assert limits == sorted(limits)
    nitrided = gears.scuffing_integral(12, 100e-6, welding_factor=1.5)
    assert nitrided - limits[-1] == pytest.approx(0.5 * 1.5 * 0.2 * 534.5)


def test_friction_is_that_of_the_rule_by_hand(fzg):
    """w = 2·372.6/0.072/20 N/mm, vΣ = 2·8.181·tan 22.439°·cos 20°, ρ = 8.382 mm, Ra 0.35 µm."""
    duty = stage_duty(fzg, 10)
    thin = (1e3 * fzg.oil.viscosity(duty.bulk)) ** -0.05
    by_hand = 0.045 * (517.5 / (6.350 * 8.382)) ** 0.2 * thin * 2.2 * (0.35 / 8.382) ** 0.25
    assert gears.friction_coefficient(fzg, duty) == pytest.approx(by_hand, rel=1e-3)
    light = gears.Duty(1.0, duty.speed, duty.bulk), gears.Duty(50.0, duty.speed, duty.bulk)
    assert gears.friction_coefficient(fzg, light[0]) == gears.friction_coefficient(fzg, light[1])


FINE = {"mesh.module": "2 mm", "mesh.centre_distance": "100 mm", "pinion.teeth": 40,
        "wheel.teeth": 60, "pinion.profile_shift": 0, "wheel.profile_shift": 0}  # fmt: skip


@pytest.mark.parametrize(
    ("tips", "approach"),
    [
        (None, 1.0),
        (("82.4 mm", "125 mm"), 1.4 - 4 / 15 * 2.02187),  # twice as long on the wheel's side
        (("81.6 mm", "126 mm"), 0.6),  # more than three times as long
    ],
)
def test_flashes_are_those_of_the_rule_by_hand(tips, approach):
    """Eqs. (10) to (19) and (41) for steel of Eq. (11), by radii of curvature at the tip, in mm."""
    names = "pinion.tip_diameter", "wheel.tip_diameter"
    changes = FINE | dict(zip(names, tips, strict=True)) if tips else {}
    rig = gears.read_pair(FZG, {"friction.coefficient": 0.07} | changes)
    rig = replace(rig, materials=(STEEL, STEEL))
    end, toothing = place_named(gears.mesh(rig), "E"), rig.gears
    duty = stage_duty(rig, 9)
    first, second = 1e3 * end.radius_1, 1e3 * end.radius_2
    u, working, pressure = 1.5, toothing.working_angle, math.radians(20)
    geometry = 0.51 * math.sqrt(u + 1) * (math.sqrt(first) - math.sqrt(second / u))
    geometry /= (first * second) ** 0.25
    angle = 1.22 * (math.sin(working) * math.cos(pressure)) ** 0.25
    angle /= math.sqrt(math.cos(working) * math.cos(pressure))
    radius = 40.0 if tips else 4.5 * 16 / 2  # radius of the pinion's reference circle [mm]
    load, speed = 1e3 * duty.torque / radius / 20, duty.speed * radius / 1e3
    e1, e2 = (abs(length) / toothing.base_pitch for length in (toothing.path.e, toothing.path.a))
    long, short = max(e1, e2), min(e1, e2)
    assert short < 1 < long < e1 + e2 < 2
    relief = 1 + 0.06 * long + 0.02 * long**2
    heat = math.sqrt(1000) * (206e3 / 0.91) ** 0.25 / (1e-3 * math.sqrt(50.0 * 3.8e6))
    assert heat == pytest.approx(50.0, rel=2e-3)  # the standard gives three digits
    tip = 0.07 * heat * geometry * angle * load**0.75 * math.sqrt(speed)
    tip /= (1e3 * toothing.centre_distance) ** 0.25 * approach * relief
    share = 0.18 * long**2 + 0.70 * short**2 + 0.82 * long - 0.52 * short - 0.30 * long * short
    share /= 2 * (e1 + e2) * e1
    found = gears.integral_temperature(rig, duty)
    assert found.tip_flash == pytest.approx(tip, rel=1e-5)  # path lengths have six digits
    assert found.mean_flash == pytest.approx(share * found.tip_flash, rel=1e-9)


def test_the_mean_flash_has_no_jump_where_the_standard_takes_another_formula():
    """Eqs. (39) to (44), between 1 and 2 pairs in mesh, longer ends, and 2 pairs or more."""
    rig = FINE | {"friction.coefficient": 0.07}
    factors, ends = [], []
    for longer in np.linspace(0.0, 2.4, 241):
        tips = {f"{name}.tip_diameter": f"{over + longer} mm"
                for name, over in (("pinion", 84), ("wheel", 124))}  # fmt: skip
        pair = gears.read_pair(FZG, rig | tips)
        found, toothing = gears.integral_temperature(pair, pair.duty), pair.gears
        first, second = toothing.path.e, -toothing.path.a
        whole = 2 * (first + second) * first / toothing.base_pitch**2
        factors.append(found.mean_flash / found.tip_flash * whole)
        ends.append((max(first, second) / toothing.base_pitch, toothing.contact_ratio))
    assert np.less(ends[0], (1, 2)).all()
    assert np.greater(ends[-1], (1, 2)).all()
    assert np.abs(np.diff(factors, 2)).max() < 0.001


def test_a_spur_pair_is_that_of_another_program():
    """Expected values: GEARpie (github.com/cfernandesFEUP/GEARpie), REPORT/C14.txt."""
    c14 = {"mesh.face_width": "14 mm", "pinion.profile_shift": 0.1817, "duty.speed": "1500 rpm",
           "wheel.profile_shift": 0.1715, "pinion.tip_diameter": "82.636 mm",
           "wheel.tip_diameter": "118.544 mm", "duty.torque": "200 N m",
           "temperature.bulk": "100 degC"}  # fmt: skip
    pair = replace(gears.read_pair(FZG, c14), materials=(STEEL, STEEL))
    found, (a, b, d, e) = gears.mesh(pair), pair.gears.path
    assert pair.gears.contact_ratio == pytest.approx(1.46, abs=5e-3)
    assert 1e3 * sum(pair.gears.tangents) == pytest.approx(34.93, abs=5e-3)
    for printed, length in ((6.14, b - a), (9.68, -a), (13.28, d - a), (19.43, e - a)):
        assert 1e3 * length == pytest.approx(printed, abs=6e-3)
    assert found.normal_load == pytest.approx(5912.1, abs=0.1)
    pitch = place_named(found, "C")
    assert pitch.share == 1
    assert 1e-6 * pitch.pressure == pytest.approx(1347.3, abs=0.2)
    assert 1e6 * pitch.half_width == pytest.approx(199.567, rel=2e-4)
    highest = max(place.pressure for place in found.places)
    assert 1e-6 * highest == pytest.approx(1442.5, abs=1)


def test_a_helical_pair_is_that_of_another_program():
    """Expected values: GEARpie (github.com/cfernandesFEUP/GEARpie), REPORT/H501.txt."""
    h501 = {"mesh.module": "3.5 mm", "mesh.helix_angle": "15 deg", "mesh.face_width": "23 mm",
            "pinion.teeth": 20, "wheel.teeth": 30, "pinion.profile_shift": 0.1809,
            "wheel.profile_shift": 0.0891, "pinion.tip_diameter": "80.672 mm",
            "wheel.tip_diameter": "116.264 mm", "duty.torque": "100 N m",
            "temperature.bulk": "100 degC"}  # fmt: skip
    toothing = gears.read_pair(FZG, h501).gears
    found, (a, b, d, e) = gears.mesh(gears.read_pair(FZG, h501)), toothing.path
    assert toothing.contact_ratio == pytest.approx(1.46, abs=5e-3)
    assert toothing.overlap_ratio == pytest.approx(0.54, abs=5e-3)
    assert 1e3 * toothing.base_pitch == pytest.approx(10.652, abs=1e-3)
    assert 1e3 * sum(toothing.tangents) == pytest.approx(34.45, abs=5e-3)
    for printed, length in ((4.90, b - a), (7.48, -a), (10.65, d - a), (15.55, e - a)):
        assert 1e3 * length == pytest.approx(printed, abs=1e-2)
    assert found.normal_load == pytest.approx(3040.5, abs=0.1)
