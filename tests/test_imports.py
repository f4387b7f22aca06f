"""What an import costs: heavy libraries only where they are needed."""

import ast
import os
import subprocess
import sys
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[1]
HEAVY = {
    "dask",
    "distributed",
    "zarr",
    "xarray",
    "pandas",
    "matplotlib",
    "pint",
    "tqdm",
    "pipeline.run",
    "scipy",
    "scipy.fft",
    "scipy.special",
    "tribo.simulation",
}
SIMULATION = {"pipeline", "tribo", "scipy", "tribo.simulation"}


def loaded_by(code):
    """Heavy modules, and those of the project, that a fresh interpreter has loaded after `code`."""
    watched = HEAVY | {"pipeline", "tribo"}
    report = f"import sys\n{code}\nprint(*sorted({watched!r} & set(sys.modules)))"
    done = subprocess.run(
        [sys.executable, "-c", report],
        env=os.environ | {"PYTHONPATH": str(ROOT)},
        capture_output=True,
        text=True,
        check=True,
    )
    return set(done.stdout.splitlines()[-1].split())


def help_of(*arguments):
    """Code that asks the command for help."""
    return (
        "import contextlib, pipeline.cli as cli\nwith contextlib.suppress(SystemExit): "
        f"cli.main({list(arguments)!r})"
    )


def test_the_physics_need_numpy_and_scipy_alone():
    needed = set()
    for file in (ROOT / "tribo").rglob("*.py"):
        for line in ast.walk(ast.parse(file.read_text(encoding="utf-8"))):
            if isinstance(line, ast.Import):
                needed |= {name.name.partition(".")[0] for name in line.names}
            elif isinstance(line, ast.ImportFrom) and line.level == 0:
                needed.add(line.module.partition(".")[0])
    assert needed - sys.stdlib_module_names == {"numpy", "scipy", "tribo"}


@pytest.mark.parametrize("package", ["tribo", "pipeline", "pipeline.store"])
def test_no_name_that_is_loaded_when_used_is_that_of_a_module_beside_it(package):
    """Whichever was imported first would hide the other."""
    folder = ROOT.joinpath(*package.split("."))
    stub = ast.parse((folder / "__init__.pyi").read_text(encoding="utf-8"))
    lines = [line for line in stub.body if isinstance(line, ast.ImportFrom) and line.module]
    names = {name.name for line in lines for name in line.names}
    assert len(names) > 10
    assert not names & {path.stem for path in folder.iterdir()}


@pytest.mark.parametrize(
    ("code", "allowed"),
    [
        ("import tribo", {"tribo"}),
        ("import tribo.analytic", {"tribo", "scipy"}),
        ("import pipeline", {"pipeline"}),
        ("import pipeline.cli", {"pipeline", "tribo"}),
        (help_of("--help"), {"pipeline", "tribo"}),
        (help_of("run", "--help"), {"pipeline", "tribo"}),
        ("import pipeline; pipeline.run_point", SIMULATION),
        ("import pipeline; pipeline.summary", SIMULATION),
        ("import pipeline; pipeline.open_sweep", SIMULATION | {"xarray", "pandas"}),
    ],
)
def test_an_import_loads_no_more_than_it_needs(code, allowed):
    assert loaded_by(code) <= allowed


def test_reading_scenes_in_the_usual_units_loads_no_library_of_units():
    scenes = [path for path in (ROOT / "workflows").glob("*.toml") if path.stem != "uncertain"]
    assert scenes
    code = f"import pipeline; [pipeline.load_scene(path) for path in {list(map(str, scenes))!r}]"
    assert loaded_by(code) <= SIMULATION


def test_every_public_name_is_there():
    import pipeline
    import tribo

    for module in (pipeline, tribo):
        for name in module.__all__:
            assert getattr(module, name) is not None
    modules = {path.stem for path in (ROOT / "pipeline").iterdir()}
    # A module, once imported, would take the place of a function of its name.
    assert not modules & set(pipeline.__all__)
    with pytest.raises(AttributeError, match="attribute nonsense"):
        _ = pipeline.nonsense
