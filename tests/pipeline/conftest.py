import json
import re
import shutil
from base64 import b64encode

import numpy as np
import pytest

from pipeline.cli import main
from pipeline.run.serial import run_serial
from pipeline.store.create import writing
from pipeline.sweep.plan import points
from tests.helpers import tiny
from tests.helpers.points import run_point


def commit_all(path, sweep, skip=()):
    """Create the store of a sweep, and compute its points in this process."""
    with writing(path, sweep) as store:
        selected = [point for point in points(sweep) if point not in skip]
        store.commit(run_point(sweep, point).record(sweep.fields) for point in selected)
        run_serial(store)


@pytest.fixture(scope="session")
def tiny_store(tmp_path_factory):
    """Store of the tiny sweep with fields, each point simulated from the start."""
    path = tmp_path_factory.mktemp("alone") / "tiny.zarr"
    with np.errstate(all="raise", under="ignore"):
        commit_all(path, tiny.full())
    return path


@pytest.fixture
def path(tmp_path):
    """Path for a new store."""
    return tmp_path / "tiny.zarr"


@pytest.fixture
def copy(tiny_store, tmp_path):
    """Path of a copy of the store `tiny_store`, which a test may change."""
    return shutil.copytree(tiny_store, tmp_path / "tiny.zarr")


@pytest.fixture
def undrawn(monkeypatch):
    """Replace the pictures of a report, which take seconds to draw, by empty ones."""
    from pipeline.page import elements

    empty = f"data:image/svg+xml;base64,{b64encode(b'<svg/>').decode()}"
    monkeypatch.setattr(
        elements, "figure_of", lambda _, *texts: elements.PageFigure(empty, empty, *texts)
    )


_PROGRESS = re.compile(r"^irg: .*, [^,]+ so far(, [^,]+ to go)?\n", re.MULTILINE)


@pytest.fixture
def irg(capsys):
    """Function that runs a command and returns its output, or its document with --json.

    It asserts the exit code. Progress lines are left out: only a slow machine prints them.
    """

    def run_command(*arguments, code=0):
        capsys.readouterr()
        try:
            ended = main([str(argument) for argument in arguments])
        except SystemExit as error:
            ended = error.code
        assert ended == code
        printed = capsys.readouterr()
        if "--json" in arguments:
            return json.loads(printed.out)
        return printed.out + _PROGRESS.sub("", printed.err)

    return run_command
