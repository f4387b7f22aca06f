"""Points in a store: data first and status last, also beside readers, and with little room."""

import time
from types import SimpleNamespace

import pytest

import tribo
from pipeline import StoreError, open_sweep, summary, verify_store
from pipeline.store.create import writing
from pipeline.store.schema import COLUMNS, FIELDS
from pipeline.store.status import FailedPoint
from pipeline.store.store import Writer
from pipeline.sweep.plan import points
from pipeline.sweep.sweep import Point
from tests.helpers import tiny
from tests.helpers.points import run_point
from tests.helpers.stores import assert_is_as_computed, commit, fail, killed_after, opened, record

SWEEP, POINT, OTHER = tiny.full(), Point(250.0, 1.0), Point(600.0, 1.5)


def test_what_is_read_is_what_was_computed_bit_for_bit_and_its_warnings(alone):
    assert_is_as_computed(alone, points(SWEEP))
    with open_sweep(alone) as ds:
        for point in points(SWEEP):
            result = run_point(SWEEP, point)
            stored = ds.sel(load=point.load, velocity=point.velocity)
            flags = stored["warning_flags"].item()
            assert set(tribo.WarningKind(flags)) == {warning.kind for warning in result.warnings}


@pytest.mark.parametrize("files", [8, 22])
def test_a_commit_killed_before_any_change_of_a_file_leaves_points_whole(path, monkeypatch, files):
    commit(path, SWEEP, [POINT])
    with writing(path, SWEEP) as store, killed_after(monkeypatch, files) as was_killed:
        store.commit([record(OTHER)])
    assert was_killed
    assert_is_as_computed(path, [POINT])
    assert verify_store(path).is_clean
    with open_sweep(path) as ds:
        ds.load()
    commit(path, SWEEP, [OTHER])
    assert_is_as_computed(path, [POINT, OTHER])


def test_a_failed_point_says_why_and_can_be_tried_again(path):
    fail(path, SWEEP, OTHER, "it did not converge – é")
    assert verify_store(path).is_clean  # though no point of the store is done
    assert summary(path).failed == (FailedPoint(600.0, 1.5, "it did not converge – é"),)
    with writing(path, SWEEP) as store:
        store.forget([OTHER])
        assert OTHER in store.pending()
    assert summary(path).failed == ()
    commit(path, SWEEP, [OTHER])
    assert_is_as_computed(path, [OTHER])


def test_any_message_is_stored_and_none_grows_the_store(path):
    messages = {150.0: "long " * 3_400_000, 250.0: "a\0b\n", 600.0: "not text: \udcff"}
    for load, message in messages.items():
        fail(path, SWEEP, Point(load, 1.0), message)
    assert verify_store(path).is_clean
    for failed in summary(path).failed:
        expected = messages[failed.load][:10].encode(errors="backslashreplace").decode()
        assert failed.message[:10] == expected[:10]
        assert len(failed.message) < 10_000
    assert len(summary(path).failed) == 3


# Readers


def test_a_point_that_is_not_done_is_not_a_number_whatever_is_on_the_disk(copy):
    with writing(copy, SWEEP) as store:
        store.forget([POINT])
    with open_sweep(copy) as ds:
        for name in (*COLUMNS, *FIELDS, "wall_time"):
            ends = ds[name].sel(load=250)
            assert ends.sel(velocity=1).isnull().all()
            assert ends.sel(velocity=0.5).notnull().any()


def test_opening_reads_no_field(copy):
    """Opening must not read fields, which may be larger than the memory."""
    for file in (copy / "fields").glob("*/c.*"):
        if file.parent.name in ("x", "y"):
            continue
        file.write_bytes(b"")
    with open_sweep(copy) as ds:
        assert ds["pressure"].shape == (3, 3, 32, 16)
        assert ds["mean_rise"].load().notnull().any()


def test_a_dataset_that_was_opened_before_a_larger_store_took_the_place_says_so(copy):
    """Its chunks would be those of other points."""
    with open_sweep(copy) as ds:
        commit(
            copy,
            tiny.full(velocities=tuple(sorted((0.75, *tiny.VELOCITIES)))),
            [Point(250.0, 0.75)],
        )
        with pytest.raises(StoreError, match="was enlarged since it was opened; open it again"):
            ds.load()
    with open_sweep(copy) as ds:
        assert ds["mean_rise"].notnull().any("step").sum() == 10


def test_a_lack_of_threads_is_no_damage(alone, monkeypatch):
    """Otherwise a repair would delete sound data."""

    def none_left(*_, **__):
        raise RuntimeError("can't start new thread")

    store = opened(alone)
    monkeypatch.setattr(type(store.arrays["mean_rise"]), "get_orthogonal_selection", none_left)
    with pytest.raises(RuntimeError, match="new thread"):
        store.read("mean_rise", ...)


# When results are committed (`pipeline.store.store.Writer`).

FIRST, SECOND, THIRD = (SimpleNamespace(name=name, data=None) for name in ("1", "2", "3"))


class Commits:
    """Fake store whose commits take a minute of a fake clock."""

    def __init__(self):
        self.now, self.place, self.commits, self.arrays = 0.0, None, [], {}

    def commit(self, records):
        self.now += 60.0
        self.commits.append(list(records))


@pytest.fixture
def store(monkeypatch):
    store = Commits()
    monkeypatch.setattr(time, "monotonic", lambda: store.now)
    return store


def test_records_that_come_in_a_pause_are_written_together(store):
    with Writer(store) as writer:
        writer.add([FIRST])
        assert writer.flush() == [FIRST]
        for record in (SECOND, THIRD):
            writer.add([record])
            assert writer.written() == []
    assert store.commits == [[FIRST], [SECOND, THIRD]]
