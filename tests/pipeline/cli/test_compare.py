"""Stores beside each other: their differences, and those of a folder."""

import json

import numpy as np

import pipeline
import tribo
from pipeline.cli import main
from tests.helpers import synthetic
from tests.helpers.scenes import SCENE, STEEL


def test_a_difference_names_the_entry_the_move_of_the_boundary_and_the_points(monkeypatch):
    def hotter(*place):
        return 1.1 * synthetic.rise(*place)

    a, thicker = synthetic.sweep(), tribo.Cylinder(3e-3, 3.4e-3, STEEL)
    b = synthetic.sweep(rise=hotter, loads=synthetic.LOADS[1:], pin=thicker)
    monkeypatch.setattr(pipeline, "open_sweep", lambda path: {"a": a, "b": b}[str(path)])
    difference = pipeline.diff(a, b)
    assert ["pin.radius", "2 mm", "3 mm"] in difference.entries.to_numpy().tolist()
    moved = difference.boundary
    assert moved["load [N]"].to_list() == synthetic.LOADS[1:].tolist()
    expected = 1.1 ** (-1 / synthetic.VELOCITY_EXPONENT) - 1
    np.testing.assert_allclose(moved["change [%]"], 100 * expected, rtol=1e-3)
    changes = difference.points["change [%]"]
    assert changes.isna().sum() == len(synthetic.VELOCITIES)  # at the load that B lacks
    np.testing.assert_allclose(changes.dropna(), 10.0)
    assert pipeline.diff(a, a).points.empty


def test_the_status_of_a_folder_tells_scenes_stores_and_damage_apart(tmp_path, capsys):
    (tmp_path / "deep").mkdir()
    (tmp_path / "deep/small.toml").write_text(SCENE)
    (tmp_path / "pyproject.toml").write_text("[project]\n")
    (tmp_path / "lost.zarr").mkdir()
    (tmp_path / "lost.zarr/zarr.json").write_text("{}")
    assert main(["status", str(tmp_path), "--json"]) == 0
    document = json.loads(capsys.readouterr().out)
    kinds = dict(zip(document["name"], document["kind"], strict=True))
    assert kinds == {"deep/small.toml": "scene", "lost.zarr": "store"}
    states = dict(zip(document["name"], document["state"], strict=True))
    assert states["lost.zarr"].startswith("unreadable: ")


def test_the_status_of_a_folder_runs_no_code_that_a_scene_names(tmp_path, capsys):
    (tmp_path / "laws.py").write_text("raise SystemExit('run')\n")
    (tmp_path / "own.toml").write_text('extends = "first_try"\nwear = { law = "laws:Own" }\n')
    assert main(["status", str(tmp_path)]) == 0
    assert "extends first_try" in capsys.readouterr().out
