"""The reference of the scene file, and new scenes: both made from the format."""

import re
import tomllib

import pytest

from pipeline import load_scene, new_scene
from pipeline.shipped import WORKFLOWS, shipped_scenes
from tests.house import reference
from tests.house.sections import all_keys, sections
from tribo import InputError

KEYS = [(section, key) for section in sections() for key in section.keys()]  # noqa: SIM118


def test_the_page_is_what_the_format_says():
    text = (WORKFLOWS / "SCENE.md").read_text(encoding="utf-8")
    assert text.endswith(reference.scene()), "write it anew with: make reference"


def paths_of(table, place=""):
    """Yield the paths of entries in nested tables, as the reference writes them."""
    for key, value in table.items():
        path = "materials.NAME" if place == "materials" else f"{place}.{key}".lstrip(".")
        yield path
        for one in value if isinstance(value, list) else [value]:
            if isinstance(one, dict):
                yield from paths_of(one, path)


def test_every_entry_is_in_a_shipped_scene_or_on_a_page():
    """Numerical choices stand in the reference, with the number of each preset."""
    scenes = [tomllib.loads(file.read_text("utf-8")) for file in shipped_scenes().values()]
    used, named = {path for scene in scenes for path in paths_of(scene)}, set()
    for page in set(WORKFLOWS.glob("*.md")) - {WORKFLOWS / "SCENE.md", WORKFLOWS / "DATASET.md"}:
        code = re.findall(r"```.*?```|`[^`\n]+`", page.read_text("utf-8"), re.DOTALL)
        named |= {*re.findall(r"\w+", " ".join(code))}
    without = {
        path for path, _ in all_keys() if path not in used and not path.startswith("fidelity.")
    }
    assert {path for path in without if path.rpartition(".")[2] not in named} == set()


@pytest.mark.parametrize("name", shipped_scenes())
def test_a_new_scene_means_what_the_shipped_one_does(name, tmp_path):
    new_scene(tmp_path / f"{name}.toml", like=name)
    assert load_scene(tmp_path / f"{name}.toml") == load_scene(WORKFLOWS / f"{name}.toml")


def test_a_copy_replaces_no_file_that_the_scene_names(tmp_path):
    (tmp_path / "fig8_load_record.csv").write_text("mine")
    with pytest.raises(InputError, match=r"fig8_load_record\.csv exists already"):
        new_scene(tmp_path / "other.toml", like="fig8")
    assert not (tmp_path / "other.toml").exists()


def test_the_command_writes_and_lists(tmp_path, irg):
    assert f"irg check {tmp_path / 'mine.toml'}" in irg("new", tmp_path / "mine.toml")
    assert load_scene(tmp_path / "mine.toml").preset == "standard"
    assert set(shipped_scenes()) <= set(irg("new", "--list").split())
    assert "irg new scene.toml" in irg("new", code=2)
