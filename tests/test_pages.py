"""The pages: commands, links, paths and references on them hold, and their numbers are printed."""

import re
import shlex
import subprocess
import sys
from pathlib import Path

import pytest

from pipeline.cli import main
from pipeline.cli.parser import parse
from pipeline.constants import HIGHEST_TEMPERATURE_BOUNDS, PRESET_BOUNDS
from tests.sources import reference

ROOT = Path(__file__).parents[1]
WORKFLOWS = ROOT / "workflows"
README = (ROOT / "README.md").read_text(encoding="utf-8")
PAGES = ["README.md", *(f"workflows/{path.name}" for path in WORKFLOWS.glob("*.md"))]
_WIDEST = 90  # letters of code in the site's page width of 46 em


def text_of(page):
    return (ROOT / page).read_text(encoding="utf-8")


@pytest.mark.slow
def test_the_site_builds_without_a_warning(tmp_path):
    """As on Read the Docs, and by `make docs`."""
    command = [sys.executable, "-m", "sphinx", "-q", "-W", "--keep-going", WORKFLOWS, tmp_path]
    done = subprocess.run(command, capture_output=True, text=True, check=False, timeout=250)
    assert done.returncode == 0, done.stderr
    assert "pipeline.Sweep" in (tmp_path / "API.html").read_text(encoding="utf-8")


@pytest.mark.parametrize("page", PAGES)
def test_every_command_shown_is_one_that_could_be_typed(page, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    (tmp_path / "results").mkdir()  # a user's sweep is there
    text = text_of(page).replace("\\\n", "")
    in_blocks = re.findall(r"^irg .*$", text, flags=re.MULTILINE)
    in_tables = re.findall(r"^\| `(irg \w+ [^`]+)`", text, flags=re.MULTILINE)
    for command in in_blocks + in_tables:
        parse(shlex.split(command, comments=True)[1:])


@pytest.mark.parametrize("page", sorted({*PAGES} - {"workflows/API.md"}))  # it has docstrings
def test_code_fits_the_width_of_the_site(page):
    blocks = re.findall(r"^```[^\n]*\n(.*?)^```", text_of(page), flags=re.DOTALL | re.MULTILINE)
    lines = [line for block in blocks for line in block.splitlines()]
    assert [line for line in lines if len(line) > _WIDEST] == []


@pytest.mark.parametrize("page", PAGES)
def test_links_lead_to_files_and_headings(page):
    for target, heading in re.findall(r"\]\((?!https?:)([^)#]*)#?([^)]*)\)", text_of(page)):
        file = (ROOT / page).parent / target if target else ROOT / page
        assert file.exists(), target
        assert not heading or heading in headings_of(file), f"{target}#{heading}"


def headings_of(file):
    """Names by which links call the headings of a page, as on the site."""
    heads = re.findall(r"^#+ (.*)$", file.read_text(encoding="utf-8"), re.MULTILINE)
    return {re.sub(r"[^\w -]", "", head.lower()).replace(" ", "-") for head in heads}


@pytest.mark.parametrize("page", reference.PAGES)
def test_references_are_written_from_what_they_describe(page):
    text = text_of(f"workflows/{page}.md")
    assert reference.written(page, text) == text, "write it again with: make reference"


@pytest.mark.parametrize("page", PAGES)
def test_a_page_reads_as_plain_markdown(page):
    assert re.findall(r"\{(?:py:\w+|eval-rst|argparse)\}|\{\{.*?\}\}", text_of(page)) == []


def test_paths_on_pages_exist():
    for page in PAGES:
        for path in re.findall(r"`((?:tribo|pipeline|workflows|tests)/[\w/.]*)`", text_of(page)):
            assert (ROOT / path).exists(), f"{page}: {path}"


def test_every_page_is_in_the_contents():
    listed = re.findall(r"^(?:.*<)?(\w+)>?$", text_of("workflows/index.md"), re.MULTILINE)
    assert {path.stem for path in WORKFLOWS.glob("*.md")} - {"index"} <= set(listed)


def test_the_front_shows_four_figures():
    front = README + text_of("workflows/index.md")
    figures = re.findall(r"!\[[^\]]+\]\(([^)]+)\)", front)
    assert len(set(figures)) == 4
    assert all((WORKFLOWS / Path(name).name).exists() for name in figures)


def test_make_scenes_draws_the_pictures_of_the_page_on_scenes():
    (names,) = re.findall(r"^SCENES = (.*)$", text_of("Makefile"), re.MULTILINE)
    pictures = re.findall(r"!\[[^\]]+\]\((\w+)\.png\)", text_of("workflows/SCENES.md"))
    assert pictures == names.split()
    assert all((WORKFLOWS / f"{name}.toml").exists() for name in pictures)
    sizes = [(WORKFLOWS / f"{name}.png").stat().st_size for name in pictures]
    assert 0 < min(sizes) <= max(sizes) < 60_000


def test_the_first_screen_has_the_commands_of_a_fresh_machine():
    screen = "\n".join(README.splitlines()[:35])
    for target in ("diagram", "test"):
        assert f"\nmake {target} " in screen
        assert f"\n{target}: .venv/" in text_of("Makefile")


def test_the_agreement_is_that_of_the_page_on_the_paper():
    page = text_of("workflows/REPRODUCING.md")
    ((low, high),) = re.findall(r"critical velocities are ([−+]\d+) to ([−+]\d+) % off", page)
    assert f" {low} to {high} % off" in README
    lists = re.findall(r"((?:[−+]\d+, )+[−+]\d+) % off, each from the other three", page)
    held_out = [int(number.replace("−", "-")) for text in lists for number in text.split(", ")]
    assert len(held_out) == 8
    assert f" −{-min(held_out)} to +{max(held_out)} % off" in README


def test_the_numbers_of_the_first_hour_are_those_printed(folder_with_results, capsys, monkeypatch):
    monkeypatch.chdir(folder_with_results)
    page = " ".join(text_of("workflows/FIRST_HOUR.md").split())
    velocities = re.findall(r"(\d\.\d+) m/s", page.partition("## 2.")[2].partition("## 3.")[0])
    assert main(["boundary", "results/first_try.zarr"]) == 0
    printed = capsys.readouterr().out
    assert len(velocities) == 4
    assert [velocity for velocity in velocities if velocity not in printed] == [], printed
    assert main(["margin", "first_try", "--load", "300 N", "--velocity", "1.8 m/s"]) == 0
    printed, at_300_newtons = capsys.readouterr().out, page.partition("At 300 N")[2]
    limits = re.findall(r"(\d+ N|\d\.\d+)", at_300_newtons.partition("At 500 N")[0])
    assert len(limits) == 5
    assert [limit for limit in limits if limit not in printed] == [], printed
    numbers = re.findall(r"here ([\d.]+ [%K])|(\d+ % to \d+ %)|(−[\d.]+ to \+\d+ %)", page)
    assert main(["margin", "first_try", "--load", "500 N", "--velocity", "2 m/s"]) == 0
    printed = capsys.readouterr().out
    assert len(numbers) == 4
    assert ["".join(groups) for groups in numbers if "".join(groups) not in printed] == [], printed


def test_the_bounds_of_presets_are_those_of_the_answers():
    page = text_of("workflows/CHOOSING.md")
    stated = re.findall(r"^\| [^|]+ \| `(standard|fine)`[^|]* \| ([\d.]+) % \|", page, re.MULTILINE)
    assert {name: float(bound) / 100 for name, bound in stated} == pytest.approx(
        {name: PRESET_BOUNDS[name] for name in ("standard", "fine")}
    )
    (highest,) = re.findall(r"0 is the highest temperature \| (\d+) %", page)
    assert float(highest) / 100 == HIGHEST_TEMPERATURE_BOUNDS["standard"]
