"""Parts of a run that need no worker: words, nodes of a search, changes of a boundary."""

import math
import os
import signal
import sys
from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest
from distributed import Status

import pipeline
from pipeline.run import cluster, forkserver, vary
from pipeline.run.boundary_search import BoundarySearch
from pipeline.run.cluster import client_of
from pipeline.run.vary import Variation, Variations, _absolute
from pipeline.run.work import ExecutionError, hash_of_code
from pipeline.sweep.stages import Progress
from tests.helpers import synthetic
from tests.helpers.entries import changed
from tests.helpers.scenes import SCENE
from tribo import Corrections, Friction, InputError

# Words


@pytest.mark.parametrize(
    ("progress", "words"),
    [
        (
            Progress("", 3, 9, 1, 12.3, 61.0),
            "3 of 9 points done, 1 failed, 12 s so far, 1 min to go",
        ),
        (Progress("", 0, 9, 0, 0.2, None), "0 of 9 points done, 0 failed, 0 s so far"),
        (Progress("", 9, 9, 0, 99.0, 0.0), "9 of 9 points done, 0 failed, 2 min so far"),
        (Progress(done=3, total=9), "3 of 9 done"),  # of no sweep
        (Progress(done=3, total=9, elapsed=12.3, time_to_go=61.0),
         "3 of 9 done, 12 s so far, 1 min to go"),
        (Progress("a note", 3, 9, 1, 12.3, 61.0), "a note"),
    ],
)  # fmt: skip
def test_progress_says_what_is_done_and_the_time_to_go(progress, words):
    assert str(progress) == words


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


def test_workers_that_nobody_starts_again_are_replaced():
    states = {"a": Status.running, "b": Status.closed, "c": Status.failed}
    nannies = {name: SimpleNamespace(status=status) for name, status in states.items()}
    scaled = []
    local = SimpleNamespace(workers=nannies, worker_spec=dict(states), scale=scaled.append)
    cluster._replace_lost(local)
    assert ([*nannies], scaled) == (["a"], [3])
    cluster._replace_lost(local)
    assert scaled == [3]


@pytest.mark.parametrize("content", ["", "{}", "[1]", '{"id": 1}'])
def test_a_file_that_no_scheduler_wrote_is_refused(tmp_path, content):
    file = tmp_path / "scheduler.json"
    file.write_text(content)
    with pytest.raises(ExecutionError, match="cannot be read as the file of a Dask scheduler"):
        client_of(file=file)


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


# The search


def search(**values):
    usual = {"loads": (200.0, 400.0, 750.0), "lowest": 0.5, "highest": 8.0, "limit": 1200.0}
    return BoundarySearch(**usual | {"tolerance": 0.01} | values)


@pytest.mark.parametrize("tolerance", [0.0, 1.0, -0.1, math.nan])
def test_a_tolerance_is_a_share(tolerance):
    with pytest.raises(InputError, match="it must be between 0 and 1"):
        search(tolerance=tolerance)


def test_a_search_begins_at_the_middle_of_its_range_and_follows_the_load():
    """Loads of both ends and the middle; the boundary falls about as the load to −0.8."""
    asked = search().wanted({})
    by_load = {point.load: point.velocity for point in asked}
    assert sorted(by_load) == [200.0, 400.0, 750.0]
    assert [point.velocity for point in asked] == sorted(by_load.values())
    assert by_load[400.0] == pytest.approx(2.0, rel=0.2)  # √(0.5 · 8)
    assert by_load[200.0] / by_load[400.0] == pytest.approx(2**0.8, rel=0.25)
    assert by_load[750.0] / by_load[400.0] == pytest.approx((750 / 400) ** -0.8, rel=0.25)
    alone = search(loads=(300.0,)).wanted({})
    assert [point.load for point in alone] == [300.0]
    scaled = search(loads=(300.0,), scale=2.0).wanted({})
    assert scaled[0].velocity == pytest.approx(alone[0].velocity, rel=0.2)


def test_velocities_are_in_round_figures_and_those_next_to_an_end_are_the_end():
    one = search()
    count = one._intervals()
    assert math.log(8.0 / 0.5) / count <= 0.35 < math.log(8.0 / 0.5) / (count - 1)
    for number in range(1, count):
        node = one._node(number, 0)
        assert node == float(f"{node:.6g}")
        assert node == pytest.approx(0.5 * 16 ** (number / count), rel=1e-5)
    assert [one._node(number, 0) for number in (-3, 0, count, count + 2)] == [0.5, 0.5, 8.0, 8.0]
    assert one._node(1, 1) == pytest.approx(0.5 * 16 ** (0.5 / count), rel=1e-5)
    coarse = search(lowest=1.0, highest=1.1)
    assert coarse._intervals() == 2
    loose = search(tolerance=1e-4)
    assert math.log(16) / loose._intervals() <= math.sqrt(8e-4 / 0.5)


@pytest.mark.parametrize(
    ("row", "bracket"),
    [
        ([(1.0, 900.0), (2.0, 1500.0)], (1.0, 2.0)),
        ([(1.0, 900.0), (2.0, 1200.0)], (1.0, 2.0)),  # at the limit wear is severe
        ([(1.0, 900.0), (2.0, 1100.0)], (2.0, None)),
        ([(1.0, 1300.0), (2.0, 1500.0)], (None, 1.0)),
        ([(1.0, 900.0), (2.0, 1500.0), (3.0, 1000.0), (4.0, 1600.0)], (1.0, 2.0)),
    ],
)
def test_a_bracket_is_next_to_the_first_crossing(row, bracket):
    assert search()._bracket(row) == bracket


def test_the_crossing_is_guessed_by_the_straight_line_in_logarithms():
    one = search()

    def guess(*row):
        return math.exp(one._guess([*row]))

    assert guess((2.0, 1200.0)) == pytest.approx(2.0)
    assert guess((2.0, 600.0)) == pytest.approx(2.0 * 2 ** (1 / 0.6))  # the usual exponent
    assert guess((1.0, 600.0), (4.0, 2400.0)) == pytest.approx(2.0)
    assert guess((1.0, 300.0), (2.0, 600.0)) == pytest.approx(4.0)  # goes on
    assert guess((2.0, 2400.0), (4.0, 4800.0)) == pytest.approx(1.0)
    # Of more points, by those about the first crossing, or by the last or the first two.
    assert guess((1.0, 900.0), (2.0, 1000.0), (4.0, 2000.0), (8.0, 9000.0)) == pytest.approx(
        2.0 * 2 ** math.log2(1.2)
    )
    assert guess((1.0, 100.0), (2.0, 300.0), (4.0, 600.0)) == pytest.approx(8.0)
    assert guess((2.0, 2400.0), (4.0, 4800.0), (8.0, 5000.0)) == pytest.approx(1.0)
    # No flatter than an exponent of 0.2, and no steeper than 3.
    assert guess((1.0, 1000.0), (2.0, 1000.0)) == pytest.approx(2.0 * 1.2**5)
    assert guess((1.0, 1.0), (2.0, 600.0)) == pytest.approx(2.0 * 2 ** (1 / 3))


def test_a_bend_of_the_rise_narrows_what_a_straight_line_may_span():
    one = search()
    assert one._curvature({200.0: []}) == 0.5
    power = [(v, 1000.0 * v**0.6) for v in (1.0, 1.3, 1.6)]
    assert one._curvature({200.0: power}) == 0.2  # it may be less by chance
    x = np.log([1.0, 1.3, 1.6])
    bent = [*zip((1.0, 1.3, 1.6), (1000 * np.exp(0.6 * x + 0.3 * x**2)).tolist(), strict=True)]
    slope = 0.6 + 0.3 * (x[2] + x[0])
    assert one._curvature({200.0: bent}) == pytest.approx(1.5 * 0.6 / slope, rel=1e-6)
    falling = [(1.0, 1500.0), (1.3, 900.0), (1.6, 1300.0)]
    assert one._curvature({200.0: falling}) in (0.5, 100.0)
    wide = [(v, 1000.0 * v**0.6) for v in (1.0, 2.0, 4.0)]
    assert one._curvature({200.0: wide}) == 0.5  # too far apart to tell


def test_a_search_is_between_the_velocities_above_0_and_closer_where_friction_bends():
    sweep = synthetic.scene(velocities=(0.0, 0.5, 2.0, 5.0), loads=(200.0, 400.0))
    plain = BoundarySearch.of(sweep, 0.02, 2.0)
    assert (plain.lowest, plain.highest, plain.limit) == (0.5, 5.0, pytest.approx(1200.0))
    assert (plain.tolerance, plain.scale, plain.factor) == (0.02, 2.0, None)
    bent = Corrections(friction=Friction(by_velocity=((0.5, 1.2), (5.0, 0.8))))
    curved = changed(sweep, conditions=replace(sweep.conditions, corrections=bent))
    assert BoundarySearch.of(curved, 0.02).tolerance == pytest.approx(0.002)
    assert BoundarySearch.of(curved, 0.02).factor is not None
    for values, words in (
        ({"velocities": (0.0, 1.0)}, "sweep.velocities are 0, 1 m/s; give two or more above 0"),
        ({"conditions": replace(sweep.conditions, friction=0.0)}, "without friction; give fricti"),
    ):
        with pytest.raises(InputError, match=words):
            BoundarySearch.of(changed(sweep, **values), 0.02)


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


@pytest.mark.parametrize(
    ("key", "value", "absolute"),
    [
        ("friction.coefficient", "+20%", 0.12),
        ("friction.coefficient", "-5.5 %", 0.0945),
        ("pin.radius", "+20%", "2.4 mm"),
        ("disk.roughness.ra", "-50%", "0.135 um"),
        ("pin.radius", "20%", "20%"),
        ("pin.radius", "3 mm", "3 mm"),
        ("friction.coefficient", 0.2, 0.2),
        ("fidelity.increments", "+20%", 60),  # a whole number stays one
        ("fidelity.increments", "+1%", 50.5),  # if it can, which is refused later
        ("friction.coefficient", "+900%", 1.0),
    ],
)
def test_percents_are_of_the_scene_s_own_value(tmp_path, key, value, absolute):
    (tmp_path / "scene.toml").write_text(SCENE)
    given = {"fidelity.increments": 50}
    sweep = pipeline.load_scene(tmp_path / "scene.toml", overrides=given)
    (found,) = _absolute(sweep, key, [value])
    assert (found, type(found)) == (absolute, type(absolute))
    several = [*_absolute(sweep, key, ["7", value, 8])]
    assert several == ["7", absolute, 8]


@pytest.mark.parametrize(
    ("key", "words"),
    [
        ("temperature.bulk", "the scene gives 25 degC, and a percentage of a temperature depends"),
        ("disk.material", "the scene gives no number there; give a value"),
        ("sweep.fields", "the scene gives no number there"),
        ("pin.material", "the scene gives no number there"),
    ],
)
def test_what_has_no_percents_is_told(tmp_path, key, words):
    (tmp_path / "scene.toml").write_text(SCENE)
    with pytest.raises(InputError, match=words):
        [*_absolute(pipeline.load_scene(tmp_path / "scene.toml"), key, ["+20%"])]


def test_a_variation_of_an_effect_is_labelled_by_it(tmp_path):
    (tmp_path / "scene.toml").write_text(SCENE)
    sweep = pipeline.load_scene(tmp_path / "scene.toml")
    thin = sweep.changed("pin.radius", "1 mm").changed("sweep.loads", ["1 N"])
    made = vary._combine(sweep, [("", ""), ("pin.radius", "1 mm")], [sweep, thin])
    assert made.plane == sweep.plane
    assert [dict(name)["variation"] for name in made.variants.names] == [
        "the unchanged scene",
        "pin.radius = 1 mm",
    ]
    plain, other = made.rows
    assert (plain.values, other.values) == ({}, {"pin.radius": "1 mm"})
