"""Materials and oils that a scene names, and how values are shown."""

import re

import pytest

from pipeline.kinds import Quantity
from pipeline.quantities import DIMENSIONS, SIZES, UNITS, display
from pipeline.scene.library import library
from pipeline.units import share_of
from tests.helpers.kept import assert_as_kept, refusal
from tests.helpers.scenes import STEEL
from tests.pipeline.scene.conftest import TEXT as WITH_OIL

TEXT = WITH_OIL[: WITH_OIL.index("[oil]")] + WITH_OIL[WITH_OIL.index("[friction]") :]
TABLE = TEXT[TEXT.index("[materials.steel]") : TEXT.index("[pin]")]
NO_TABLE = TEXT.replace(TABLE, "").replace('"steel"', '"AISI 52100"')


def test_a_material_of_the_library_is_the_same_written_in_full(read):
    sweep, written = read(text=NO_TABLE), read(text=TEXT)
    assert sweep.scene.disk == written.scene.disk == STEEL
    assert {entry.source for entry in sweep.sources} == {"Bosman & de Rooij, Table 3"}
    assert len(sweep.sources) == 6
    assert written.sources == ()


def test_own_entries_go_before_those_of_the_library(read):
    hard = '[materials.ball]\nlike = "AISI 52100"\nhardness = "62 HRC"\n'
    sweep = read(text=NO_TABLE.replace("[pin]", f"{hard}\n[pin]", 1).replace(
        'length = "3.4 mm"\nmaterial = "AISI 52100"', 'length = "3.4 mm"\nmaterial = "ball"'
    ))  # fmt: skip
    assert sweep.scene.pin.material.hardness == pytest.approx(746 * 9.80665e6)
    assert sweep.scene.disk.hardness == 6.6e9
    assert "materials.ball.hardness" not in [entry.key for entry in sweep.sources]


def test_a_table_under_a_name_of_the_library_may_be_a_part_or_whole(read):
    part = '[materials."AISI 52100"]\nlike = "AISI 52100"\nhardness = "700 HV"\n\n[pin]'
    assert read(text=NO_TABLE.replace("[pin]", part, 1)).scene.disk.hardness == 700 * 9.80665e6
    elastic = re.sub("hardness = .*\n", "", TABLE).replace("steel", '"AISI 52100"')
    sweep = read(text=NO_TABLE + elastic)
    assert sweep.scene.disk.hardness == float("inf")
    assert sweep.sources == ()


def test_every_entry_of_the_library_is_a_sound_material_or_oil(read):
    for name in library()["materials"]:
        sweep = read(text=NO_TABLE.replace("AISI 52100", name))
        assert sweep.scene.disk.thermal_conductivity > 0
        assert 80e9 < sweep.scene.disk.elastic_modulus < 420e9 or name.startswith("aluminium")
        assert 1e-7 < sweep.scene.disk.thermal_diffusivity < 2e-4
    for name in library()["oils"]:
        oil = read(text=f'oil = "{name}"\n{TEXT}').lubricant
        assert 1 < oil.viscosity(303.15) / oil.viscosity(373.15) < 100


def test_every_number_of_the_library_has_a_source():
    sources = set(library()["sources"])
    entries = [*library()["materials"].values(), *library()["oils"].values()]
    used = {source for entry in entries for _, source, *_ in entry.values()}
    assert used == sources
    deviations = [
        deviation for entry in entries for _, _, *texts in entry.values() for deviation in texts
    ]
    assert len(deviations) >= 5
    assert all(0.01 < share_of(deviation) < 0.1 for deviation in deviations)


def test_a_value_of_the_library_is_listed_with_its_deviation(read):
    (hardness,) = (x for x in read(text=NO_TABLE.replace("AISI 52100", "42CrMo4")).sources
                   if x.key.endswith("hardness"))  # fmt: skip
    assert hardness.value == "301 HB (± 6 %)"  # 271 to 331 HB: 30/301/√3
    assert "271 to 331 HB" in hardness.source


@pytest.mark.parametrize(
    ("grade", "warm"),
    # Viscosities at 100 °C for a viscosity index of 95, by calculators of ASTM D2270.
    [(32, 5.3), (46, 6.6), (68, 8.5), (100, 11.1), (150, 14.5), (220, 18.7), (320, 24.0),
     (460, 30.3), (680, 39.1)],
)  # fmt: skip
def test_every_grade_from_32_to_680_has_its_viscosity_at_40_and_100_degrees(read, grade, warm):
    oil = read(text=f'oil = "ISO VG {grade}"\n{TEXT}').lubricant
    assert oil.viscosities == pytest.approx((1e-6 * grade, 1e-6 * warm), rel=0.01)
    assert 10e-9 < oil.pressure_coefficient < 40e-9


def test_every_unit_in_which_values_are_shown_has_a_size():
    """A unit without a size is taken for SI, as a Greek µ would be."""
    assert [(name, unit) for name, unit in UNITS.items() if unit and unit not in SIZES] == []
    assert display(418.15, "°C") == "145 °C"
    assert display(6.6e9, "GPa") == "6.6 GPa"


def test_refusals_of_each_dimension_are_kept():
    texts = {}
    for dimension in DIMENSIONS.values():
        low, high = (float(limit.split()[0]) for limit in dimension.limits)
        kind = Quantity(dimension.limits[0])
        for text in (f"{low / 2:g} {kind.unit}", f"{2 * high:g} {kind.unit}", "1 mol"):
            texts[f"{dimension.name}: {text}"] = refusal(kind.argument, "value", text)
    assert_as_kept("limits_of_dimensions", texts)
