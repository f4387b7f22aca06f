"""What is left without the folder of an extra."""

import ast
import json
import re
import shutil
import subprocess
import sys
from importlib import import_module
from pathlib import Path

import pytest

import pipeline
from pipeline.extras import EXTRAS

ROOT = Path(__file__).parents[2]
SMALL = ["--set", 'sweep.loads=["600 N"]', "--workers", "1"]
PLACE = ["--load", "600 N", "--velocity", "2.2 m/s"]


@pytest.fixture(scope="module")
def store(folder_with_results):
    """Path of a store written by the complete package."""
    return folder_with_results / "results/first_try.zarr"


def copy_without(left_out, folder):
    """Copy the packages into a folder, without some extras, as a git checkout would be."""
    # Compiled files are copied, too, except those that Python is just writing.
    ignored = shutil.ignore_patterns(*left_out, "*.pyc.*", "*.png")
    for package in ("tribo", "pipeline", "workflows"):
        shutil.copytree(ROOT / package, folder / package, ignore=ignored)
    for name in left_out:
        (folder / "pipeline" / name / "__pycache__").mkdir(parents=True)


def listed(text):
    """Set of commands that the help lists."""
    return set(re.findall(r"^    (\w+) ", text, flags=re.MULTILINE))


_SAID = """
import contextlib, io, json, os, sys

def said(folder, store, names, commands):
    os.chdir(folder)
    sys.path.insert(0, folder)
    import pipeline
    from pipeline.cli import main
    for name in pipeline.__all__:
        getattr(pipeline, name)
    present = {*pipeline.__all__, *dir(pipeline), *dir(pipeline.open_sweep(store).irg)}
    left = [name for name in names if name in present or hasattr(pipeline, name)]
    answers = []
    for words in commands:
        out = io.StringIO()
        with contextlib.redirect_stdout(out), contextlib.redirect_stderr(out):
            try:
                code = main(words)
            except SystemExit as end:
                code = end.code
        answers.append([code, out.getvalue()])
    return pipeline.__file__, len(pipeline.__all__), left, answers
"""
"""A function that tells which names are left, and what commands say, all in one process."""
_FORKING = f"""{_SAID}
import distributed, matplotlib.pyplot, pandas, pint, scipy.stats, xarray, zarr

for line in sys.stdin:
    if not os.fork():
        try:
            print(json.dumps(said(*json.loads(line))), flush=True)
        finally:
            os._exit(0)
    os.wait()
    print(flush=True)
"""
"""As that function for line after line, each in a fork that has no module of the packages yet."""


@pytest.fixture(scope="module")
def ask(tmp_path_factory):
    """Function that runs commands in copies of the packages, by forks of one process."""
    process = subprocess.Popen(
        [sys.executable, "-c", _FORKING],
        cwd=tmp_path_factory.mktemp("forking"), stdin=subprocess.PIPE, stdout=subprocess.PIPE,
        text=True,
    )  # fmt: skip

    def answer(*asked):
        print(json.dumps(asked), file=process.stdin, flush=True)
        *_, last = iter(process.stdout.readline, "\n")
        return json.loads(last)

    with process:
        yield answer


NEEDS = {
    "[[tested]]\nfile = 'log.csv'": "laboratory",
    "[sweep]\nalong = 'duty.xlsx'": "laboratory",
    "[disk.roughness]\nfile = 'scan.npy'\nheight_unit = 'um'": "laboratory",
}
"""Entries of a scene, and the extra that reads them."""


@pytest.mark.parametrize("left_out", [*([name] for name in EXTRAS), [*EXTRAS]], ids="-".join)
def test_without_its_folder_the_rest_works(left_out, store, ask, tmp_path):
    copy_without(left_out, tmp_path)
    gone = {
        one.name for name in left_out for one in import_module(f"pipeline.{name}.commands").COMMANDS
    }
    names = {name for extra in left_out for name in EXTRAS[extra]} | {*left_out}
    works = [
        ["check", "first_try", *SMALL],
        ["boundary", str(store)],
        ["margin", str(store), *PLACE],
        ["plot", str(store), "-o", "a.png"],
    ]
    needing = {entry: extra for entry, extra in NEEDS.items() if extra in left_out}
    without = "without = ['measured', 'disk.roughness']"
    (tmp_path / "duty.xlsx").write_bytes(b"PK")
    for number, entry in enumerate(needing):
        scene = f"extends = 'irg_transition'\n{without}\n{entry}\n"
        (tmp_path / f"{number}.toml").write_text(scene)
    asked = [
        ["--help"],
        *([name, str(store)] for name in sorted(gone)),
        *works,
        *(["check", f"{number}.toml"] for number in range(len(needing))),
    ]
    file, count, left, said = ask(str(tmp_path), str(store), sorted(names), asked)
    assert file == str(tmp_path / "pipeline" / "__init__.py")
    assert (count, left) == (len(set(pipeline.__all__) - names), [])
    codes = [code for code, _ in said]
    assert codes == [0, *[2] * len(gone), *[0] * len(works), *[2] * len(needing)], said
    there = listed(said[0][1])
    assert {"check", "run", "boundary", "margin", "plot", "trade"} <= there
    assert not gone & there
    for extra, (_, words) in zip(needing.values(), said[len(asked) - len(needing) :], strict=True):
        assert "unknown key" in words or ("put back" in words and f"pipeline/{extra}" in words)


def test_extras_stand_on_public_names_of_the_core():
    wrong = []
    for extra in EXTRAS:
        others = {*EXTRAS} - {extra}
        for file in (ROOT / "pipeline" / extra).rglob("*.py"):
            for line in ast.walk(ast.parse(file.read_text(encoding="utf-8"))):
                if isinstance(line, ast.ImportFrom) and (line.module or "").startswith("pipeline"):
                    place = [*line.module.split("."), ""][1]
                    names = [one.name for one in line.names]
                    is_private = place != extra and any(name.startswith("_") for name in names)
                    if place in others or is_private:
                        wrong.append(f"{file}: {line.module} {names}")
    assert wrong == []
