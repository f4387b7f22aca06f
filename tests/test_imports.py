"""Libraries that imports need, and names that they give."""

import ast
import inspect
import re
import sys
import textwrap
from pathlib import Path

import pytest

import pipeline
import tribo

ROOT = Path(__file__).parents[1]
API = (ROOT / "workflows" / "API.md").read_text(encoding="utf-8")


def test_the_physics_need_numpy_and_scipy_alone():
    needed = set()
    for file in (ROOT / "tribo").rglob("*.py"):
        for line in ast.walk(ast.parse(file.read_text(encoding="utf-8"))):
            if isinstance(line, ast.Import):
                needed |= {name.name.partition(".")[0] for name in line.names}
            elif isinstance(line, ast.ImportFrom) and line.level == 0:
                needed.add(line.module.partition(".")[0])
    assert needed - sys.stdlib_module_names == {"numpy", "scipy", "tribo"}


def test_every_public_name_is_there():
    for name in pipeline.__all__:
        assert getattr(pipeline, name) is not None
    modules = {path.stem for path in (ROOT / "pipeline").iterdir()}
    assert not modules & set(pipeline.__all__)  # an imported module would hide the name
    with pytest.raises(AttributeError, match="attribute nonsense"):
        _ = pipeline.nonsense


def test_types_that_public_functions_return_are_described_on_the_page():
    frames = {"Dataset", "DataArray", "DataFrame"}
    elsewhere = {"Array", "Any", "Callable", "Figure", "Path", "None"} | frames
    described = set(re.findall(r"autoclass:: pipeline[.\w]*\.(\w+)", API))
    known = {*pipeline.__all__, *dir(tribo), *elsewhere, *described}
    for name in pipeline.__all__:
        function = getattr(pipeline, name)
        if inspect.isfunction(function):
            returned = inspect.signature(function).return_annotation
            assert set(re.findall(r"\b[A-Z]\w+", returned)) <= known, name


def test_every_public_name_stands_in_the_table_of_the_page():
    assert set(re.findall(r"`pipeline\.(\w+)`", API)) == set(pipeline.__all__)


def test_help_on_tribo_has_all_public_names_and_an_example_that_runs():
    modules = {path.stem for path in (ROOT / "tribo").iterdir()} - {"analytic"}
    public = {name for name in dir(tribo) if not name.startswith("_")} - modules
    text, listed = tribo.__doc__.split("The public names")
    assert set(re.findall(r"`(\w+)`", listed)) == public
    exec(textwrap.dedent(text.partition("::")[2]), names := {})
    assert isinstance(names["oil"], tribo.Conditions)
