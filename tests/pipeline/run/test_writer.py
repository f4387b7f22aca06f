"""The thread that commits results (pipeline/run/writer.py)."""

import time

from pipeline.run.writer import Writer


class SlowStore:
    """A store of which each commit takes a minute, by a clock of its own."""

    now, place = 0.0, None

    def commit(self, records):
        self.now += 60.0


def test_slow_commits_follow_each_other_within_ten_seconds(monkeypatch):
    """A kill costs no more work than that, and progress is told as often."""
    store = SlowStore()
    monkeypatch.setattr(time, "monotonic", lambda: store.now)
    assert Writer(store)._commit([]) <= 10.0
