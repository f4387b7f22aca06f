"""A figure that is drawn again as points come, and ends with the run."""

from dataclasses import replace

import pytest

from pipeline.figures import plot as live
from pipeline.store.progress import Summary
from pipeline.store.schema import PENDING
from tests.helpers import synthetic
from tribo import InputError


def test_a_figure_of_a_point_waits_until_it_is_done(monkeypatch, tmp_path):
    begun = Summary("s", "A sweep", total=2, done=1, pending=1, failed=(), running="process 1")
    over = replace(begun, done=2, pending=0, running=None)
    states = iter([begun, over, over])
    monkeypatch.setattr(live, "summary", lambda store: next(states))
    status = iter([{(750.0, 4.0): PENDING}, {}])
    monkeypatch.setattr(live, "_INTERVAL", 0.0)
    axes = (400.0, 750.0), (2.0, 4.0)
    watched = {"read": lambda: synthetic.sweep(*axes, status=next(status)), "progress": [].append}
    watched |= {"load": 750.0, "velocity": 4.0}
    assert live.watch("out.zarr", tmp_path / "r.png", "ramp", **watched) == over
    assert (tmp_path / "r.png").exists()

    monkeypatch.setattr(live, "summary", lambda store: over)
    status = iter([{(750.0, 4.0): PENDING}])
    with pytest.raises(InputError, match="750 N, 4 m/s is not done"):
        live.watch("out.zarr", tmp_path / "s.png", "ramp", **watched)
