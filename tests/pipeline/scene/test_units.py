"""Quantities: from text to SI, and back to text."""

import ast
import math

import pytest

from pipeline import to_si
from pipeline.quantities import SIZES, UNITS, display
from pipeline.units import UnitError
from tests.sources.measure import ROOT


@pytest.mark.parametrize(
    ("text", "value"),
    [
        *[("0.27 um", 2.7e-7), ("0.816 µm", 0.816e-6), ("4um", 4e-6), ("150 mm", 0.15)],
        *[("6.6 GPa", 6.6e9), ("660 kgf/mm^2", 6472389000.0), ("0.75 kN", 750.0)],
        *[("45 W/(m K)", 45.0), ("45 W/m/K", 45.0), ("45 W m^-1 K^-1", 45.0)],
        *[("45 W/(m degC)", 45.0), ("7.8 g/cm^3", 7800.0), ("0.47 kJ/kg/K", 470.0)],
        *[("1.2e-6 mm^3/(N m)", 1.2e-15), ("1.2e-6 mm³/(N·m)", 1.2e-15)],
        *[("1.2e-6 mm**3/N/m", 1.2e-15), ("0.1 m/s", 0.1), ("9 km/h", 2.5)],
        *[("25 degC", 298.15), ("25 °C", 298.15), ("77 degF", 298.15), ("298 K", 298.0)],
        *[("25 ℃", 298.15), ("25 Deg. C", 298.15), ("210·10³ MPa", 2.1e11)],
        *[("1·10⁻⁶ mm³/Nm", 1e-15), ("700 HV 10", 6864655000.0)],
        *[("51 kp", 500.13915), ("HRC 60", 697 * 9.80665e6), ("HV 700", 6864655000.0)],
    ],
)
def test_a_quantity_is_the_double_nearest_to_its_value_in_si(text, value):
    assert to_si(text, like=text) == value


def shown_units():
    """Yield each unit in which the code displays values, and the place of the call."""
    for path in sorted((ROOT / "pipeline").rglob("*.py")):
        for node in ast.walk(ast.parse(path.read_text(encoding="utf-8"))):
            name = getattr(getattr(node, "func", None), "id", "")
            if name in ("display", "shown_in", "si_of"):
                for unit in (one for one in node.args[1:2] if isinstance(one, ast.Constant)):
                    yield unit.value, f"{path.relative_to(ROOT)}:{node.lineno}"


def test_every_unit_in_which_values_are_shown_has_a_size():
    """A unit without a size is taken for SI, as a Greek µ would be."""
    used = [*shown_units(), *((unit, name) for name, unit in UNITS.items() if unit)]
    assert len(used) > 60
    assert [(unit, place) for unit, place in used if unit not in SIZES] == []


def test_values_are_displayed_in_the_units_of_the_field():
    assert display(418.15, "°C") == "145 °C"
    assert display(to_si("0.3 m/s", like="1 m/s"), "m/s") == "0.3 m/s"
    assert display(6.6e9, "GPa") == "6.6 GPa"
    assert display(2e-3, "mm") == "2 mm"


PRINTED = {
    "1 W/(m K)": (45.0, ("W/mK", "W/m K", "W/m·K", "W/(m·K)", "W/(mK)", "W·m⁻¹·K⁻¹", "W m-1 K-1",
                         "W/m°C", "W/m-K", "W/m*K", "W / m K", "W/m/K", "W/(m.K)")),
    "1 J/(kg K)": (470.0, ("J/kgK", "J/kg K", "J/(kg·K)", "J/kg°C", "J/kg-K", "J kg-1 K-1")),
    "1 m^2/N": (1.2e-15, ("mm³/Nm", "mm3/Nm", "mm³/N·m", "mm3/N/m", "mm^3 N^-1 m^-1", "mm3/(Nm)")),
    "1 m^2/s": (32e-6, ("mm2/s", "mm²/s", "cSt")),
    "1 Pa": (2.1e11, ("N/mm2", "N/mm²", "MPa", "N mm-2")),
    "1 kg/m^3": (7850.0, ("kg/m3", "kg/m³", "kg m-3")),
    "1 Pa s": (0.028, ("mPas", "mPa·s", "mPa.s", "cP", "mPa s")),
    "1 m": (2e-3, ("mm",)),
    "1 m/s": (1.5, ("m/s", "m s-1", "m·s⁻¹")),
    "1 N/s": (150.0, ("N/s", "N s-1")),
    "1 1/GPa": (2e-8, ("1/GPa", "GPa-1", "GPa⁻¹", "/GPa")),
    "1 N m": (100.0, ("Nm", "N m", "N·m", "N-m")),
}  # fmt: skip
SIZES_OF_PRINT = {"mm³/Nm": 1e9, "mm3/Nm": 1e9, "mm³/N·m": 1e9, "mm3/N/m": 1e9,
                  "mm^3 N^-1 m^-1": 1e9, "mm3/(Nm)": 1e9, "mm2/s": 1e6, "mm²/s": 1e6, "cSt": 1e6,
                  "N/mm2": 1e-6, "N/mm²": 1e-6, "MPa": 1e-6, "N mm-2": 1e-6, "mPas": 1e3,
                  "mPa·s": 1e3, "mPa.s": 1e3, "cP": 1e3, "mPa s": 1e3, "mm": 1e3, "1/GPa": 1e9,
                  "GPa-1": 1e9, "GPa⁻¹": 1e9, "/GPa": 1e9}  # fmt: skip


@pytest.mark.parametrize(
    ("like", "unit"), [(like, unit) for like, (_, units) in PRINTED.items() for unit in units]
)
def test_units_are_read_as_data_sheets_print_them(like, unit):
    value = PRINTED[like][0]
    number = f"{value * SIZES_OF_PRINT.get(unit, 1.0):.10g}"
    for text in (f"{number} {unit}", f"{number}{unit}"[: None if unit[0] != "1" else 0]):
        # As many digits as are written.
        assert not text or to_si(text, like) == pytest.approx(value, rel=1e-9)


@pytest.mark.parametrize("text", ["25 deg C", "25 °C", "25°C", "25 degrees C", "25 ºC", "77 deg F"])
def test_temperatures_are_read_as_printed(text):
    assert to_si(text, "1 K") == 298.15
    assert to_si("−40 degC", "1 K") == 233.15


@pytest.mark.parametrize(
    ("text", "like"),
    [("2 W/mK", "1 W/K"), ("470 J/kgK", "1 J/K"), ("45 W/m K", "1 W/K"), ("1 Nm", "1 N")],
)
def test_no_spelling_is_read_as_another_dimension(text, like):
    with pytest.raises(UnitError, match="cannot be converted"):
        to_si(text, like)


@pytest.mark.parametrize(("place", "velocity"), [("radius", 2 * math.pi), ("diameter", math.pi)])
def test_turns_at_a_radius_or_diameter_are_a_velocity(place, velocity):
    for turns in ("60 rpm", "1 Hz"):
        assert to_si(f"{turns} at {place} 1 m", like="1 m/s") == pytest.approx(velocity, rel=1e-14)
