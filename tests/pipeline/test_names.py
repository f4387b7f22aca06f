"""The public names of the package (pipeline/__init__.pyi)."""

import ast
import importlib
import pydoc
import rlcompleter
from pathlib import Path

import pytest

import pipeline

STUB = ast.parse(Path(pipeline.__file__).with_suffix(".pyi").read_text())
HOMES = {name.asname: statement.module for statement in STUB.body for name in statement.names}


def test_the_stub_says_where_each_public_name_lives():
    assert sorted(HOMES) == sorted(pipeline.__all__) == sorted(dir(pipeline))


@pytest.mark.parametrize("name", pipeline.__all__)
def test_a_public_name_is_that_of_its_module(name):
    home = importlib.import_module(f"pipeline.{HOMES[name]}")
    assert getattr(pipeline, name) is getattr(home, name)


def test_help_shows_the_public_names():
    shown = pydoc.render_doc(pipeline, renderer=pydoc.plaintext)
    assert all(name in shown for name in pipeline.__all__)


def test_completion_offers_the_public_names():
    completer = rlcompleter.Completer({"pipeline": pipeline})
    assert completer.complete("pipeline.open_s", 0).startswith("pipeline.open_sweep")
