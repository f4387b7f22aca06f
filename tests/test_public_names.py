"""Public names: what they need, where they are described, their examples, and types of calls."""

import ast
import dataclasses
import doctest
import importlib
import inspect
import pkgutil
import re
import subprocess
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


def test_only_jobs_recorders_and_the_insides_of_caches_can_be_changed():
    modules = [
        importlib.import_module(module.name)
        for package in (pipeline, tribo)
        for module in pkgutil.walk_packages(package.__path__, f"{package.__name__}.")
    ]
    classes = {thing for module in modules for thing in vars(module).values() if is_record(thing)}
    changeable = {record.__name__ for record in classes if not record.__dataclass_params__.frozen}
    assert changeable == {"_Job", "Recorder", "PointMemo", "_Trunk"}


def is_record(thing):
    return isinstance(thing, type) and dataclasses.is_dataclass(thing)


def test_types_that_public_functions_return_are_described_on_the_page():
    frames = {"Dataset", "DataArray", "DataFrame"}
    elsewhere = {"Array", "Any", "Callable", "Figure", "Path", "None"} | frames
    described = set(re.findall(r"### `pipeline[.\w]*\.(\w+)`", API))
    known = {*pipeline.__all__, *dir(tribo), *elsewhere, *described}
    for name in pipeline.__all__:
        function = getattr(pipeline, name)
        if inspect.isfunction(function):
            returned = inspect.signature(function).return_annotation
            assert set(re.findall(r"\b[A-Z]\w+", returned)) <= known, name


def test_every_public_name_stands_in_the_table_of_the_page():
    tasks = API.partition("## `pipeline`")[0]
    assert set(re.findall(r"`pipeline\.(\w+)`", tasks)) == set(pipeline.__all__)


def test_help_on_tribo_has_all_public_names_and_an_example_that_runs():
    modules = {path.stem for path in (ROOT / "tribo").iterdir()} - {"analytic"}
    public = {name for name in dir(tribo) if not name.startswith("_")} - modules
    text, listed = tribo.__doc__.split("The public names")
    assert set(re.findall(r"`(\w+)`", listed)) == public
    exec(textwrap.dedent(text.partition("::")[2]), names := {})
    assert isinstance(names["oil"], tribo.Conditions)


# Examples

# These take minutes, or a cluster of their own.
LONG = {"sensitivity", "trade"}  # it measures for a minute or more
PUBLIC = [
    (module.__name__, name)
    for module, names in ((pipeline, pipeline.__all__), (tribo, vars(tribo)))
    for name in names
    if callable(getattr(module, name)) and not name.startswith("_")
]


@pytest.mark.parametrize(("module", "name"), PUBLIC)
def test_a_public_name_has_an_example_that_runs(module, name):
    documented = inspect.getdoc(getattr({"pipeline": pipeline, "tribo": tribo}[module], name))
    examples = doctest.DocTestParser().get_examples(documented)
    runs = [example for example in examples if doctest.SKIP not in example.options]
    assert examples
    assert runs or name in LONG


# Types of calls

CALLS = """
from pathlib import Path
import numpy as np
import pipeline
ds = pipeline.open_sweep("a.zarr")
pipeline.boundary(Path("a.zarr"), friction=np.array([0.1, 0.15, 0.2]))
pipeline.temperatures(ds)
pipeline.margin(ds, "400 N", 1.5)["verdict"].item()
pipeline.margin("a.zarr", {"load": ["400 N"], "velocity": [2.0]})["verdict"]
pipeline.margin(ds, "400 N", 1.5, friction=0.12)["probability"]
pipeline.plot(ds, "diagram", load="400 N", velocity=2.0, out="a.png")
"""
SLIPS = """
import pipeline
ds = pipeline.open_sweep("a.zarr")
pipeline.margin(ds, "400 N", 1.5, frction=0.12)
pipeline.plot(ds, "diagramm")
pipeline.plot(ds, "diagram", lod="400 N")
pipeline.load_scene("first_try", preset="drat")
pipeline.run_sweep("first_try", "a.zarr", workers="4")
"""


@pytest.fixture(scope="module")
def refused(tmp_path_factory):
    """Numbers of the lines of both scripts that mypy refuses, by name of the script."""
    folder = tmp_path_factory.mktemp("calls")
    for name, text in (("calls", CALLS), ("slips", SLIPS)):
        (folder / f"{name}.py").write_text(text)
    command = [sys.executable, "-m", "mypy", "--hide-error-context", *folder.glob("*.py")]
    done = subprocess.run(command, cwd=ROOT, capture_output=True, text=True, check=False)
    matches = re.findall(r"(\w+)\.py:(\d+): error", done.stdout)
    return {
        name: {int(line) for stem, line in matches if stem == name} for name in ("calls", "slips")
    }


def test_a_type_checker_finds_slips_of_a_user(refused):
    lines = SLIPS.splitlines()
    right = 'ds = pipeline.open_sweep("a.zarr")'
    assert refused["slips"] == {
        number for number, line in enumerate(lines, 1) if "(" in line and line != right
    }


def test_a_type_checker_accepts_the_calls_that_the_pages_describe(refused):
    assert refused["calls"] == set()
