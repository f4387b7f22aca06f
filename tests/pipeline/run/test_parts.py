"""Parts of a run that need no worker: hashes, signals, changes of a boundary."""

import math
import os
import signal
import sys
from types import SimpleNamespace

import numpy as np
import pytest

from pipeline.run import forkserver
from pipeline.run.vary import Variation, Variations
from pipeline.run.work import hash_of_code

# Workers


def test_the_hash_of_code_is_that_of_names_and_contents_of_its_sources(tmp_path):
    one, other = tmp_path / "one" / "a", tmp_path / "other" / "a"
    for folder in (one, other):
        folder.mkdir(parents=True)
        (folder / "x.py").write_text("1\n")
        (folder / "notes.txt").write_text(str(folder))
    first = hash_of_code([one])
    assert first == hash_of_code([other])
    assert len(first) == 12
    (other / "x.py").write_text("2\n")
    assert hash_of_code([other]) != first
    (other / "x.py").rename(other / "y.py")
    (other / "y.py").write_text("1\n")
    assert hash_of_code([other]) != first


# The process that workers are forked from


def test_workers_are_forked_in_an_environment_of_their_own_and_that_of_the_user_stays(monkeypatch):
    theirs = {}
    monkeypatch.setattr(forkserver.forkserver, "ensure_running", lambda: theirs.update(os.environ))
    monkeypatch.setattr(sys, "path", ["", "/mine"])
    monkeypatch.setenv("OMP_NUM_THREADS", "7")
    before = dict(os.environ)
    forkserver.start()
    assert dict(os.environ) == before
    assert theirs["PYTHONPATH"] == ".:/mine"
    assert (theirs["OMP_NUM_THREADS"], theirs["PYTHONSAFEPATH"]) == ("1", "1")


def test_interrupts_are_put_off_until_the_end_and_handled_as_before(monkeypatch):
    came = []
    before = {number: signal.getsignal(number) for number in (signal.SIGTERM, signal.SIGHUP)}
    signal.signal(signal.SIGTERM, lambda number, _: came.append(number))
    signal.signal(signal.SIGHUP, signal.SIG_IGN)
    mine = signal.getsignal(signal.SIGTERM)
    try:
        with forkserver.interrupts_put_off():
            assert signal.SIGINT in signal.pthread_sigmask(signal.SIG_BLOCK, ())
            signal.raise_signal(signal.SIGTERM)
            signal.raise_signal(signal.SIGHUP)  # which nohup ignores
            assert came == []
        assert came == [signal.SIGTERM]
        assert signal.SIGINT not in signal.pthread_sigmask(signal.SIG_BLOCK, ())
        assert signal.getsignal(signal.SIGTERM) is mine
        assert signal.getsignal(signal.SIGHUP) is signal.SIG_IGN
    finally:
        for number, handler in before.items():
            signal.signal(number, handler)


@pytest.mark.parametrize(
    ("name", "parent", "ended"),
    [
        (None, None, []),
        ("__main__", None, []),  # the driver, under both names
        ("__mp_main__", None, [1]),
        ("__mp_main__", "a parent", []),  # a worker that runs
    ],
)
def test_a_worker_that_imports_an_unguarded_script_ends(monkeypatch, name, parent, ended):
    ends = []
    script = name and SimpleNamespace(__name__=name)
    monkeypatch.setitem(sys.modules, "__mp_main__", script)
    monkeypatch.setattr(forkserver.multiprocessing, "parent_process", lambda: parent)
    monkeypatch.setattr(forkserver.os, "_exit", ends.append)
    forkserver.end_if_imported()
    assert ends == ended


# Variations


def varied(*others, base=(2.0, 1.0)):
    crosses = ("crosses",) * 2
    changes = tuple(Variation(key, value, velocities, crosses) for key, value, velocities in others)
    return Variations("A scene", (200.0, 600.0), Variation("", "", base, crosses), changes, 12, 5)


def test_entries_are_ordered_by_how_far_they_move_the_boundary():
    nan = math.nan
    made = varied(
        ("a", "1", (2.2, 1.0)),
        ("b", "1", (nan, nan)),
        ("c", "1", (1.9, 1.0)),
        ("a", "2", (2.0, nan)),
        ("c", "2", (2.0, 0.7)),
        base=(2.0, 1.0),
    )
    assert {key: [one.value for one in group] for key, group in made.keyed_changes().items()} == {
        "c": ["1", "2"],
        "a": ["1", "2"],
        "b": ["1"],
    }
    assert [*made.keyed_changes()] == ["c", "a", "b"]
    np.testing.assert_allclose(made.changes(made.others[0]), [0.1, 0.0], atol=1e-12)
    assert np.isnan(made.changes(made.others[3])[1])
    assert (made.points, made.contacts) == (12, 5)
    assert made.changes(made.others[2]) == pytest.approx([-0.05, 0.0])
