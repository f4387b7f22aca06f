"""Laws that a scene names: checked, stored with their hash, taken along to workers, refused."""

import hashlib
import pickle
import re
import shlex
import sys
from dataclasses import dataclass
from pathlib import Path

import numpy as np
import pytest

import pipeline
import tribo
from pipeline.analysis.dataset import stored_sweep
from pipeline.sweep.own_laws import Reference, refer
from tests.helpers.scenes import SCENE
from tests.pipeline.conftest import commit_all

PAGE = (Path(__file__).parents[2] / "workflows" / "OWN_LAWS.md").read_text(encoding="utf-8")
LAWS = (
    re.findall(r"```python\n(.*?)```", PAGE, flags=re.DOTALL)[0]
    + """
class Short(RunningIn):
    def over(self, begin):
        return tribo.Wear(1e-15)

class Broken(RunningIn):
    def over(self, begin, end):
        return 1e-15

def _median(rises, share, quantiles):
    return np.apply_along_axis(lambda row: np.interp(0.5, quantiles, row), -1, rises)

median = tribo.Rule("rise_quantile", _median, "median of the contact", "its median above")
beyond = tribo.Rule("rise_quantile", lambda r, *_: 2 * r[..., -1], "twice", "twice above")
whole = tribo.Rule("rise_quantile", lambda r, *_: r, "all", "all above")
"""
)
RATES = {"initial_rate": 6e-15, "final_rate": 1e-15, "distance": 1.5}
OWN = f"""extends = "small.toml"
without = ["wear"]
[wear]
law = "laws:RunningIn"
parameters = {{ {", ".join(f"{name} = {value}" for name, value in RATES.items())} }}
[sweep]
loads = ["400 N"]
"""


@pytest.fixture
def folder(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    (tmp_path / "small.toml").write_text(SCENE.replace("increments = 10", "increments = 4"))
    (tmp_path / "laws.py").write_text(LAWS)
    (tmp_path / "own.toml").write_text(OWN)
    return tmp_path


@dataclass
class Shaped:
    rate: float = 6e-15
    shape: tuple = (1, 2)
    pattern = "swept"

    def over(self, begin, end):
        return self.rate


def test_parameters_of_a_law_are_numbers_and_words_and_else_as_python_writes_them():
    assert refer(Shaped()).parameters == (("rate", 6e-15), ("shape", "(1, 2)"))


def test_a_named_law_runs_on_workers_that_have_no_file_and_fails_its_points_by_name(folder, irg):
    assert "wear: laws:RunningIn, distance = 1.5" in irg("check", "own.toml", "--own-laws")
    irg("run", "own.toml", "--own-laws", "-q", "--workers", "1", "-o", "own.zarr")
    ds = pipeline.open_sweep("own.zarr")
    stored = stored_sweep(ds).scene.wear
    assert (stored.reference, dict(stored.parameters)) == ("laws:RunningIn", RATES)
    scene = pipeline.load_scene("own.toml", own_laws=True)
    end = pipeline.end_of_point(ds).sel(load=400, velocity=2)
    *_, state = tribo.simulate(scene.scene, 400.0, 2.0)
    assert end["wear_volume"].item() == tribo.measures(scene.scene, state)["wear_volume"]
    broken = ["run", "own.toml", "--own-laws", "-q", "--workers", "1", "-o", "broken.zarr"]
    said = irg(*broken, "--set", "wear.law=laws:Broken", code=1)
    assert "400 N, 2 m/s: InvariantError: wear law: its wear over" in said
    (folder / "laws.py").write_text(LAWS + "# changed\n")
    assert "scene.wear.digest" in irg(
        "run", "own.toml", "--own-laws", "-q", "-o", "own.zarr", code=3
    )


def test_a_criterion_of_one_s_own_judges_a_store(folder):
    commit_all("small.zarr", pipeline.load_scene("small.toml"))
    crossings = pipeline.boundary(pipeline.at("small.zarr", criterion="laws:median", own_laws=True))
    half = pipeline.boundary(pipeline.at("small.zarr", share=0.5))
    np.testing.assert_allclose(crossings["critical_velocity"], half["critical_velocity"], rtol=1e-6)
    digest = hashlib.sha256((folder / "laws.py").read_bytes()).hexdigest()
    assert crossings.attrs["criterion_hash"] == digest
    with pytest.raises(tribo.InvariantError, match="laws:beyond: a rise lies beyond"):
        pipeline.boundary(pipeline.at("small.zarr", criterion="laws:beyond", own_laws=True))
    with pytest.raises(tribo.InvariantError, match="laws:whole: its rises have the shape"):
        pipeline.boundary(pipeline.at("small.zarr", criterion="laws:whole", own_laws=True))


def test_a_store_keeps_the_name_and_the_hash_of_a_criterion_and_asks_for_the_word(folder, irg):
    judged = {"temperature.criterion": "laws:median"}
    scene = pipeline.load_scene("small.toml", overrides=judged, own_laws=True)
    commit_all("small.zarr", scene)
    ds = pipeline.open_sweep("small.zarr")
    stored = stored_sweep(ds).conditions
    assert stored.criterion == "laws:median"
    assert stored.criterion_hash == scene.conditions.criterion_hash
    assert isinstance(stored.own_criterion, Reference)
    assert "np.interp" not in str(ds.attrs)
    with pytest.raises(tribo.InputError, match=scene.conditions.criterion_hash):
        pipeline.boundary("small.zarr")
    assert pipeline.warned("small.zarr").at_boundary is None or not pipeline.warned("small.zarr")
    pipeline.boundary(pipeline.at("small.zarr", criterion="laws:median", own_laws=True))
    pipeline.boundary(pipeline.at("small.zarr", criterion="mean"))
    assert "criterion" not in pipeline.temperatures("small.zarr").attrs
    word = ["--criterion", "laws:median", "--own-laws"]
    assert "is not the text" not in irg("boundary", "small.zarr", *word)
    with folder.joinpath("laws.py").open("a") as file:
        file.write("# edited\n")
    assert "is not the text that the store was judged by" in irg("boundary", "small.zarr", *word)


def test_a_scene_that_was_read_judges_by_the_law_of_then(folder):
    rises = {"rise_quantile": np.linspace(0.0, 100.0, len(tribo.QUANTILES))}
    judged = {"temperature.criterion": "laws:median"}
    first = pipeline.load_scene("small.toml", overrides=judged, own_laws=True).conditions
    before = first.decisive.rise(rises)
    changed = LAWS.replace("np.interp(0.5,", "np.interp(0.9,")
    (folder / "laws.py").write_text(changed)
    second = pipeline.load_scene("small.toml", overrides=judged, own_laws=True).conditions
    assert first.decisive.rise(rises) == before < second.decisive.rise(rises)
    assert pickle.loads(pickle.dumps(first)).decisive.rise(rises) == before
    assert first != second
    assert "laws:median" not in tribo.CRITERIA


def test_a_surface_of_one_s_own_is_part_of_the_scene(folder):
    text = 'extends = "small.toml"\nwithout = ["disk.roughness"]\n'
    text += (
        'disk.surface = { law = "laws:Dimples", parameters = { height = 2e-7, spacing = 1e-4 } }\n'
    )
    (folder / "waves.toml").write_text(text)
    scene = pipeline.load_scene("waves.toml", own_laws=True).scene
    heights = scene.heights()
    assert heights.max() == pytest.approx(2e-7)
    copy = pickle.loads(pickle.dumps(scene))
    assert copy.roughness == scene.roughness
    np.testing.assert_array_equal(copy.heights(), heights)


def test_the_scene_of_the_page_runs(folder, irg):
    scene = re.findall(r"```toml\n(.*?)```", PAGE, flags=re.DOTALL)[0]
    folder.joinpath("running_in.toml").write_text(scene.replace("workflows/first_try", "small"))
    commands = re.findall(r"^irg .*$", PAGE, flags=re.MULTILINE)
    assert len(commands) == 4
    few = ["--set", 'sweep.loads=["400 N"]', "--set", 'sweep.velocities=["1 m/s", "3 m/s"]']
    said = [
        irg(*shlex.split(command)[1:], *([] if " boundary " in command else few), "-q")
        for command in commands
    ]
    assert any("criterion: laws:hottest" in line for line in said)


@pytest.mark.parametrize(
    ("setting", "words"),
    [
        ("wear.law=none:X", "there is no file none.py in"),
        ("wear.law=laws:Missing", "the module has no Missing; give"),
        ("wear.law=laws", 'give "module:name"'),
        ("wear.law=faulty:X", "faulty.py, line 2: ZeroDivisionError"),
        ("wear.parameters.distance=x", "TypeError: unsupported operand"),
        ("temperature.criterion=laws:Dimples", "is not a tribo.Rule"),
        (
            "wear.law=laws:mean_of_hottest",
            "has no method over(begin, end); see tribo.WearLaw",
        ),
        ("wear.law=laws:Short", "has no method over(begin, end)"),
        ("disk.surface={law='laws:Dimples'}", "leave out one of them"),
    ],
)
def test_each_mistake_is_named(folder, irg, setting, words):
    (folder / "faulty.py").write_text("x = 1\n1 / 0\n")
    before = set(sys.modules)
    error = irg("check", "own.toml", "--own-laws", "--set", setting, code=2)
    assert words in error
    assert "Traceback" not in error
    assert not {"laws", "faulty"} & (set(sys.modules) - before)
