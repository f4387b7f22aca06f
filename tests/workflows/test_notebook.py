"""The notebooks: what they store, and what their cells show.

`make notebooks` runs them whole, in kernels, and stores what the cells show.
"""

import ast
import base64
import contextlib
import getpass
import io
import json
import re
import shutil
from pathlib import Path

import matplotlib as mpl
import pandas as pd
import pytest
from matplotlib.figure import Figure
from PIL import Image

WORKFLOWS = Path(__file__).parents[2] / "workflows"
NOTEBOOKS = "first_diagram", "steps"
_OF_A_RUN = (
    r"/(home|root|tmp|usr|var|work|Users|opt)/|[A-Z]:\\",  # paths of one machine
    r"localhost|\b\d+\.\d+\.\d+\.\d+\b|:\d{4,5}\b",  # addresses and ports
    r"\x1b|0x[0-9a-f]{6,}",  # terminal colours, and addresses in memory
)


@pytest.fixture(scope="module")
def folder(tmp_path_factory, folder_with_results):
    """Folder in which the notebooks run, with results of the scene that two of them simulate."""
    folder = tmp_path_factory.mktemp("notebooks")
    store = folder_with_results / "results" / "first_try.zarr"
    for name in "first_diagram", "explore":
        shutil.copytree(store, folder / "results" / f"{name}.zarr")
    return folder


@pytest.fixture(autouse=True)
def _in_folder(folder, monkeypatch):
    monkeypatch.chdir(folder)
    with (
        pd.option_context("display.max_columns", 20, "display.width", 80),  # options of a kernel
        mpl.rc_context({"savefig.dpi": 40}),
    ):
        yield


def code_cells(name):
    """Code cells of a notebook."""
    text = (WORKFLOWS / f"{name}.ipynb").read_text(encoding="utf-8")
    return [cell for cell in json.loads(text)["cells"] if cell["cell_type"] == "code"]


def source_of(cell):
    return "".join(cell["source"])


def stored_texts(output, with_html=False):
    """Text of a stored output: printed lines, or the last expression of a cell."""
    data = output.get("data", {})
    kinds = ("text/plain", "text/html") if with_html else ("text/plain",)
    return "".join([*output.get("text", ""), *("".join(data.get(kind, "")) for kind in kinds)])


def stored_text(cell):
    return "\n".join(stored_texts(output).strip() for output in cell["outputs"])


def stored_pictures(name):
    """Figures that a notebook stores, as bytes of PNG."""
    return [
        base64.b64decode("".join(output["data"]["image/png"]))
        for cell in code_cells(name)
        for output in cell["outputs"]
        if "image/png" in output.get("data", {})
    ]


def run_cells(name):
    """Run a notebook; return the text that each cell shows, and the figures."""
    cells = code_cells(name)
    assert len(cells) > 4
    sources = [source_of(cell) for cell in cells]
    assert sum(source.count("assert ") for source in sources) >= 2
    names, figures, texts = {}, [], []
    for source in sources:
        printed, value = io.StringIO(), None
        with contextlib.redirect_stdout(printed):
            *lines, last = ast.parse(source).body
            exec(compile(ast.Module(lines, []), name, "exec"), names)
            if isinstance(last, ast.Expr):
                value = eval(compile(ast.Expression(last.value), name, "eval"), names)
            else:
                exec(compile(ast.Module([last], []), name, "exec"), names)
        if isinstance(value, Figure):
            value.savefig(picture := io.BytesIO(), format="png")
            figures.append(picture.getvalue())
            value = None
        parts = [printed.getvalue(), *([] if value is None else [repr(value)])]
        texts.append("\n".join(filter(None, map(str.strip, parts))))
    return texts, figures


def numbers_apart(text):
    """Text with each number replaced by #, and its numbers."""
    number = r"\d+(?:\.\d+)?(?:e[+-]?\d+)?"
    return re.sub(r"[\s#]+", " ", re.sub(number, "#", text)).strip(), [
        float(match) for match in re.findall(number, text)
    ]


def assert_stored(name, texts):
    """Assert that cells show what the notebook stores; return how many show something."""
    compared = 0
    for number, (cell, text) in enumerate(zip(code_cells(name), texts, strict=True)):
        stored = stored_text(cell)
        (words, numbers), (old_words, old) = numbers_apart(text), numbers_apart(stored)
        assert words == old_words, f"cell {number}: run make notebooks"
        assert numbers == pytest.approx(old, rel=1e-3), f"cell {number}: run make notebooks"
        compared += bool(stored)
    return compared


@pytest.mark.parametrize("name", NOTEBOOKS)
def test_a_notebook_stores_what_its_cells_show_and_nothing_of_a_machine(name):
    path = WORKFLOWS / f"{name}.ipynb"
    assert path.stat().st_size < 200_000
    cells = code_cells(name)
    assert [cell["execution_count"] for cell in cells] == list(range(1, len(cells) + 1))
    for cell in cells:
        *_, last = ast.parse(source_of(cell)).body
        shows = isinstance(last, ast.Expr) or "print(" in source_of(cell)
        assert bool(cell["outputs"]) == shows, source_of(cell)
        for output in cell["outputs"]:
            assert output["output_type"] in ("stream", "execute_result")
            assert output.get("name", "stdout") == "stdout"
            words = stored_texts(output, with_html=True)
            for pattern in (*_OF_A_RUN, rf"\b{re.escape(getpass.getuser())}\b"):
                assert not re.search(pattern, words), (pattern, words)
    pictures = stored_pictures(name)
    assert pictures
    for picture in pictures:
        with Image.open(io.BytesIO(picture)) as image:
            assert (image.format, image.mode) == ("PNG", "P")
            assert 400 < image.width <= 800
            assert len(image.getcolors()) > 10


@pytest.mark.parametrize(
    ("name", "pictures", "min_numbers"),
    [("first_diagram", 1, 4), pytest.param("steps", 4, 1, marks=pytest.mark.slow)],
)
def test_a_notebook_shows_what_it_stores(name, pictures, min_numbers):
    texts, figures = run_cells(name)
    assert len(figures) == len(stored_pictures(name)) == pictures
    assert assert_stored(name, texts) >= min_numbers


def test_the_sliders_show_what_the_commands_answer():
    pytest.importorskip("ipywidgets")
    first, second, call = map(source_of, code_cells("explore"))
    names = {}
    exec(first, names)
    with contextlib.redirect_stdout(io.StringIO()) as printed:
        exec(second, names)
        printed.truncate(0)
        figure = eval(call, names)
    judged = {"friction": 0.12, "bulk_temperature": "40 degC"}
    answer = names["pipeline"].margin(names["ds"], 400.0, 1.6, **judged)
    assert names["headline"](answer) in printed.getvalue()
    assert isinstance(figure, Figure)
