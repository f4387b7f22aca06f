"""Every numeric entry of a scene acts in a row of `along` as it does in the scene itself."""

from dataclasses import replace

import openpyxl
import pandas as pd
import pytest

from pipeline import load_scene
from pipeline.scene.cases import _FIXED
from pipeline.scene.entries import entry_at
from pipeline.scene.format import SceneFile
from pipeline.scene.kinds import Number, Quantity, Whole
from pipeline.scene.tables import keys_of
from pipeline.shipped import WORKFLOWS

STEEL = {
    "elastic_modulus": "205 GPa", "poisson_ratio": 0.29, "hardness": "6 GPa",
    "thermal_conductivity": "42 W/(m K)", "density": "7700 kg/m^3",
    "specific_heat": "460 J/(kg K)",
}  # fmt: skip
OIL = {
    "kinematic_viscosity": ["32 mm^2/s", "5 mm^2/s"],
    "density": "866 kg/m^3",
    "pressure_viscosity_coefficient": "20 1/GPa",
}
COMMON = {
    "model": {"bias": 0.06, "scatter": 0.05, "rise": 0.04},
    "oil": OIL,
    "sweep.fields": False,
    "temperature.critical_area_fraction": 0.1,
    "loading.hold": "1 s",
    "materials": {"own": STEEL},
    "disk.material": "own",
    "disk.roughness.correlation_length": "4 um",
    "disk.roughness.seed": 3,
    "fidelity": {
        "pixels_per_element": 1, "increments": 8, "fewest_elements": 0, "contact_tolerance": 1e-4,
    },
}  # fmt: skip
EARLIER = ["pin.diameter", "pin.width", "disk.diameter", "disk.width"]
SCENES = {  # in which the entries stand
    "discs": ("twin_disc", COMMON),
    "plates": ("twin_disc", COMMON | {
        "without": EARLIER, "disk.track_length": "300 mm",
        "motion.track_length": "200 mm",
    }),
    "rolling pin": ("twin_disc", COMMON | {
        "without": EARLIER, "pin.track_length": "300 mm",
    }),
    "crown": ("twin_disc", COMMON | {
        "without": [*EARLIER, "pin.length"], "pin.shape": "crowned",
        "pin.crown_radius": "40 mm",
    }),
    "stages": ("twin_disc", COMMON | {
        "without": ["loading"], "loading.hold": None, "loading": {
            "rate": "500 N/s", "stages": {"first": "1 kN", "step": "1.5 kN", "hold": "5 s"},
        },
    }),
}  # fmt: skip
OTHERS = {
    "disk.roughness.missing",  # of a scan, without an effect where nothing is missing
    "friction.by_velocity.velocity", "friction.by_velocity.coefficient",  # in a list
    "loading.stages.first", "loading.stages.step",  # the load of a row is one of the stages
}  # fmt: skip
PLACE = {"sweep.loads": ["4 kN"], "sweep.velocities": ["1 m/s"]}


def numeric_paths():
    """Paths of all entries that hold a number."""
    for path, entry in keys_of(SceneFile).items():
        kinds = [entry.kind, *getattr(entry.kind, "kinds", ())]
        number = next((one for one in kinds if isinstance(one, Number | Quantity)), None)
        if number and path.partition(".")[0] not in _FIXED and path not in OTHERS:
            yield path.replace("NAME", "own"), number


def value_of(path, number):
    """A number of an entry in one of the scenes, its unit, and the scene."""
    for name, (shipped, own) in SCENES.items():
        held = load_scene(shipped, overrides=own | PLACE).source.entries
        if (value := entry_at(held, path)) is not None and not isinstance(value, list):
            text, _, unit = str(value).partition(" ")
            return float(text) if isinstance(value, str) else value, unit, name
    raise AssertionError(f"no scene here has {path}")


def written(path, unit, value):
    return f"{value!r} {unit}" if unit else value


def tables(folder, heads, rows):
    """The same rows as CSV, Excel, a data frame and text of a scene."""
    pd.DataFrame(rows, columns=heads).to_csv(folder / "rows.csv", index=False)
    book = openpyxl.Workbook()
    for row in (heads, *rows):
        book.active.append(row)
    book.save(folder / "rows.xlsx")
    return str(folder / "rows.csv"), str(folder / "rows.xlsx")


@pytest.mark.parametrize(("path", "number"), [*numeric_paths()], ids=lambda one: str(one)[:40])
def test_an_entry_in_a_row_is_the_entry_in_the_scene(path, number, tmp_path):
    value, unit, name = value_of(path, number)
    other = value + 1 if isinstance(number, Whole) else float(f"{value * 1.01:.6g}")
    other = {"fidelity.pixels_per_element": 2, "pin.length": 0.99 * value}.get(path, other)
    shipped, own = SCENES[name]
    expected = [
        load_scene(shipped, overrides=own | PLACE | {path: written(path, unit, one)}).base
        for one in (value, other)
    ]
    assert expected[0] != expected[1]
    head = f"{path} [{unit}]" if unit else path
    heads, rows = [head, "load [kN]", "velocity [m/s]"], [[value, 4, 1], [other, 4, 1]]
    text = [
        {path: written(path, unit, one), "load": "4 kN", "velocity": "1 m/s"}
        for one in (value, other)
    ]
    frame = pd.DataFrame(text).to_dict("records")
    for along in (*tables(tmp_path, heads, rows), text, frame):
        sweep = load_scene(shipped, overrides=own | {"sweep.along": along})
        found = [replace(case, name=()) for case in sweep.cases]
        assert found == expected, along


def test_the_scenes_of_these_tests_are_shipped():
    assert {f"{name}.toml" for name, _ in SCENES.values()} <= {
        file.name for file in WORKFLOWS.glob("*.toml")
    }
