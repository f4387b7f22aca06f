"""Spellings of values, tables and scans: each is read as meant, or refused in a line."""

import itertools
import math

import numpy as np
import pytest

from pipeline import load_scene, to_si
from pipeline.arguments import in_share, in_si
from pipeline.operating_points import OperatingPoints
from pipeline.surface.scan import read_scan
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
                      "77 degF", "298.15 K", "536.67 degR", "25 ºC"],
    ("1 m/s", 1.5): ["1.5 m/s", "1500 mm/s", "5.4 km/h", "90 m/min", "1.5 m s-1", "1.5 m·s⁻¹",
                     "954.929658551372 rpm at radius 15 mm"],
    ("1 m", 2e-3): ["2 mm", "2mm", "0.2 cm", "2000 um", "2000 µm", "2000 μm", "2000 micron"],
    ("1 Pa", 6.6e9): ["6.6 GPa", "6600 MPa", "6600 N/mm2", "6600 N/mm²", "66 kbar"],
    ("1 m^2/N", 1.2e-15): ["1.2e-6 mm^3/(N m)", "1.2e-6 mm3/Nm", "1.2×10⁻⁶ mm³/(N·m)",
                           "1.2 x 10-6 mm3/Nm", "1.2e-15 m²/N", "1.2e-6 mm^3/N m"],
    ("1 W/(m K)", 45.0): ["45 W/(m K)", "45 W/mK", "45 W/m K", "45 W/(m·°C)", "0.45 W/cmK"],
    ("1 kg/m^3", 7800.0): ["7.8 g/cm3", "7800 kg/m3", "7.8 kg/dm³"],
    ("1 J/(kg K)", 470.0): ["470 J/kgK", "0.47 kJ/(kg K)", "0.47 J/gK"],
    ("1 m^2/s", 32e-6): ["32 cSt", "32 mm²/s", "0.32 St"],
    ("1 1/GPa", 2e-8): ["20 1/GPa", "20 GPa^-1", "20 /GPa"],
}  # fmt: skip
REFUSED = {
    "1 N": ["2 x 100 N", "3 × 100 N", "3 x 10 N", "3x102 N", "2*100 N", "600/2 N", "300 lb",
            "30 kg", "0.3 KN", "300 n", "300 Nm", "1,200 N", "1.200,5 N", "1 200 N", "1'200 N",
            "1_200 N", "300-400 N", "300 ± 5 N", "~300 N", "300", "", "N", "nan N", "inf N",
            "1e400 N", "0x12 N", "300 %", f"{'9' * 100_000} N"],
    "1 K": ["25 C", "77 F", "25 grad", "2 * 25 degC", "300 delta_degC", "25 mdegC"],
    "1 m/s": ["1.5 ms", "1.5 ms-1", "1.5 M/S", "500 rpm", "9 rpm at 15 mm", "15 Hz"],
    "1 m": ["2 mm2", "2 MM", "2000 u", "R2 mm", "2 x 1 mm", "2,0 mm", "2.0.0 mm"],
    "1 Pa": ["6.6 gpa", "62-64 HRC", "62 Rc", "750 hv"],
}  # fmt: skip


@pytest.mark.parametrize(("like", "value"), MEANT)
def test_a_quantity_is_read_in_each_spelling_and_in_no_other_dimension(like, value):
    for text in MEANT[like, value]:
        for spelling in (text, f" {text} ", text.replace(" ", "\xa0")):
            assert to_si(spelling, like) == pytest.approx(value, rel=1e-12), spelling
        for other, _ in MEANT:
            if {other, like} not in ({"1 m^2/N", "1 1/GPa"}, {like}):
                assert read_or_refused(to_si, text, other) is None, (text, other)


@pytest.mark.parametrize("like", REFUSED)
def test_a_text_with_two_meanings_is_no_quantity(like):
    for text in REFUSED[like]:
        assert read_or_refused(to_si, text, like) is None, text


def test_a_share_is_a_number_or_in_per_cent():
    for text in ("0.12", ".12", "1.2e-1", "12%", "12 %", "12 percent", "12 per cent", "+12 %"):
        assert in_share("friction", text) == pytest.approx(0.12)
    for text in ("0,12", "12,5%", "120 ‰", "1_2%", "nan", "inf", "12%%", "1/8", "0.1-0.12", ""):
        assert read_or_refused(in_share, "friction", text) is None, text


def test_quantities_of_pint_keep_their_units_through_every_door():
    quantity = pytest.importorskip("pint").UnitRegistry().Quantity
    assert in_si("load", quantity(500, "lbf"), "1 N") == pytest.approx(2224.1108, rel=1e-7)
    assert in_si("bulk", quantity(330, "degF"), "1 K") == pytest.approx(438.7056, rel=1e-6)
    assert in_share("friction", quantity(12, "percent")) == 0.12
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
        words = {"n/a", "-", ""} if not head.lower().startswith("friction") else set()
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


def test_cells_of_a_workbook_are_read_as_shown_or_refused(tmp_path):
    openpyxl = pytest.importorskip("openpyxl")

    def read(**cells):
        book = openpyxl.Workbook()
        for row in (["load [N]", "velocity [m/s]", "friction"], [300, 1.5, 0.2], [350, 2, 0.2]):
            book.active.append(row)
        for name, value in cells.items():
            book.active[name] = value
            if name == "C2" and value == 0.25:
                book.active[name].number_format = "0%"
        book.save(tmp_path / "a.xlsx")
        return read_or_refused(OperatingPoints.read, tmp_path / "a.xlsx")

    assert read().columns["friction"] == [0.2, 0.2]
    assert read(C2=0.25).columns["friction"] == [0.25, 0.2]
    assert read(C1="friction [%]", C2=0.25, C3="20").columns["friction"] == [0.25, 0.2]
    for cells in (
        {"C2": "=60/A2"}, {"A3": "=A2*2", "B3": "=B2*2", "C3": "=C2"}, {"C2": None},
        {"D1": "mu", "D2": 1},
        {"C1": "μ [-]"}, {"D1": "friction", "D2": 0.1, "D3": 0.1}, {"C2": "#N/A"}, {"C2": True},
        {"D1": "x", "D2": "=A2", "D3": "=A3"}, {"C2": "0,2"}, {"A2": "1.200"},
    ):  # fmt: skip
        assert read(**cells) is None, cells


# Scans: one matrix of heights, or a refusal.

HEIGHTS = np.round(np.random.default_rng(1).normal(0, 20, (12, 15)), 3)


@pytest.mark.parametrize("mark", ["\t", ";", ",", " ", " ; "])
def test_a_scan_is_one_matrix_or_is_refused(tmp_path, mark):
    def text(form="{:.3f}", factor=1.0):
        return "".join(f"{mark.join(form.format(z) for z in row)}\n" for row in factor * HEIGHTS)

    plain, lines = text(), text().splitlines()
    read = [plain, plain.replace("\n", "\r\n"), plain.replace("\n", "\n\n"), f"\n{plain}",
            f"# nm\n{plain}", text("{:.6e}"), f"\ufeff{plain}",
            plain.replace("\n", f"{mark}\n")]  # fmt: skip
    refused = [
        f"{plain}\n{plain}", f"{plain}# second\n{plain}", f"{plain}Phase\n{plain}",
        f"{plain}\n{lines[0]}\n", f"{plain}{lines[0].rpartition(mark)[0]}\n",
        text("{:,.0f}", 1000), text("{:,.0f}", 1000).replace(",", "."), plain.replace(".", ","),
        text("{:,.0f}", 1000).replace(",", "'"), text("{:,.2f}", 1000), f"Heights\n{plain}",
        "".join(f"{k}{mark}{line}\n" for k, line in enumerate(lines)), f"{plain}mean{mark}0.1\n",
    ]  # fmt: skip
    if mark.strip() or mark == "\t":
        refused.append("".join(f"{line}{mark}{mark}{line}\n" for line in lines))
    for content, is_read in [*((c, True) for c in read), *((c, False) for c in refused)]:
        (tmp_path / "a.txt").write_text(content, encoding="utf-8")
        scan = read_or_refused(read_scan, tmp_path / "a.txt", 1e-6, (1e-6, 1e-6))
        assert (scan is not None) == is_read, content[:80]
        if scan is not None:
            np.testing.assert_allclose(scan.heights.T, 1e-6 * HEIGHTS, rtol=1e-6)


def test_what_is_no_single_number_is_named_by_its_argument():
    for value in (True, [1], {"a": 1}, None, object(), b"1 N", 1j, np.timedelta64(1, "s")):
        with pytest.raises(InputError, match=r"^load "):
            in_si("load", value, "1 N")
    assert math.isnan(in_si("load", float("nan"), "1 N"))
