"""Spellings of values, tables and scans: each is read as meant, or refused in a line."""

import itertools
import math

import numpy as np
import pytest

from pipeline import load_scene, to_si
from pipeline.condition_kinds import BULK, FRICTION, OperatingPoints
from pipeline.kinds import LOAD
from pipeline.surface.scan import read_scan
from pipeline.table import TableColumn
from tribo import InputError, TriboError


def read_or_refused(read, *arguments, **options):
    """What `read` returns, or None if it refuses the arguments."""
    try:
        return read(*arguments, **options)
    except TriboError:
        return None


# Values: by the dimension, the value in SI, numbers and units that mean it, and what must not.

MEANT = {
    ("1 N", 300.0): ["300 N", "300N", "0.3 kN", "3e2 N", "3·10² N", "3 x 10^2 N", "3 × 10² N",
                     "300 newton", "300 J/m", "300 kg m/s2", "30 daN", "300000 mN"],
    ("1 K", 298.15): ["25 degC", "25 °C", "25°C", "25 celsius", "25 deg C", "25 ℃", "77 °F",
                      "77 degF", "298.15 K", "536.67 degR", "25 ºC", "25 degrees C",
                      "77 deg F", "25 Deg. C"],
    ("1 N", 750.0): ["0.75 kN"], ("1 N", 500.13915): ["51 kp"],
    ("1 K", 233.15): ["−40 degC"], ("1 K", 298.0): ["298 K"],
    ("1 m/s", 0.1): ["0.1 m/s"], ("1 m/s", 2.5): ["9 km/h"],
    ("1 m/s", 1.5): ["1.5 m/s", "1500 mm/s", "5.4 km/h", "90 m/min", "1.5 m s-1", "1.5 m·s⁻¹"],
    ("1 m", 2e-3): ["2 mm", "2mm", "0.2 cm", "2000 um", "2000 µm", "2000 μm", "2000 micron"],
    ("1 m", 2.7e-7): ["0.27 um"], ("1 m", 0.816e-6): ["0.816 µm"], ("1 m", 4e-6): ["4um"],
    ("1 m", 0.15): ["150 mm"],
    ("1 Pa", 6864655000.0): ["700 HV 10", "HV 700"], ("1 Pa", 697 * 9.80665e6): ["HRC 60"],
    ("1 Pa", 6472389000.0): ["660 kgf/mm^2"], ("1 Pa", 2.1e11): ["210·10³ MPa"],
    ("1 Pa", 6.6e9): ["6.6 GPa", "6600 MPa", "6600 N/mm2", "6600 N/mm²", "66 kbar"],
    ("1 m^2/N", 1.2e-15): ["1.2e-6 mm^3/(N m)", "1.2e-6 mm3/Nm", "1.2×10⁻⁶ mm³/(N·m)",
                           "1.2 x 10-6 mm3/Nm", "1.2e-15 m²/N", "1.2e-6 mm^3/N m",
                           "1.2e-6 mm³/(N·m)", "1.2e-6 mm**3/N/m"],
    ("1 m^2/N", 1e-15): ["1·10⁻⁶ mm³/Nm"],
    ("1 W/(m K)", 45.0): ["45 W/(m K)", "45 W/mK", "45 W/m K", "45 W/(m·°C)", "0.45 W/cmK",
                          "45 W/m/K", "45 W m^-1 K^-1", "45 W/(m degC)"],
    ("1 kg/m^3", 7800.0): ["7.8 g/cm3", "7.8 g/cm^3", "7800 kg/m3", "7.8 kg/dm³"],
    ("1 J/(kg K)", 470.0): ["470 J/kgK", "0.47 kJ/kg/K", "0.47 kJ/(kg K)", "0.47 J/gK"],
    ("1 m^2/s", 32e-6): ["32 cSt", "32 mm²/s", "0.32 St"],
    ("1 1/GPa", 2e-8): ["20 1/GPa", "20 GPa^-1", "20 /GPa", "20 GPa-1", "20 GPa⁻¹"],
    ("1 N m", 100.0): ["100 Nm", "100 N m", "100 N·m", "100 N-m"],
}  # fmt: skip
REFUSED = {
    "1 N": ["2 x 100 N", "3 × 100 N", "3 x 10 N", "3x102 N", "2*100 N", "600/2 N", "300 lb",
            "30 kg", "0.3 KN", "300 n", "300 Nm", "1,200 N", "1.200,5 N", "1 200 N", "1'200 N",
            "1_200 N", "300-400 N", "300 ± 5 N", "~300 N", "300", "", "N", "nan N", "inf N",
            "1e400 N", "0x12 N", "300 %", f"{'9' * 100_000} N"],
    "1 K": ["25 C", "77 F", "25 grad", "2 * 25 degC", "300 delta_degC", "25 mdegC"],
    "1 m/s": ["1.5 ms", "1.5 ms-1", "1.5 M/S", "500 rpm", "9 rpm at radius 15 mm", "15 Hz"],
    "1 m": ["2 mm2", "2 MM", "2000 u", "R2 mm", "2 x 1 mm", "2,0 mm", "2.0.0 mm"],
    "1 W/K": ["2 W/mK", "45 W/m K"],
    "1 J/K": ["470 J/kgK"],
    "1 Pa": ["6.6 gpa", "62-64 HRC", "62 Rc", "750 hv"],
}  # fmt: skip


UNITS = {
    "1 N": {1: "N | newton | newtons | J/m | kg m/s2 | kg·m/s² | kg*m/s^2 | N·m/m | W s/m",
        1e3: "kN | kilonewton", 1e-3: "mN", 1e6: "MN", 1e-6: "µN | uN | μN", 10: "daN",
        9.80665: "kgf | kp", 9.80665e-3: "gf", 4.4482216152605: "lbf", 4448.2216152605: "kip",
        0.27801385095378125: "ozf", 1e-5: "dyn | dyne", 9806.65: "tf", 1e-2: "cN", 1e-9: "nN"},
    "1 m/s": {1: "m/s | m s-1 | m s^-1 | m·s⁻¹ | m.s-1 | m s⁻¹ | meter/second | metre/second"
           " | m/sec | mm/ms", 1e-3: "mm/s | mm s-1 | µm/ms", 1e-2: "cm/s", 1e-6: "µm/s | um/s",
        1e-9: "nm/s", 0.2777777777777778: "km/h | km/hr | kph", 1e3: "km/s | m/ms",
        0.016666666666666666: "m/min", 1.6666666666666667e-5: "mm/min", 2.777777777777778e-4: "m/h",
        0.3048: "ft/s | fps", 0.00508: "ft/min", 0.0254: "in/s | inch/s",
        0.44704: "mph | mile/h | mi/h", 0.5144444444444445: "knot", 4.233333333333333e-4: "in/min"},
    "1 m": {1: "m | meter | metre", 1e-3: "mm | millimeter | millimetre", 1e-2: "cm", 0.1: "dm",
        1e3: "km", 1e-6: "um | µm | μm | micron | microns | micrometer | micrometre",
        1e-9: "nm | nanometer", 1e-12: "pm", 1e-10: "angstrom", 0.0254: "in | inch | inches",
        0.3048: "ft | foot", 2.54e-5: "thou", 0.9144: "yd", 2.54e-8: "uin | µin | μin | microinch",
        1609.344: "mile"},
    "1 Pa": {1: "Pa | N/m2 | N/m² | N/m^2 | J/m3 | pascal", 1e3: "kPa",
        1e6: "MPa | N/mm2 | N/mm² | N/mm^2 | MN/m2 | MN/m² | N mm-2 | N·mm⁻² | megapascal",
        1e9: "GPa | kN/mm2 | kN/mm² | J/mm3 | gigapascal", 1e12: "TPa", 100: "hPa | mbar",
        1e-3: "mPa", 1e5: "bar", 1e8: "kbar", 1e4: "N/cm2",
        6894.757293168361: "psi | lbf/in2 | lbf/in^2", 6894757.293168361: "ksi",
        6894757293.168361: "Mpsi", 9806650: "kgf/mm2 | kp/mm2", 98066.5: "kgf/cm2 | kp/cm²",
        101325: "atm", 133.32236842105263: "torr", 133.322387415: "mmHg", 0.1: "dyn/cm2"},
    "1 s": {1: "s | sec | second | seconds", 1e-3: "ms", 1e-6: "us | µs | μs", 1e-9: "ns",
        60: "min | minute | minutes", 3600: "h | hr | hour | hours", 86400: "d | day | days",
        604800: "week"},
    "1 N/s": {1: "N/s | N s-1 | N·s⁻¹ | W/m", 1e3: "kN/s | N/ms", 1e-3: "mN/s",
        0.016666666666666666: "N/min", 16.666666666666668: "kN/min", 10: "daN/s", 9.80665: "kgf/s",
        4.4482216152605: "lbf/s", 2.777777777777778e-4: "N/h"},
    "1 Pa s": {1: "Pa s | Pa.s | Pa*s | Pa·s | Pas | kg/(m s) | N s/m2 | N s/m²",
        1e-3: "mPa s | mPa.s | mPas | mPa·s | cP | centipoise | mN s/m²",
        0.1: "P | poise | dyn s/cm2", 1e9: "GPa s", 1e3: "kPa s | MPa ms"},
    "1 m^2/s": {1: "m2/s | m²/s | m^2/s | m2 s-1",
        1e-6: "mm2/s | mm²/s | mm^2/s | cSt | centistokes | mm² s⁻¹ | mm²·s⁻¹",
        1e-4: "cm2/s | cm²/s | St | stokes", 0.09290304: "ft2/s", 6.4516e-4: "in2/s",
        2.777777777777778e-4: "m2/h"},
    "1 kg/m^3": {1: "kg/m3 | kg/m³ | kg/m^3 | g/l | g/L | kg m-3 | kg·m⁻³",
        1e3: "g/cm3 | g/cm³ | g/cm^3 | kg/dm3 | kg/dm³ | kg/l | kg/L | g/ml | g/mL | t/m3 | t/m³"
             " | mg/mm3 | g cm-3 | g·cm⁻³ | Mg/m3", 1e6: "g/mm3 | kg/cm3",
        16.018463373960142: "lb/ft3", 27679.904710203125: "lb/in3"},
    "1 W/(m K)": {1: "W/(m K) | W/mK | W/m K | W/m/K | W/(m·K) | W/(mK) | W/(m*K) | W m-1 K-1"
           " | W·m⁻¹·K⁻¹ | W/m·K | W/m*K | W / m K | W/(m.K) | W/(m °C) | W/(m·°C) | W/m°C | W/m-K"
           " | N/(s K) | J/(s m K) | J/(m s K)", 1e3: "kW/(m K) | W/(mm K)", 1e-3: "mW/(m K)",
        100: "W/cmK | W/(cm K)"},
    "1 J/(kg K)": {1: "J/(kg K) | J/kgK | J/kg K | J/kg/K | J/(kg·K) | J/(kgK) | J/(kg °C)"
           " | J/kg°C | J/kg-K | J kg-1 K-1 | J·kg⁻¹·K⁻¹ | m2/(s2 K) | W s/(kg K)",
        1e3: "kJ/(kg K) | kJ/kgK | kJ/kg/K | J/(g K) | J/gK | J/(g °C) | kJ kg-1 K-1"},
    "1 m^2/N": {1: "m2/N | m²/N | m^2/N | m3/(N m) | m³/Nm | 1/Pa | Pa^-1 | m3/J",
        1e-9: "mm3/Nm | mm³/Nm | mm^3/Nm | mm3/(N m) | mm³/(N m) | mm^3/(N m) | mm³/(N·m)"
              " | mm³/N·m | mm3/N/m | mm3/N m | mm³ N⁻¹ m⁻¹ | mm3 N-1 m-1 | mm^3 N^-1 m^-1 | mm³/J"
              " | 1/GPa | GPa⁻¹", 1e-18: "µm3/(N m) | um3/(N m)",
        1e-6: "mm3/(N mm) | mm2/N | cm3/(N m) | 1/MPa", 1e-12: "mm3/(N km) | µm2/N"},
    "1 K": {1: "K | kelvin", 1e-3: "mK", 0.5555555555555556: "degR"},
}  # fmt: skip
"""Sizes of units in SI, by hand from definitions of SI and NIST SP 811, and their spellings."""


@pytest.mark.parametrize("like", UNITS)
def test_units_have_their_size_in_each_spelling_and_number(like):
    numbers = {
        "3": 3.0,
        "3.0": 3.0,
        ".5": 0.5,
        "2e-1": 0.2,
        "+4": 4.0,
        "1.25E1": 12.5,
        "3·10²": 300.0,
    }
    for size, spellings in UNITS[like].items():
        for unit in spellings.split(" | "):
            for number, value in numbers.items():
                text = f"{number} {unit}"
                quantity = read_or_refused(to_si, text, like)
                if "²" in number and unit.startswith("1/"):
                    assert quantity is None, text
                else:
                    assert quantity == pytest.approx(value * size, rel=1e-9), text
            if unit[0] not in "1/":
                assert to_si(f"3{unit}", like) == pytest.approx(3 * size, rel=1e-9), unit
            for wrong in ("3,5", "1,200", "3-4", "~3", "3 ± 1", "<3", "ca. 3", "n/a", "--3", "3 3"):
                assert read_or_refused(to_si, f"{wrong} {unit}", like) is None, (wrong, unit)


@pytest.mark.parametrize(("like", "value"), MEANT)
def test_a_quantity_is_the_nearest_double_in_each_spelling_and_in_no_other_dimension(like, value):
    for text in MEANT[like, value]:
        for spelling in (text, f" {text} ", text.replace(" ", "\xa0")):
            assert to_si(spelling, like) == value, spelling
        for other, _ in MEANT:
            if {other, like} not in ({"1 m^2/N", "1 1/GPa"}, {like}):
                assert read_or_refused(to_si, text, other) is None, (text, other)


@pytest.mark.parametrize("like", REFUSED)
def test_a_text_with_two_meanings_is_no_quantity(like):
    for text in REFUSED[like]:
        assert read_or_refused(to_si, text, like) is None, text


def test_a_share_is_a_number_or_in_per_cent():
    for text in ("0.12", ".12", "1.2e-1", "12%", "12 %", "12 percent", "12 per cent", "+12 %"):
        assert FRICTION.argument("friction", text) == pytest.approx(0.12)
    for text in ("0,12", "12,5%", "120 ‰", "1_2%", "nan", "inf", "12%%", "1/8", "0.1-0.12", ""):
        assert read_or_refused(FRICTION.argument, "friction", text) is None, text


def test_quantities_of_pint_keep_their_units_through_every_door():
    quantity = pytest.importorskip("pint").UnitRegistry().Quantity
    assert LOAD.argument("load", quantity(500, "lbf")) == pytest.approx(2224.1108, rel=1e-7)
    assert BULK.argument("bulk", quantity(330, "degF")) == pytest.approx(438.7056, rel=1e-6)
    assert FRICTION.argument("friction", quantity(12, "percent")) == 0.12
    overrides = {
        "pin.radius": quantity(0.3, "cm"),
        "sweep.loads": quantity(np.array([0.2, 0.4]), "kN"),
        "friction.coefficient": quantity(12, "percent"),
    }
    sweep = load_scene("first_try", overrides=overrides)
    changed = load_scene("first_try").changed("pin.radius", quantity(3, "mm"))
    assert sweep.scene.pin.radius == changed.scene.pin.radius == 3e-3
    assert (sweep.loads, sweep.conditions.friction) == ((200.0, 400.0), 0.12)
    for wrong in (quantity(3, "N"), quantity(3, ""), quantity(25, "delta_degC"), b"3 mm", {3}):
        with pytest.raises(TriboError, match=r"pin\.radius"):
            load_scene("first_try", overrides={"pin.radius": wrong})


# Tables: a column that means a friction of 0.2 acts, or the table is refused.

HEADS = [
    "friction", "Friction", "friction [-]", "friction [1]", "friction [–]", "friction.coefficient",
    "friction (-)", "μ", "µ", "μ [-]", "µ [1]", "mu", "COF", "cof [-]", "Reibwert", "f [-]",
    "Reibungszahl [-]", "coefficient of friction", "friction_coefficient", "frictoin",
    "friction [N]",
    "pin radius [mm]", "Ra [um]", "hardness [HRC]", "specimen", "date", "angle [deg]", "",
]  # fmt: skip
CELLS = ["0.2", ".2", "2e-1", "20 %", "0,2", "", "-", "n/a", "=60/A2", "#DIV/0!", "~0.2", "0.2 N"]


@pytest.mark.parametrize("mark", ["\t", ";", ","])
def test_a_column_of_numbers_acts_or_is_refused(tmp_path, mark):
    for head, cell in itertools.product(HEADS, CELLS):
        text = mark.join(["load [N]", "velocity [m/s]", head])
        row = mark.join(["300", "1.5", f'"{cell}"'])
        (tmp_path / "a.csv").write_text(f"{text}\n{row}\n{row}\n", encoding="utf-8")
        table = read_or_refused(OperatingPoints.read, tmp_path / "a.csv")
        is_acting = TableColumn.from_heading(head).name in ("friction", "friction.coefficient")
        words = set() if is_acting else {"n/a", "-", ""}
        assert (
            table is None
            or table.columns.get("friction") == [0.2, 0.2]
            or (cell in words and "friction" not in table.columns)
        ), (head, cell)


@pytest.mark.parametrize("advised", [False, True])
def test_marks_in_numbers_are_asked_about_and_never_guessed(tmp_path, advised):
    for number in ("1,200", "1.200", "1.200,5", "1,200.5", "1 200", "1'200", "12,34,567"):
        for decimal in (".", ",") if advised else (None,):
            (tmp_path / "a.csv").write_text(f"load [N];velocity [m/s]\n{number};2 m/s\n")
            table = read_or_refused(OperatingPoints.read, tmp_path / "a.csv", decimal)
            is_meant = {"1,200": ",", "1.200": "."}.get(number) == decimal
            assert (table is not None) == (advised and is_meant), (number, decimal)
            assert table is None or table.columns["load"] == [1.2]


STRANGE = {
    "300": 300.0, " 300 ": 300.0, "3e2": 300.0, "+300": 300.0, "300.0": 300.0, "0.3 kN": 300.0,
    "300 N": 300.0, "67 lbf": 298.0308482224535, "30 kgf": 294.1995, "−300": None,
    "1,200": None, "1.200": 1.2, "1.200,5": None, "1 200": None, "1'200": None, "1,5e3": None,
    "100-200": None, "300 ± 5": None, "<300": None, "ca. 300": None, "~300": None, "NaN": None,
    "nan": None, "inf": None, "-": None, "": None, "n/a": None, "300 kg": None, "300 m/s": None,
    "=A1": None, "#N/A": None, "#REF!": None, "300*": None, "30O": None, "0": None, "1e999": None,
}  # fmt: skip
"""Cells below "load [N]" as others write them, and the load that they mean, or None."""


@pytest.mark.parametrize("mark", ["\t", ";", ","])
@pytest.mark.parametrize("encoding", ["utf-8", "utf-8-sig", "utf-16", "cp1252"])
def test_a_cell_of_a_load_has_its_meaning_or_is_refused(tmp_path, mark, encoding):
    for cell, load in STRANGE.items():
        rows = [["load [N]", "velocity [m/s]", "name"], [f'"{cell}"', "1.5", "a"], ["", "", ""]]
        text = "\r\n".join(map(mark.join, rows)) + "\r\n"
        (tmp_path / "a.csv").write_bytes(text.encode(encoding, errors="replace"))
        table = read_or_refused(OperatingPoints.read, tmp_path / "a.csv")
        assert (load is None) == (table is None) or cell == "1.200", cell
        assert table is None or table.columns["load"] == [pytest.approx(load, rel=1e-9)], cell


@pytest.mark.parametrize(
    "heads",
    [
        "load [N];Load [N];velocity [m/s]", "load [N];load  [N];velocity [m/s]",
        "load [N];normal load [N];velocity [m/s]", "load;velocity;friction",
        "load [lb];velocity [m/s];friction", "load [N];velocity [rpm];friction",
        "Last [N];Geschwindigkeit [m/s];Reibung", "charge [N];vitesse [m/s];frottement",
        "load [N];velocity [m/s];", "load [N];velocity [m/s];;", "load [N];;velocity [m/s]",
        "load [N];velocity [m/s];Ra [µin]", "load [N];velocity [m/s];hardness [HV]",
        "load [N];velocity [m/s];friction [MPa]", "load [N];velocity [m/s];bulk temperature",
        "load [N];velocity [m/s];bulk temperature [C]", "Test 3;;",
        "load [N],velocity [m/s],friction",
    ],
)  # fmt: skip
def test_headings_that_are_doubled_foreign_or_without_a_unit_are_refused(tmp_path, heads):
    for row in ("300;1.5;0.2", "300;300;1.5"):
        (tmp_path / "a.csv").write_text(f"{heads}\n{row}\n", encoding="utf-8")
        assert read_or_refused(OperatingPoints.read, tmp_path / "a.csv") is None
    (tmp_path / "a.csv").write_text("load;velocity;friction\n[N];[m/s];[-]\n300;1.5;0.2\n")
    assert read_or_refused(OperatingPoints.read, tmp_path / "a.csv") is None


# Scans: one matrix of heights, or a refusal.

HEIGHTS = np.round(np.random.default_rng(1).normal(0, 20, (12, 15)), 3)


@pytest.mark.parametrize("mark", ["\t", ";", ",", " ", " ; "])
def test_a_scan_is_one_matrix_or_is_refused(tmp_path, mark):
    def text(form="{:.3f}", factor=1.0):
        return "".join(f"{mark.join(form.format(z) for z in row)}\n" for row in factor * HEIGHTS)

    plain, lines = text(), text().splitlines()
    read = [plain, f"\n{plain}", plain.replace("\n", f"{mark}\n")]  # others in test_layouts.py
    refused = [
        plain.replace("\n", "\n\n"), f"{plain}\n{plain}", f"{plain}# second\n{plain}",
        f"{plain}Phase\n{plain}",
        f"{plain}\n{lines[0]}\n", f"{plain}{lines[0].rpartition(mark)[0]}\n",
        text("{:,.0f}", 1000), text("{:,.0f}", 1000).replace(",", "."), plain.replace(".", ","),
        text("{:,.0f}", 1000).replace(",", "'"), text("{:,.2f}", 1000), f"Heights\n{plain}",
        "".join(f"{k}{mark}{line}\n" for k, line in enumerate(lines)), f"{plain}mean{mark}0.1\n",
    ]  # fmt: skip
    if mark.strip() or mark == "\t":
        refused.append("".join(f"{line}{mark}{mark}{line}\n" for line in lines))
    for content, is_read in [*((c, True) for c in read), *((c, False) for c in refused)]:
        (tmp_path / "a.txt").write_text(content, encoding="utf-8")
        scan = read_or_refused(read_scan, tmp_path / "a.txt", 1e-6)
        assert (scan is not None) == is_read, content[:80]
        if scan is not None:
            np.testing.assert_allclose(scan[0].T, 1e-6 * HEIGHTS, rtol=1e-6)


def test_what_is_no_single_number_is_named_by_its_argument():
    for value in (True, [1], {"a": 1}, None, object(), b"1 N", 1j, np.timedelta64(1, "s")):
        with pytest.raises(InputError, match=r"^load[ :]"):
            LOAD.argument("load", value)
    assert math.isnan(LOAD.in_si("load", float("nan")))
