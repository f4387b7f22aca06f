"""The README shows what happens."""

import re
import shlex
from pathlib import Path

import pytest

import pipeline
from pipeline.cli import main
from pipeline.cli.parser import parse
from pipeline.scene.contact_estimate import estimate_contact
from pipeline.scene.scene_warnings import warnings_of_case

ROOT = Path(__file__).parents[1]
README = (ROOT / "README.md").read_text(encoding="utf-8")
SCENES = re.findall(r"```toml\n(.*?)```", README, flags=re.DOTALL)
PAGES = ["README.md", *(f"workflows/{path.name}" for path in (ROOT / "workflows").glob("*.md"))]


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
        assert len(commands) >= 6


@pytest.mark.parametrize("scene", SCENES, ids=range(len(SCENES)))
def test_scenes_load_and_raise_no_doubts(scene, tmp_path):
    path = tmp_path / "bearing.toml"
    path.write_text(scene, encoding="utf-8")
    sweep = pipeline.load_scene(path)
    assert [one.code for one in warnings_of_case(sweep, estimate_contact(sweep))] == ["sharp_ends"]


def test_the_agreement_is_that_of_the_page_on_the_paper():
    page = (ROOT / "workflows" / "REPRODUCING.md").read_text(encoding="utf-8")
    ((low, high),) = re.findall(r"velocities are ([-+]\d+) to ([-+]\d+) % off", page)
    assert f" {low} to {high} % off".replace("-", "−") in README
    lists = re.findall(r"((?:[-+]\d+, )+[-+]\d+) % off, each from the other three", page)
    held_out = [int(number) for text in lists for number in text.split(", ")]
    assert len(held_out) == 8
    assert f" −{-min(held_out)} to +{max(held_out)} % off" in README


def test_the_numbers_of_the_first_hour_are_those_printed(folder_with_results, capsys, monkeypatch):
    monkeypatch.chdir(folder_with_results)
    page = " ".join((ROOT / "workflows" / "FIRST_HOUR.md").read_text(encoding="utf-8").split())
    velocities = re.findall(r"(\d\.\d+) m/s", page.partition("## 2.")[2].partition("## 3.")[0])
    assert main(["boundary", "results/first_try.zarr"]) == 0
    said = capsys.readouterr().out
    assert len(velocities) == 5
    assert [one for one in velocities if one not in said] == [], said
    shown = re.findall(r"here ([\d.]+ [%K])|(\d+ % to \d+ %)|(−[\d.]+ to \+\d+ %)", page)
    assert main(["margin", "first_try", "--load", "500 N", "--velocity", "2 m/s"]) == 0
    said = capsys.readouterr().out
    assert len(shown) == 4
    assert ["".join(one) for one in shown if "".join(one) not in said] == [], said


_WIDEST = 90  # letters of code in the site's page width of 46 em


@pytest.mark.parametrize("page", PAGES)
def test_code_fits_the_width_of_the_site(page):
    text = (ROOT / page).read_text(encoding="utf-8")
    blocks = re.findall(r"^```[^\n]*\n(.*?)^```", text, flags=re.DOTALL | re.MULTILINE)
    lines = [line for block in blocks for line in block.splitlines()]
    assert [line for line in lines if len(line) > _WIDEST] == []


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
