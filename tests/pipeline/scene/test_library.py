"""Materials, oils and units of hardness that a scene can name."""

import re

import pytest

from pipeline.scene.library import library
from tests.helpers.scenes import STEEL
from tests.pipeline.scene.conftest import TEXT as WITH_OIL

TEXT = WITH_OIL[: WITH_OIL.index("[oil]")] + WITH_OIL[WITH_OIL.index("[friction]") :]
TABLE = TEXT[TEXT.index("[materials.steel]") : TEXT.index("[pin]")]
NO_TABLE = TEXT.replace(TABLE, "").replace('"steel"', '"AISI 52100"')


@pytest.fixture
def fault(faults):
    def fault(text):
        (only,) = faults(text=text)
        return only

    return fault


def test_a_material_of_the_library_is_the_same_written_in_full(read):
    sweep, written = read(text=NO_TABLE), read(text=TEXT)
    assert sweep.scene.disk == written.scene.disk == STEEL
    assert {entry.source for entry in sweep.about.sources} == {"Bosman & de Rooij, Table 3"}
    assert len(sweep.about.sources) == 6
    assert written.about.sources == ()


def test_own_entries_go_before_those_of_the_library(read):
    hard = '[materials.ball]\nlike = "AISI 52100"\nhardness = "62 HRC"\n'
    sweep = read(text=NO_TABLE.replace("[pin]", f"{hard}\n[pin]", 1).replace(
        'length = "3.4 mm"\nmaterial = "AISI 52100"', 'length = "3.4 mm"\nmaterial = "ball"'
    ))  # fmt: skip
    assert sweep.scene.pin.material.hardness == pytest.approx(746 * 9.80665e6)
    assert sweep.scene.disk.hardness == 6.6e9
    assert "materials.ball.hardness" not in [entry.key for entry in sweep.about.sources]


def test_a_table_under_a_name_of_the_library_may_be_a_part_or_whole(read):
    part = '[materials."AISI 52100"]\nhardness = "700 HV"\n\n[pin]'
    assert read(text=NO_TABLE.replace("[pin]", part, 1)).scene.disk.hardness == 700 * 9.80665e6
    elastic = re.sub("hardness = .*\n", "", TABLE).replace("steel", '"AISI 52100"')
    sweep = read(text=NO_TABLE + elastic)
    assert sweep.scene.disk.hardness == float("inf")
    assert sweep.about.sources == ()


def test_a_misspelt_name_is_told_with_the_nearest(fault):
    assert 'did you mean "AISI 52100"' in fault(
        NO_TABLE.replace('material = "AISI 52100"', 'material = "AISI 5210"', 1)
    )
    assert '"medicinal white oil"' in fault('oil = "white oil"\n' + TEXT)
    assert '"tungsten"' in fault(NO_TABLE.replace('material = "AISI 52100"', 'material = "zzz"', 1))


def test_every_entry_of_the_library_is_a_sound_material_or_oil(read):
    for name in library()["materials"]:
        sweep = read(text=NO_TABLE.replace("AISI 52100", name))
        assert sweep.scene.disk.thermal_conductivity > 0
        assert 80e9 < sweep.scene.disk.elastic_modulus < 420e9 or name.startswith("aluminium")
        assert 1e-7 < sweep.scene.disk.thermal_diffusivity < 2e-4
    for name in library()["oils"]:
        oil = read(text=f'oil = "{name}"\n{TEXT}').about.oil
        assert 1 < oil.viscosity(303.15) / oil.viscosity(373.15) < 100


def test_every_number_of_the_library_has_a_source():
    sources = set(library()["sources"])
    entries = [*library()["materials"].values(), *library()["oils"].values()]
    used = {source for entry in entries for _, source in entry.values()}
    used |= {machine["source"] for machine in library()["machines"].values()}
    assert used == sources


def test_the_viscosity_between_its_temperatures_is_that_of_the_source(read):
    """The source has 23.3 mPa s at 60 °C as well, the equation of ASTM D341 within 3 %."""
    oil = read(text=f'oil = "medicinal white oil"\n{TEXT}').about.oil
    assert oil.viscosity(303.15) == pytest.approx(0.107)
    assert oil.viscosity(373.15) == pytest.approx(0.0064)
    assert oil.viscosity(333.15) == pytest.approx(0.0233, rel=0.03)
    assert oil.pressure_coefficient(333.15) == pytest.approx(22.8e-9, rel=0.05)


@pytest.mark.parametrize(
    ("table", "said"),
    [
        ('density = "866 kg/m^3"', "neither is given"),
        ('dynamic_viscosity = ["4 mPa s", "28 mPa s"]', "must fall"),
        ('dynamic_viscosity = ["28 mPa s", "4 mPa s"]\nviscosity = 3', "unknown key"),
    ],
)
def test_a_faulty_oil_is_one_clear_fault(fault, table, said):
    assert said in fault(f"{TEXT}[oil]\n{table}\n")
