import json
import re
import shutil
from base64 import b64encode

import pytest

from pipeline.cli import main
from tests.helpers import tiny
from tests.helpers.stores import commit_all


@pytest.fixture(scope="session")
def tiny_store(tmp_path_factory):
    """Store of the tiny sweep with fields, each point simulated from the start."""
    path = tmp_path_factory.mktemp("alone") / "tiny.zarr"
    commit_all(path, tiny.full(), shares_ramps=False)
    return path


@pytest.fixture
def path(tmp_path):
    """Path for a new store."""
    return tmp_path / "tiny.zarr"


@pytest.fixture
def copy(tiny_store, tmp_path):
    """Path of a copy of the store `tiny_store`, which a test may change."""
    return shutil.copytree(tiny_store, tmp_path / "tiny.zarr")


def leave_out_pictures(monkeypatch):
    """Replace the pictures of a report, which take seconds to draw, by empty ones."""
    from pipeline.page import report

    empty = f"data:image/svg+xml;base64,{b64encode(b'<svg/>').decode()}"
    monkeypatch.setattr(report, "_picture", lambda _, caption: {"url": empty, "caption": caption})


@pytest.fixture
def undrawn(monkeypatch):
    """Reports of the test have empty pictures."""
    leave_out_pictures(monkeypatch)


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
