"""What follows from the format alone: the reference, new scenes, and all that a new entry needs."""

import ast
import json
import re
import shutil
import subprocess
import sys
import tomllib
from pathlib import Path

import pytest

from pipeline import load_scene, new_scene
from pipeline.shipped import WORKFLOWS, shipped_scenes
from tests.sources import reference
from tests.sources.sections import all_keys
from tribo import InputError


def test_the_page_is_what_the_format_says():
    text = (WORKFLOWS / "SCENE.md").read_text(encoding="utf-8")
    assert text.endswith(reference.scene()), "write it anew with: make reference"


def paths_of(table, place=""):
    """Yield the paths of entries in nested tables, and in headings of the tables that they name."""
    for key, value in table.items():
        path = "materials.NAME" if place == "materials" else f"{place}.{key}".lstrip(".")
        yield path
        if path == "sweep.over":
            yield from value
        if str(value).endswith(".csv") and (key == "along" or place == "tests"):
            head, *_ = (WORKFLOWS / value).read_text("utf-8").splitlines()
            names = [
                re.sub(r"\s*\[.*", "", one).replace(" ", "_") for one in re.split("[;,]", head)
            ]
            yield from (name if "." in name else f"{place}.{name}" for name in names)
        for one in value if isinstance(value, list) else [value]:
            if isinstance(one, dict):
                yield from paths_of(one, path)


def set_by_code(file):
    """Yield texts that code gives as the path of an entry: keys, and what `changed` takes first."""
    for node in ast.walk(ast.parse(file.read_text("utf-8"))):
        given = node.keys if isinstance(node, ast.Dict) else []
        if isinstance(node, ast.Call) and getattr(node.func, "attr", "") == "changed":
            given = node.args[:1]
        yield from (one.value for one in given if isinstance(one, ast.Constant))


def test_every_entry_is_set_by_a_shipped_scene_or_by_the_paper_and_its_evidence():
    scenes = [tomllib.loads(file.read_text("utf-8")) for file in shipped_scenes().values()]
    evidence = [*WORKFLOWS.glob("paper/*.py"), *(ROOT / "tests/promises").glob("*.py")]
    used = {path for scene in scenes for path in paths_of(scene)}
    used |= {path for file in evidence for path in set_by_code(file)}
    assert {path for path, _ in all_keys()} - used == set()


@pytest.mark.parametrize("name", ["cam_tappet", "gear_mesh"])
def test_a_script_prints_the_rows_of_its_scene(name):
    command = [sys.executable, str(WORKFLOWS / f"{name}.py")]
    printed = subprocess.run(command, capture_output=True, text=True, check=True).stdout
    assert printed == (WORKFLOWS / f"{name}.csv").read_text("utf-8")


@pytest.mark.parametrize("name", shipped_scenes())
def test_a_new_scene_means_what_the_shipped_one_does(name, tmp_path):
    new_scene(tmp_path / f"{name}.toml", like=name)
    assert load_scene(tmp_path / f"{name}.toml") == load_scene(WORKFLOWS / f"{name}.toml")


def test_a_copy_replaces_no_file_that_the_scene_names(tmp_path):
    (tmp_path / "fig8_load_record.csv").write_text("mine")
    with pytest.raises(InputError, match=r"fig8_load_record\.csv already exists"):
        new_scene(tmp_path / "other.toml", like="fig8")
    assert not (tmp_path / "other.toml").exists()


def test_the_command_writes_and_lists(tmp_path, irg):
    assert f"irg check {tmp_path / 'mine.toml'}" in irg("new", tmp_path / "mine.toml")
    assert load_scene(tmp_path / "mine.toml").preset == "standard"
    assert set(shipped_scenes()) <= set(irg("new", "--list").split())
    assert "irg new scene.toml" in irg("new", code=2)


# A new entry touches two files, by a line each beside its use: all else follows from these.

ROOT = Path(__file__).parents[3]
LINES = {
    "pipeline/scene/format.py": (
        '    seed: A[int, SEED, "Seed of the random surface."] = 0\n',
        '    waviness: A[float, Quantity("1 um", usual=(0.1, 9)), "Height of the waves."] = 0.0\n',
    ),
    "tribo/surface/roughness.py": ("    seed: int = 0\n", "    waviness: float = 0.0\n"),
}
"""Files that the entry touches: a line that is there, and the line after it."""
USE = "        return self_affine(pixels, ", "        return self.waviness + self_affine(pixels, "
ASKED = """
import json, pipeline
from pipeline.answers.scene_notes import warning_text
from tests.helpers.stored import sweep_text, parse_sweep
from tests.sources.sections import all_keys
from pipeline.store.resume import mismatches

PATH = "disk.roughness.waviness"

def load(value, path=PATH):
    return pipeline.load_scene("first_try", overrides={path: value})

def fault():
    try:
        load(2)
    except pipeline.SceneFileError as error:
        return str(error)

one, other = load("2 um"), load("0.003 mm")
over = load({PATH: ["2 um", "3 um"]}, "sweep.over")
print(json.dumps({
    "height": one.scene.roughness.heights(one.scene.pixels).mean(),
    "is told": PATH in dict(all_keys()),
    "fault": fault(),
    "doubt": warning_text(load("20 um").warnings[0]),
    "is kept": parse_sweep(sweep_text(one), {}) == one != other,
    "mismatches": [*mismatches(one, other)],
    "rows": [over.case(name).scene.roughness.waviness for name in over.case_table.names],
}))
"""


def test_a_new_entry_of_two_files_is_read_told_doubted_kept_compared_and_varied(tmp_path):
    for name in ("pipeline", "tribo", "workflows"):
        shutil.copytree(ROOT / name, tmp_path / name, ignore=shutil.ignore_patterns("__pycache__"))
    for name, (above, line) in LINES.items():
        text = (file := tmp_path / name).read_text()
        assert text.count(above) == 1, f"{name} has no such line any more"
        file.write_text(text.replace(above, above + line).replace(*USE))
    command = [sys.executable, "-W", "error", "-c", ASKED]
    done = subprocess.run(command, cwd=tmp_path, capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stderr
    answers = json.loads(done.stdout)
    assert answers.pop("height") == pytest.approx(2e-6)
    path = "disk.roughness.waviness"
    assert answers == {
        "is told": True,
        "fault": f'first_try: {path}: 2 has no unit; give a length above 0, such as "1 um"',
        "doubt": f"{path}: 20 µm is unusual (0.1 to 9 µm is common): check number and unit",
        "is kept": True,
        "mismatches": [f"{path}: 2e-06 in the store, 3e-06 in the scene"],
        "rows": [2e-6, 3e-6],
    }
