"""Scenes and stores of strangers: nothing that they name is imported, run or called."""

import shutil
import sys
from dataclasses import replace

import pytest

import pipeline
from pipeline.scene.stored_text import sweep_text
from pipeline.store.place import place_of
from pipeline.store.root_file import read_root
from pipeline.sweep.conditions import criterion_of
from pipeline.sweep.laws import StoredRule
from tests.helpers.entries import changed
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


rule = tribo.Rule("mean_rise", lambda rises, *_: rises, "mean", "the mean above")
"""
NAMING = {
    "wear": 'without = ["wear"]\nwear = { law = "payload:Law" }\n',
    "surface": 'without = ["disk.roughness"]\ndisk.surface = { law = "payload:Flat" }\n',
    "criterion": 'temperature.criterion = "payload:rule"\n',
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


def forged(done, folder, criterion):
    """Copy the store into a folder, and change its stored criterion; return its name."""
    target = shutil.copytree(done / "small.zarr", folder / "small.zarr")
    root = read_root(place_of(target))
    kind = StoredRule(criterion, (), "0" * 64) if ":" in criterion else criterion
    judged = replace(root.sweep.conditions, criterion=criterion_of(kind, 0.1))
    sweep = changed(root.sweep, conditions=judged)
    write(target, replace(root, sweep=sweep, text=sweep_text(sweep)))
    shutil.copy(folder / "payload.py", target)
    return target.name


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
    + [(COMMANDS[0], scene) for scene in ("surface", "criterion", "extends")],
)
def test_a_scene_that_names_code_is_refused_and_runs_nothing(strangers, ran, irg, command, scene):
    said = irg(command[0], f"{scene}.toml", *command[1:], code=2)
    assert "unknown" in said
    assert not ran()
    assert not (strangers / "out.zarr").exists()


def test_looking_at_a_folder_of_strangers_runs_nothing(strangers, done, ran, irg):
    forged(done, strangers, "payload:rule")
    assert "small.zarr" in irg("status", ".")
    assert irg("status", "small.zarr", "--json")[0]["done"] == 9
    assert irg("verify", "small.zarr", "--json")["damaged"] == []
    assert irg("plot", "small.zarr", "-o", "out.png", "--kind", "fields", *AT)
    assert not ran()


STORED = ["payload:rule", "{folder}/payload:rule", "small.zarr/payload:rule", "os:_exit"]
READING = [
    ["boundary"],
    ["margin", "--points", "duty.csv"],
    ["plot", "-o", "out.png"],
]


@pytest.mark.parametrize(
    ("command", "stored"),
    [(command, STORED[0]) for command in READING]
    + [(["boundary"], stored) for stored in STORED[1:]],
)
def test_a_store_runs_nothing_and_writes_no_empty_answer(
    strangers, done, ran, irg, command, stored
):
    (strangers / "duty.csv").write_text("load [N],velocity [m/s]\n400,2\n")
    store = forged(done, strangers, stored.format(folder=strangers))
    said = irg(command[0], store, *command[1:], code=2)
    assert "a Python object, of which it has only the name" in said
    assert not ran()
    assert not [*strangers.glob("out*")]


def test_a_store_whose_chunks_would_be_unpickled_is_read_by_its_format(strangers, done, ran, irg):
    store = forged(done, strangers, "share")
    root = read_root(place_of(strangers / store))
    message = root.arrays["message"]
    root.arrays["message"] = {
        "zarr_format": 2,
        "attributes": {},
        "shape": message["shape"],
        "chunks": message["shape"],
        "dimension_names": message["dimension_names"],
        "dtype": "|O",
        "fill_value": "",
        "order": "C",
        "filters": [{"id": "vlen-utf8"}],
        "compressor": {"id": "pickle", "protocol": 5},
    }
    write(strangers / store, root)
    assert "points: 9 done and intact" in irg("verify", store)
    assert "critical" in irg("boundary", store)
    assert not ran()


@pytest.mark.parametrize("name", ["{folder}/outside", "../outside", "deep/load"])
def test_a_store_names_no_files_outside_it(strangers, done, irg, name):
    store = forged(done, strangers, "share")
    root = read_root(place_of(strangers / store))
    outside = name.format(folder=strangers)
    root.arrays[outside], root.axes[outside] = root.arrays["steps"], root.axes["load"]
    write(strangers / store, root)
    for command in ("status", "verify", "boundary"):
        said = irg(command, store, code=2)
        assert "is damaged, or not that of a sweep" in said
    assert not (strangers / "outside").exists()
