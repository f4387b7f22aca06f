"""The notebooks, cell by cell on smaller scenes, and UNCERTAIN.md's commands on what one stores.

`make docs` runs them whole, in kernels.
"""

import ast
import contextlib
import io
import json
import re
import shlex
from pathlib import Path

import pytest
from matplotlib.figure import Figure

import pipeline
from pipeline.cli import main
from pipeline.uncertain import design, next_tests, sensitivity
from tests.helpers.samples import fewer_draws

WORKFLOWS = Path(__file__).parents[2] / "workflows"
SMALLER = {
    "first_diagram": (),
    "stations": (
        '"sweep.fields": True',
        '"sweep.fields": True, "sweep.loads": ["600 N", "750 N"], "sweep.velocities": ["1.6 m/s"]',
    ),
    "uncertain": (
        '{"sweep.samples": SAMPLES}',
        '{"sweep.samples": 24, "sweep.loads": ["200 N", "400 N", "750 N"]}',
    ),
}


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    """Where the notebooks write, without the scenes."""
    return tmp_path_factory.mktemp("notebooks")


@pytest.fixture(autouse=True)
def _there_with_few_draws(folder, monkeypatch):
    monkeypatch.chdir(folder)
    fewer_draws(monkeypatch)
    monkeypatch.setattr(design, "SIMULATED", 24)
    monkeypatch.setattr(next_tests, "_TRUTHS", 32)
    monkeypatch.setattr(sensitivity, "_POINTS", 2**8)


def run_cells(name):
    """What the cells of a notebook print, and the figures that they show."""
    text = (WORKFLOWS / f"{name}.ipynb").read_text(encoding="utf-8")
    cells = [cell for cell in json.loads(text)["cells"] if cell["cell_type"] == "code"]
    assert len(cells) > 4
    assert all(cell["outputs"] == [] and cell["execution_count"] is None for cell in cells)
    sources = ["".join(cell["source"]) for cell in cells]
    if SMALLER[name]:
        assert SMALLER[name][0] in sources[0]
        sources[0] = sources[0].replace(*SMALLER[name])
    assert sum(source.count("assert ") for source in sources) >= 2
    names, figures, printed = {}, [], io.StringIO()
    with contextlib.redirect_stdout(printed):
        for source in sources:
            *lines, last = ast.parse(source).body
            exec(compile(ast.Module(lines, []), name, "exec"), names)
            if isinstance(last, ast.Expr):
                shown = eval(compile(ast.Expression(last.value), name, "eval"), names)
                if isinstance(shown, Figure):
                    figures.append(shown._repr_png_())
            else:
                exec(compile(ast.Module([last], []), name, "exec"), names)
    return printed.getvalue(), figures


def test_the_short_notebooks_keep_their_assertions():
    _, figures = run_cells("first_diagram")
    assert len(figures) == 1
    printed, figures = run_cells("stations")
    assert len(figures) == 1
    assert "/status" in printed  # the link of the dashboard


def test_the_notebook_leads_from_transitions_to_a_map_and_the_next_test():
    printed, figures = run_cells("uncertain")
    assert len(figures) == 4
    before, *ends, after, again = map(
        float, re.findall(r"(\d\.\d\d)\b", printed.split("samples")[-1])[:5]
    )
    prior = pipeline.margin("results/uncertain.zarr", 400.0, 2.0)
    expected = [round(one, 2) for one in (prior.probability, prior.lowest, prior.highest)]
    assert [before, *ends] == expected
    assert after < before == again
    assert printed.count("% instead of ±") == 6


def test_the_commands_of_the_page_lead_to_a_probability_and_the_next_test(capsys):
    page = (WORKFLOWS / "UNCERTAIN.md").read_text(encoding="utf-8")
    commands = re.findall(r"^irg .*$", page, flags=re.MULTILINE)
    assert len(commands) == 13
    printed = []
    for command in commands[2:]:  # the first two tell the cost, and run what the notebook ran
        arguments = shlex.split(command)[1:]
        if "posterior.png" in command or "given-measured" in command:
            arguments += ["--scatter", "10%"]
        assert main(arguments) == 0
        printed.append(capsys.readouterr().out)
    assert "severe wear is" in printed[0]
    assert "measurements to make next" in "".join(printed)
    assert "velocities that are all read too high would look like a better oil" in "".join(printed)
    assert re.search(r"effective sample size \d+ of \d+", "".join(printed))
    (factor,) = re.findall(r"velocity factor *(\d\.\d+)", printed[0])
    assert 0.5 < float(factor) < 3
    asked = re.findall(r"^irg .*-o (results/\S+\.png)$", page, flags=re.MULTILINE)
    assert len(asked) == 4
    assert sorted(map(str, Path("results").glob("*.png"))) == sorted(asked)
    near = pipeline.margin("results/uncertain.zarr", 400.0, 2.0).probability
    (probability,) = re.findall(r"probability of severe wear of (\d\.\d+) there", page)
    assert abs(near - float(probability)) < 0.15  # as far as so few samples tell
