"""Folder in which examples of docstrings run: the shipped scenes, and the results of one.

A plugin of pytest, so that it reaches the packages: their folders hold no tests of their own.
"""

import fcntl
import os
import shutil
from pathlib import Path

import pytest
from _pytest.doctest import DoctestItem, DoctestModule

ROOT = Path(__file__).parents[2]


@pytest.hookimpl(wrapper=True)
def pytest_collect_file(file_path):
    """Collect doctests only from files with examples, so that the others are not imported."""
    collectors = yield
    if file_path.suffix == ".py" and ">>> " not in file_path.read_text(encoding="utf-8"):
        return [collector for collector in collectors if not isinstance(collector, DoctestModule)]
    return collectors


@pytest.fixture(autouse=True)
def _scenes_and_results(request, monkeypatch):
    if isinstance(request.node, DoctestItem):
        sources = "".join(example.source for example in request.node.dtest.examples)
        if request.node.dtest.name.startswith("tribo."):
            from workflows.paper import rig

            names = {"steel": rig.AISI_316, "scene": rig.critical_temperature_rig()}
            request.node.dtest.globs.update(names)
        if "results/" in sources:
            monkeypatch.chdir(request.getfixturevalue("folder_with_results"))


@pytest.fixture(scope="session")
def folder_with_results(tmp_path_factory):
    """Folder with ``workflows`` and ``results/first_try.zarr``, which an example may change."""
    root = tmp_path_factory.getbasetemp()
    root = root.parent if "PYTEST_XDIST_WORKER" in os.environ else root
    folder, partial = root / "examples-once", root / "examples-partial"
    with (root / "examples.lock").open("w") as lock:  # the first process of the suite fills it
        fcntl.flock(lock, fcntl.LOCK_EX)
        if not folder.exists():
            partial.mkdir(exist_ok=True)
            _fill(partial)
            partial.rename(folder)
    return shutil.copytree(folder, tmp_path_factory.mktemp("examples") / "own", symlinks=True)


def _fill(folder):
    (folder / "workflows").symlink_to(ROOT / "workflows")
    (folder / "results").mkdir()
    from pipeline import load_scene
    from tests.helpers.stores import commit_all

    scene = load_scene(folder / "workflows/first_try.toml")
    commit_all(folder / "results/first_try.zarr", scene)
