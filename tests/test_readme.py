"""The README shows what happens."""

import re
import shlex
from pathlib import Path

import numpy as np
import pytest

import pipeline
import tribo
from pipeline.cli import main
from pipeline.cli.parser import parse
from pipeline.scene.doubts import doubts
from pipeline.scene.facts import facts_of
from pipeline.sweep.physics import note_on_ends
from tests.helpers.entries import changed

ROOT = Path(__file__).parents[1]
README = (ROOT / "README.md").read_text(encoding="utf-8")
BLOCKS = re.findall(r"```python\n(.*?)```", README, flags=re.DOTALL)
SCENES = re.findall(r"```toml\n(.*?)```", README, flags=re.DOTALL)
PAGES = ["README.md", *(f"workflows/{path.name}" for path in (ROOT / "workflows").glob("*.md"))]


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    """Folder in which the README's paths exist, with one computed point of `first_try`."""
    folder = tmp_path_factory.mktemp("readme")
    (folder / "workflows").symlink_to(ROOT / "workflows")
    sweep = pipeline.load_scene(ROOT / "workflows" / "first_try.toml")
    sweep = changed(sweep, loads=(600.0,), velocities=(1.5,))
    pipeline.run_sweep(sweep, folder / "results" / "first_try.zarr", workers=1)
    return folder


@pytest.mark.parametrize("block", BLOCKS, ids=range(len(BLOCKS)))
def test_python_blocks_run(block, folder, monkeypatch):
    monkeypatch.chdir(folder)
    exec(compile(block, "README.md", "exec"), {})


@pytest.mark.parametrize("page", PAGES)
def test_every_command_shown_is_one_that_could_be_typed(page, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    (tmp_path / "results").mkdir()  # a user's sweep is there
    text = (ROOT / page).read_text(encoding="utf-8").replace("\\\n", "")
    in_blocks = re.findall(r"^irg .*$", text, flags=re.MULTILINE)
    in_tables = re.findall(r"^\| `(irg \w+ [^`]+)`", text, flags=re.MULTILINE)
    commands = in_blocks + in_tables
    for command in commands:
        parse(shlex.split(command, comments=True)[1:])
    if page == "README.md":
        assert len(commands) > 10


@pytest.mark.parametrize("scene", SCENES, ids=range(len(SCENES)))
def test_scenes_load_and_raise_no_doubts(scene, folder):
    path = folder / "bearing.toml"
    path.write_text(scene, encoding="utf-8")
    sweep = pipeline.load_scene(path)
    assert [doubt.words for doubt in doubts(sweep, facts_of(sweep))] == [note_on_ends(sweep)]


WALK = (ROOT / "workflows" / "YOUR_SYSTEM.md").read_text(encoding="utf-8")


def test_the_walk_from_a_scan_to_a_boundary_leads_there(folder, monkeypatch, capsys):
    monkeypatch.chdir(folder)
    rng = np.random.default_rng(0)
    holed = rng.normal(scale=0.3, size=(400, 520)) + np.linspace(0, 5, 400)[:, None]  # tilted
    holed[3, 50] = np.nan
    np.save("disk.npy", holed)
    rig, radii, measured = re.findall(r"```toml\n(.*?)```", WALK, flags=re.DOTALL)
    (folder / "rig.toml").write_text(rig, encoding="utf-8")
    sweep = pipeline.load_scene("rig.toml")
    assert isinstance(sweep.scene.pin, tribo.Ball)
    assert doubts(sweep, facts_of(sweep)) == ()
    (folder / "radii.toml").write_text(radii, encoding="utf-8")
    assert pipeline.load_scene("radii.toml").variants.axes == {"pin.radius": (0.003, 0.005, 0.008)}
    (folder / "measured.toml").write_text(measured, encoding="utf-8")
    surface = facts_of(pipeline.load_scene("measured.toml")).surface
    assert surface.measured
    assert np.abs(surface.rise).max() < 1e-7  # levelled: before, 5 µm
    section = WALK[WALK.index("## Your measured surface") :]
    commands = re.findall(r"^irg .*(?:measured|disk.npy).*$", section, flags=re.MULTILINE)
    assert len(commands) == 5
    capsys.readouterr()
    for command in commands:
        few = ["--set", 'sweep.loads=["400 N"]', "--set", 'sweep.velocities=["1 m/s", "3 m/s"]']
        few = [*few, "--workers", "1"] if " run " in command else []
        assert main([*shlex.split(command)[1:], *few]) == 0
    printed = capsys.readouterr().out
    assert "surface measured" in " ".join(printed.split())
    assert "mild throughout" in printed


_WIDEST = 90  # letters of code in the site's page width of 46 em
_AS_PRINTED = "columns = {"  # line printed by irg tests, as long as the log's headings


@pytest.mark.parametrize("page", PAGES)
def test_code_fits_the_width_of_the_site(page):
    text = (ROOT / page).read_text(encoding="utf-8")
    blocks = re.findall(r"^```[^\n]*\n(.*?)^```", text, flags=re.DOTALL | re.MULTILINE)
    lines = [line for block in blocks for line in block.splitlines()]
    assert [line for line in lines if len(line) > _WIDEST and _AS_PRINTED not in line] == []


@pytest.mark.parametrize("page", PAGES)
def test_links_lead_somewhere(page):
    text = (ROOT / page).read_text(encoding="utf-8")
    for target in re.findall(r"\]\((?!https?:)([^)#]+)", text):
        assert (ROOT / page).parent.joinpath(target).exists(), target


def test_paths_that_are_named_exist():
    for page in PAGES:
        text = (ROOT / page).read_text(encoding="utf-8")
        for path in re.findall(r"`((?:tribo|pipeline|workflows|tests)/[\w/.]*)`", text):
            assert (ROOT / path).exists(), f"{page}: {path}"


def test_the_first_screen_has_the_commands_of_a_fresh_machine():
    screen = "\n".join(README.splitlines()[:35])
    makefile = (ROOT / "Makefile").read_text(encoding="utf-8")
    for target in ("diagram", "test"):
        assert f"\nmake {target} " in screen
        assert f"\n{target}: .venv/" in makefile


def test_python_blocks_open_stores_that_commands_above_make():
    for block in BLOCKS:
        above = README[: README.index(block)]
        for name in re.findall(r'"results/(\w+)\.zarr"', block):
            assert re.search(rf"^irg run {name}\b", above, flags=re.MULTILINE), name
