"""Differences of two stores, and of all stores of a folder."""

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


def test_the_status_of_a_folder_names_its_stores_and_their_damage(tmp_path, capsys):
    (tmp_path / "small.toml").write_text(SCENE)
    (tmp_path / "deep/lost.zarr").mkdir(parents=True)
    (tmp_path / "deep/lost.zarr/zarr.json").write_text("{}")
    assert main(["status", str(tmp_path), "--json"]) == 0
    (record,) = json.loads(capsys.readouterr().out)
    assert record["name"] == "deep/lost.zarr"
    assert record["state"].startswith("unreadable: ")


def test_both_stores_are_judged_at_what_at_gives(monkeypatch, irg):
    held = synthetic.sweep((200.0, 400.0), synthetic.VELOCITIES[:11])
    monkeypatch.setattr(pipeline, "open_sweep", lambda path: held)
    assert "their scenes are equal" in irg("diff", "a", "b", "--at", "friction.coefficient=0.2")


def test_a_difference_says_which_store_carries_a_warning(monkeypatch, irg):
    sound = synthetic.sweep((200.0, 400.0), synthetic.VELOCITIES[:11])
    flags = sound["warning_flags"].copy(data=0 * sound["warning_flags"].values)
    flags[0, 0] = tribo.WarningKind.FEW_STEPS
    stores = {"a": sound, "b": sound.assign(warning_flags=flags)}
    monkeypatch.setattr(pipeline, "open_sweep", lambda path: stores[str(path)])
    said = irg("diff", "a", "b")
    assert "B: warning: 1 point carries a warning (few steps: 1)" in said
    assert "A: warning" not in said
