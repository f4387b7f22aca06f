"""When results are committed (`pipeline.store.store.Writer`)."""

import time
from types import SimpleNamespace

import pytest

from pipeline.store.store import Writer

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


def test_slow_commits_follow_each_other_within_ten_seconds(store):
    """A kill costs no more work than that, and progress is reported as often."""
    with Writer(store) as writer:
        writer.add([FIRST])
        writer.flush()
        writer.add([SECOND])
        store.now += 1.0
        assert (writer.written(), len(store.commits)) == ([], 1)
        store.now += 9.0
        writer.written()
    assert len(store.commits) == 2
