"""Scenes and stores of strangers: nothing that they name is imported, run or called."""

import sys

import pytest

import pipeline
from tests.helpers.scenes import SCENE
from tests.pipeline.conftest import commit_all

PAYLOAD = """
import pathlib
import tribo

pathlib.Path({marker!r}).touch()

class Law:
    pattern = "swept"

    def over(self, begin, end, pressure, velocity):
        return tribo.Wear(1e-15)


class Flat:
    def heights(self, pixels):
        return 0.0

"""
NAMING = {
    "wear": 'without = ["wear"]\nwear = { law = "payload:Law" }\n',
    "surface": 'without = ["disk.roughness"]\ndisk.surface = { law = "payload:Flat" }\n',
}
AT = ["--load", "400 N", "--velocity", "2 m/s"]


@pytest.fixture(scope="module")
def done(tmp_path_factory):
    """Folder with the sound store of a small sweep."""
    folder = tmp_path_factory.mktemp("done")
    (folder / "small.toml").write_text(SCENE.replace("increments = 10", "increments = 1"))
    commit_all(folder / "small.zarr", pipeline.load_scene(folder / "small.toml"))
    return folder


@pytest.fixture
def strangers(tmp_path, monkeypatch, request):
    """Working folder with hostile scenes; a file `ran` appears if their code was run."""
    folder = tmp_path / "strangers"
    (folder / "deep").mkdir(parents=True)
    # A module of the same path and text is not run again, so each test has another text.
    text = PAYLOAD.format(marker=str(tmp_path / "ran")) + f"# {request.node.name}\n"
    (folder / "payload.py").write_text(text)
    (folder / "deep" / "payload.py").write_text(text)
    (tmp_path / "linked.py").write_text(text)
    (folder / "linked.py").symlink_to(tmp_path / "linked.py")
    (folder / "small.toml").write_text(SCENE)
    for name, lines in NAMING.items():
        (folder / f"{name}.toml").write_text(f'extends = "small.toml"\n{lines}')
    (folder / "extends.toml").write_text('extends = "wear.toml"\ntitle = "Harmless"\n')
    monkeypatch.chdir(folder)
    monkeypatch.syspath_prepend(str(folder))  # as python -m pipeline does
    yield folder
    assert "payload" not in sys.modules


@pytest.fixture
def ran(tmp_path):
    return (tmp_path / "ran").exists


def write(store, root):
    """Write another root document into a store."""
    (store / "zarr.json").write_bytes(root.documents()["zarr.json"])


COMMANDS = [
    ["check"],
    ["run", "-o", "out.zarr"],
    ["run", "-o", "out.zarr", "--accuracy", "5%"],
    ["point", *AT],
    ["infer"],
    ["trade"],
]


@pytest.mark.parametrize(
    ("command", "scene"),
    [(command, "wear") for command in COMMANDS]
    + [(COMMANDS[0], scene) for scene in ("surface", "extends")],
)
def test_a_scene_that_names_code_is_refused_and_runs_nothing(strangers, ran, irg, command, scene):
    said = irg(command[0], f"{scene}.toml", *command[1:], code=2)
    assert "unknown" in said
    assert not ran()
    assert not (strangers / "out.zarr").exists()
