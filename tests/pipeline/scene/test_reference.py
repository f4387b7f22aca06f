"""The reference of the scene format, and new scenes."""

import ast
import re
import runpy
import tomllib
from pathlib import Path

import pytest

from pipeline import load_scene, new_scene
from pipeline.shipped import WORKFLOWS, shipped_scenes
from tests.sources.sections import all_keys
from tribo import InputError

ROOT = Path(__file__).parents[3]


def paths_of(table, parent=""):
    """Yield the paths of entries in nested tables, and in headings of their CSV files."""
    for key, value in table.items():
        path = "materials.NAME" if parent == "materials" else f"{parent}.{key}".lstrip(".")
        yield path
        if path == "sweep.over":
            yield from value
        if str(value).endswith(".csv") and (key == "along" or parent == "tests"):
            head, *_ = (WORKFLOWS / value).read_text("utf-8").splitlines()
            names = [
                re.sub(r"\s*\[.*", "", column).replace(" ", "_")
                for column in re.split("[;,]", head)
            ]
            yield from (name if "." in name else f"{parent}.{name}" for name in names)
        for item in value if isinstance(value, list) else [value]:
            if isinstance(item, dict):
                yield from paths_of(item, path)


def set_by_code(file):
    """Yield paths of entries in code: keys of dictionaries, and first arguments of `changed`."""
    for node in ast.walk(ast.parse(file.read_text("utf-8"))):
        expressions = node.keys if isinstance(node, ast.Dict) else []
        if isinstance(node, ast.Call) and getattr(node.func, "attr", "") == "changed":
            expressions = node.args[:1]
        yield from (
            expression.value for expression in expressions if isinstance(expression, ast.Constant)
        )


def test_every_entry_is_set_by_a_shipped_scene_or_by_the_paper_and_its_evidence():
    scenes = [tomllib.loads(file.read_text("utf-8")) for file in shipped_scenes().values()]
    evidence = [*WORKFLOWS.glob("paper/*.py"), *(ROOT / "tests/promises").glob("*.py")]
    used = {path for scene in scenes for path in paths_of(scene)}
    used |= {path for file in evidence for path in set_by_code(file)}
    assert {path for path, _ in all_keys()} - used == set()


@pytest.mark.parametrize("name", ["cam_tappet", "gear_mesh"])
def test_a_script_prints_the_rows_of_its_scene(name, capsys):
    runpy.run_path(str(WORKFLOWS / f"{name}.py"), run_name="__main__")
    assert capsys.readouterr().out == (WORKFLOWS / f"{name}.csv").read_text("utf-8")


@pytest.mark.parametrize("name", shipped_scenes())
def test_a_new_scene_means_what_the_shipped_one_does(name, tmp_path):
    new_scene(tmp_path / f"{name}.toml", like=name)
    assert load_scene(tmp_path / f"{name}.toml") == load_scene(WORKFLOWS / f"{name}.toml")


def test_a_copy_replaces_no_file_that_the_scene_names(tmp_path):
    (tmp_path / "fig8_load_record.csv").write_text("mine")
    with pytest.raises(InputError, match=r"fig8_load_record\.csv already exists"):
        new_scene(tmp_path / "other.toml", like="fig8")
    assert not (tmp_path / "other.toml").exists()


def test_a_new_scene_declares_uncertain_inputs_in_comments(tmp_path):
    new_scene(tmp_path / "mine.toml")
    text = (tmp_path / "mine.toml").read_text("utf-8")
    declared = re.sub(r"^# (?=\[uncertainty\]|\")", "", text, flags=re.M)
    (tmp_path / "declared.toml").write_text(declared, "utf-8")
    sweep = load_scene(tmp_path / "declared.toml")
    assert len(sweep.base.uncertainty) == text.count('\n# "') == 7
    assert sweep.scene == load_scene(tmp_path / "mine.toml").scene
    assert load_scene(tmp_path / "mine.toml").preset == "standard"
