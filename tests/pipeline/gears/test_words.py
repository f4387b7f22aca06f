"""What is said of gears, drawn and written for a run, at numbers that were computed by hand."""

import math
import tomllib

import pytest

import pipeline.gears as gears
from pipeline.gears import rules
from pipeline.gears.contact import buttressing, load_share

HELICAL = {
    "mesh.module": "3.5 mm", "mesh.helix_angle": "15 deg", "mesh.face_width": "23 mm",
    "pinion.teeth": 20, "wheel.teeth": 30, "pinion.profile_shift": 0.1809,
    "wheel.profile_shift": 0.0891, "pinion.tip_diameter": "80.672 mm",
    "wheel.tip_diameter": "116.264 mm", "duty.torque": "100 N m",
    "temperature.bulk": "165.7 degC",
}  # fmt: skip
LONG = {
    "mesh.module": "2 mm", "mesh.centre_distance": "100 mm", "pinion.teeth": 40,
    "wheel.teeth": 60, "pinion.profile_shift": 0, "wheel.profile_shift": 0,
    "pinion.tip_diameter": "86.4 mm", "wheel.tip_diameter": "126.4 mm",
}  # fmt: skip


@pytest.fixture(scope="module")
def fzg():
    return gears.read_pair("fzg_a")


@pytest.fixture(scope="module")
def mesh(fzg):
    return gears.mesh(fzg)


# Facts of a mesh


def test_facts_of_the_test_gears_are_those_of_the_standard(irg, mesh):
    """ISO 14635-1: αwt 22.44°, 8.3 m/s, εα 1.36; tables of the test give 1539 MPa in stage 10."""
    (facts,) = irg("gears", "fzg_a", "--json")["facts"]
    normal = 372.6 / (36e-3 * math.cos(math.radians(20)))
    assert max(mesh.places, key=lambda place: place.flash).letter == "D"
    for name, value in {
        "torque [N m]": 372.6, "speed [rpm]": 2170.0, "bulk temperature [°C]": 165.7,
        "contact ratio": 1.361, "centre distance [mm]": 91.5, "overlap ratio": 0.0,
        "working pressure angle [°]": 22.439, "pitch line velocity [m/s]": 8.317,
        "pitch pressure of one pair [GPa]": 1.54, "normal load [N]": normal,
        "friction": mesh.friction,
        "integral temperature [°C]": mesh.integral.integral - 273.15,
    }.items():  # fmt: skip
        assert facts[name] == pytest.approx(value, rel=1e-4), name
    assert "library 1" in facts


# The share of the load, and the rule


@pytest.mark.parametrize(
    ("quality", "at_end", "beside"),
    [(5, 1 / 3, 2 / 3), (7, 1 / 3, 2 / 3), (8, 6 / 15, 6 / 15 + 1 / 3), (12, 10 / 15, 1.0)],
)
def test_coarser_teeth_share_worse(fzg, quality, at_end, beside):
    path = fzg.gears.path
    near = 1e-9 * (path.b - path.a)
    for end, single in ((path.a, path.b - near), (path.e, path.d + near)):
        assert load_share(fzg.gears, end, quality) == pytest.approx(at_end)
        assert load_share(fzg.gears, single, quality) == pytest.approx(beside, rel=1e-6)
    middle = (path.a + path.b) / 2
    assert load_share(fzg.gears, middle, quality) == pytest.approx(min(at_end + 1 / 6, 1.0))
    assert load_share(fzg.gears, path.b, quality) == load_share(fzg.gears, path.d, quality) == 1.0


def test_helical_pairs_share_the_more_evenly_the_more_they_overlap():
    def share(width, place):
        toothing = gears.read_pair("fzg_a", HELICAL | {"mesh.face_width": width}).gears
        return load_share(toothing, getattr(toothing.path, place), 5), toothing

    for place, alone in (("a", 1 / 3), ("b", 1.0), ("e", 1 / 3)):
        part, toothing = share("23 mm", place)
        overlap, ratio = toothing.overlap_ratio, toothing.contact_ratio
        end = place != "b"
        shared = (1 - overlap) * alone + overlap / ratio
        assert part == pytest.approx(shared * (1 + 0.3 * overlap * end))
        assert share("60 mm", place)[0] == pytest.approx((1 + 0.3 * end) / ratio)


def test_the_load_of_helical_teeth_rises_towards_both_ends_of_the_path(fzg):
    """Half the rise is at half of 0.2 sin βb × distance from the pinion's base to pitch point."""
    toothing = gears.read_pair("fzg_a", HELICAL | {"mesh.face_width": "60 mm"}).gears
    lean = math.sin(math.radians(15)) * math.cos(math.radians(20))
    half, path = 0.1 * lean * toothing.tangents[0], toothing.path
    for place in (path.a + half, path.e - half):
        assert buttressing(toothing, place) == pytest.approx(1.15)
    assert buttressing(toothing, path.a + 2.01 * half) == 1
    assert buttressing(fzg.gears, fzg.gears.path.a) == 1


def test_two_or_three_pairs_in_mesh_share_equally():
    toothing = gears.read_pair("fzg_a", LONG).gears
    ratio, (a, _, _, e), pitch = toothing.contact_ratio, toothing.path, toothing.base_pitch
    assert 2 < ratio < 3
    assert load_share(toothing, a, 5) == load_share(toothing, e, 5) == pytest.approx(1 / 3)
    assert load_share(toothing, e - pitch, 5) == pytest.approx(1 / 3)
    assert load_share(toothing, a + 0.9 * pitch, 5) == pytest.approx(1 / 2)
    letters = [p.letter for p in gears.mesh(gears.read_pair("fzg_a", LONG)).places if p.letter]
    assert letters == ["A", "C", "E"]


def test_friction_of_the_rule_ends_at_its_fastest_and_lightest(fzg):
    """Clause 5.1: friction is constant from 50 m/s on and below 150 N/mm."""
    radius = 36e-3

    def friction(torque=372.6, velocity=10.0, **changed):
        duty = gears.Duty(torque, velocity / radius, 373.15)
        entries = {path.replace("_", ".", 1): value for path, value in changed.items()}
        return gears.friction_coefficient(gears.read_pair("fzg_a", entries), duty)

    assert friction(velocity=50.0) == pytest.approx(friction(velocity=60.0))
    assert friction(velocity=10.0) == pytest.approx(friction(velocity=20.0) * 2**0.2)
    least = 150 * 20 * radius  # 150 N/mm on 20 mm
    assert friction(least) == pytest.approx(friction(least / 3))
    assert friction(2 * least) == pytest.approx(friction(least) * 2**0.2)
    assert friction(friction_lubricant_factor=0.8) == pytest.approx(0.8 * friction())
    rougher = friction(pinion_roughness="0.7 um", wheel_roughness="0.7 um")
    assert rougher == pytest.approx(friction() * 2**0.25)
    mean = friction(pinion_roughness="0.2 um", wheel_roughness="0.5 um")
    assert mean == pytest.approx(friction())  # the mean Ra counts
    heavier = gears.Duty(2 * least, 10 / radius, 373.15, load_factor=1.5)
    assert gears.friction_coefficient(fzg, heavier) == pytest.approx(friction(3 * least))


def test_teeth_of_dipping_gears_are_warmer_than_their_oil_together_with_their_friction():
    warm = {"without": ["temperature.bulk"], "temperature.oil": "90 degC"}
    pair = gears.read_pair("fzg_a", warm)
    flash = gears.integral_temperature(pair, pair.duty).mean_flash
    assert pair.duty.bulk == pytest.approx(363.15 + 0.7 * flash, abs=1e-9)
    own = rules.warm_duty(pair, 100.0, 50.0, bulk=400.0)
    assert own == gears.Duty(100.0, 50.0, 400.0, 1.0)
    assert rules.warm_duty(pair, 100.0, 50.0, load_factor=1.7).load_factor == 1.7
    rule = gears.integral_temperature(pair, pair.duty)
    assert rule.integral == pytest.approx(pair.duty.bulk + 1.5 * rule.mean_flash)


def test_rules_of_the_test_go_with_torque_lubricant_and_viscosity():
    """Eqs. (94) to (96) by hand for stage 10, T1 = 372.6 N m."""
    assert rules.stage_bulk(10, 0.8) == pytest.approx(353.15 + 0.23 * 372.6 * 0.8)
    thick = gears.scuffing_integral(10, 460e-6, lubricant_factor=0.8, welding_factor=1.5)
    flash = 0.2 * 372.6 * (100 / 460) ** 0.02 * 0.8
    assert thick == pytest.approx(353.15 + 0.23 * 372.6 * 0.8 + 1.5 * 1.5 * flash)
    assert rules.stage_torque(1) == 3.3


# The figure and the scene


def test_the_scene_of_a_mesh_has_its_places_and_its_window(fzg, mesh):
    text = gears.scene_toml([mesh])
    scene = tomllib.loads(text)
    assert text.startswith("# Places of mesh of a pair of gears: the margin")
    sliding = [place for place in mesh.places if place.sliding]
    rows = scene["sweep"]["along"]
    assert len(rows) == len(sliding) == len(mesh.places) - 1
    for row, place in zip(rows, sliding, strict=True):
        mean = (place.rolling_1 + place.rolling_2) / 2
        assert float(row["position"].split()[0]) == pytest.approx(place.position, rel=1e-6)
        assert float(row["velocity"].split()[0]) == pytest.approx(abs(place.sliding), rel=1e-6)
        assert row["motion.slide_roll_ratio"] == pytest.approx(-place.sliding / mean, abs=1e-7)
        turn = 2e3 * math.pi * place.radius_1
        assert float(row["motion.track_length"].split()[0]) == pytest.approx(turn, rel=1e-6)
        assert "duty" not in row
    # Pixels of 4 µm/4 over 1.2 times the contact, widened by peaks of 3 Rq; a multiple of 8.
    widest = max(
        math.sqrt(4 * place.half_width**2 + 24 * fzg.rms_roughness * place.reduced_radius)
        for place in sliding
    )
    (along, across), size = scene["window"]["pixels"], scene["window"]["pixel_size"]
    assert size == ["1 um", "1 um"]
    assert (along % 8, across) == (0, 240)
    assert 1.2 * widest <= along * 1e-6 < 1.2 * widest + 8e-6
    # The highest load is reached in 10 s.
    highest = max(place.load for place in sliding)
    assert float(scene["loading"]["reference_load"].split()[0]) == pytest.approx(highest, rel=1e-6)
    assert float(scene["loading"]["rate"].split()[0]) == pytest.approx(highest / 10, rel=1e-6)
    assert scene["temperature"] == {"bulk": "165.7 degC"}
    critical = gears.scene_toml([gears.mesh(fzg.with_critical(523.15, None))])
    assert tomllib.loads(critical)["temperature"]["critical"] == "250 degC"


def test_several_duties_have_their_own_friction_and_temperature_in_each_row(fzg):
    duties = [gears.Duty(torque, 200.0, bulk) for torque, bulk in ((300.0, 400.0), (100.0, 350.0))]
    meshes = [gears.mesh(fzg, 2, duty) for duty in duties]
    rows = tomllib.loads(gears.scene_toml(meshes))["sweep"]["along"]
    assert [row["duty"] for row in rows] == ["1"] * 4 + ["2"] * 4
    assert {row["bulk_temperature"] for row in rows} == {"126.85 degC", "76.85 degC"}
    assert [row["friction"] for row in rows[::4]] == [round(one.friction, 6) for one in meshes]


@pytest.mark.parametrize(
    ("lengths", "pixel"),
    [(["2 um", "8 um"], ["0.5 um", "2 um"]), (["40 um", "4 um"], [None, "1 um"])],
)
def test_pixels_are_a_quarter_of_the_roughness_or_an_eightieth_of_the_contact(lengths, pixel):
    pair = gears.read_pair("fzg_a", {"surface.correlation_length": lengths})
    mesh = gears.mesh(pair)
    size = tomllib.loads(gears.scene_toml([mesh]))["window"]["pixel_size"]
    widest = max(2e6 * place.half_width for place in mesh.places if place.sliding)
    assert size[1] == pixel[1]
    if pixel[0]:
        assert size[0] == pixel[0]
    else:
        assert float(size[0].split()[0]) == pytest.approx(widest / 80, rel=1e-6)


def test_a_leaning_tooth_has_a_longer_line():
    helical = gears.read_pair("fzg_a", HELICAL)
    length = tomllib.loads(gears.scene_toml([gears.mesh(helical)]))["pin"]["length"]
    lean = math.asin(math.sin(math.radians(15)) * math.cos(math.radians(20)))
    assert float(length.split()[0]) == pytest.approx(23 / math.cos(lean), rel=1e-6)
    # A point of the flank comes back once a turn: at its speed it runs 2π ρ1 in that section.
    rows = tomllib.loads(gears.scene_toml([gears.mesh(helical)]))["sweep"]["along"]
    turns = helical.duty.speed / (2 * math.pi)
    sliding = [place for place in gears.mesh(helical).places if place.sliding]
    for row, place in zip(rows, sliding, strict=True):
        track = float(row["motion.track_length"].split()[0]) * 1e-3
        assert track * turns == pytest.approx(place.rolling_1, rel=1e-6)
