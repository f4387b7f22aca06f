"""Geometry of involutes against closed forms, and worked examples."""

import math

import pytest

from pipeline.gears.involute import Involutes, fitting_distance
from pipeline.gears.reading import tip_diameter
from tribo import InputError

TWENTY = math.radians(20)
FZG = {
    "module": 4.5e-3, "pressure_angle": TWENTY, "helix_angle": 0.0, "teeth": (16, 24),
    "profile_shifts": (0.8532, -0.5), "centre_distance": 91.5e-3,
    "tip_diameters": (88.77e-3, 112.5e-3), "face_width": 20e-3,
}  # fmt: skip


def pair(**changed):
    return Involutes(**FZG | changed)


def plain(z1, z2, module=1.0, angle=TWENTY, helix=0.0, shifts=(0.0, 0.0)):
    """Pair of gears at the centre distance without backlash, with tips of the basic rack."""
    toothing = module, angle, helix
    apart = fitting_distance(*toothing, (z1, z2), shifts)
    tips = [tip_diameter(module, helix, (z1, z2), shifts, apart, k) for k in (0, 1)]
    return Involutes(
        module=module, pressure_angle=angle, helix_angle=helix, teeth=(z1, z2),
        profile_shifts=shifts, centre_distance=apart, tip_diameters=tuple(tips), face_width=10.0,
    )  # fmt: skip


def test_a_worked_example_of_shifted_gears():
    """bolsover.com, *Profile Shifted External Spur Gears*: m 3 mm, 12 and 24 teeth, x 0.6, 0.36."""
    gears = plain(12, 24, module=3.0, shifts=(0.6, 0.36))
    assert gears.centre_distance == pytest.approx(56.4999, abs=1e-4)
    assert math.degrees(gears.working_angle) == pytest.approx(26.0886, abs=3e-4)
    assert 2 * gears.base_radii[0] == pytest.approx(33.8289, abs=5e-5)
    assert 2 * gears.base_radii[1] == pytest.approx(67.6579, abs=5e-5)
    assert gears.tip_diameters == pytest.approx((44.840, 79.400), abs=5e-4)
    assert gears.contact_ratio == pytest.approx(1.202, abs=5e-4)


def test_the_test_gears_of_fzg_by_hand():
    """ISO 14635-1 gives the dimensions; by hand: inv αwt 0.021332, αwt 22.44°, εα 1.36."""
    gears = pair()
    value = math.tan(gears.working_angle) - gears.working_angle
    by_shifts = 0.0149044 + 2 * 0.3639702 * 0.3532 / 40
    assert value == pytest.approx(by_shifts, rel=2e-4)
    e = math.sqrt(44.385**2 - 33.829**2) - 33.829 * math.tan(gears.working_angle)
    assert 1e3 * gears.path.e == pytest.approx(e, abs=2e-3)
    pitch = math.pi * 4.5 * math.cos(TWENTY)
    assert 1e3 * gears.base_pitch == pytest.approx(pitch)
    assert gears.contact_ratio == pytest.approx((e + 3.3177) / pitch, abs=2e-4)


def test_a_wheel_of_very_many_teeth_is_a_rack():
    """On the rack's side the path beyond the pitch point is m/sin α, and its radius infinite."""
    gears = plain(24, 1_000_000)
    assert gears.path.a == pytest.approx(-1 / math.sin(TWENTY), rel=1e-4)
    assert gears.radii(0.0)[1] > 1e5
    first, second = gears.radii(0.3)
    assert first * second / (first + second) == pytest.approx(12 * math.sin(TWENTY) + 0.3, rel=1e-4)


def test_a_worked_example_of_a_helical_pair():
    """KHK, *Gear technical reference*: mn 3 mm, αn 20°, β 30°, 12 and 60 teeth, x1 0.09809."""
    gears = plain(12, 60, module=3.0, helix=math.radians(30), shifts=(0.09809, 0.0))
    assert math.degrees(gears.transverse_angle) == pytest.approx(22.79588, abs=1e-5)
    assert math.degrees(gears.working_angle) == pytest.approx(23.1126, abs=1e-4)
    assert gears.centre_distance == pytest.approx(125.0, abs=1e-3)


def test_a_helical_pair_is_a_spur_pair_of_its_transverse_section():
    helix = math.radians(15)
    helical = plain(20, 31, helix=helix)
    module = 1 / math.cos(helix)
    spur = Involutes(
        module=module, pressure_angle=helical.transverse_angle, helix_angle=0.0, teeth=(20, 31),
        profile_shifts=(0.0, 0.0), centre_distance=helical.centre_distance,
        tip_diameters=helical.tip_diameters, face_width=10.0,
    )  # fmt: skip
    assert helical.path == pytest.approx(spur.path)
    lean = math.cos(helical.base_helix_angle)
    for mine, plane in zip(helical.radii(0.1), spur.radii(0.1), strict=True):
        assert mine * lean == pytest.approx(plane)
    assert helical.overlap_ratio == pytest.approx(10 * math.sin(helix) / math.pi)


def test_a_centre_distance_may_be_a_tenth_of_a_module_off():
    fitting = fitting_distance(4.5e-3, TWENTY, 0.0, (16, 24), (0.8532, -0.5))
    for side in (-1, 1):
        pair(centre_distance=fitting + side * 0.099 * 4.5e-3)
        with pytest.raises(
            InputError, match=r"fit 91\.5 mm; give a distance within 0\.45 mm of it"
        ):
            pair(centre_distance=fitting + side * 0.101 * 4.5e-3)
