"""When a sweep in which nothing moves says so, and when it is given up (pipeline/run/watch.py)."""

import pytest

from pipeline.run.watch import END, WORD, Watch

NOW = 1000.0  # [s] at which the watch begins


def seen(*events):
    """The watch after some seconds, with whether a task has ended or a worker computes."""
    watch = Watch.begin(NOW)
    for seconds, ended, computing in events:
        watch = watch.after(NOW + seconds, ended, computing)
    return watch


def test_the_word_comes_after_a_while_and_counts_from_the_last_end():
    assert seen((WORD - 1, False, True)).word is None
    assert seen((WORD, False, True)).word == f"no point has been finished for {WORD:.0f} s"
    assert seen((WORD - 1, True, True), (WORD + 1, False, True)).word is None
    late = seen((50.0, True, True), (50.0 + WORD + 7, False, False))
    assert late.word == f"no point has been finished for {WORD + 7:.0f} s"


def test_once_heard_it_comes_again_after_twice_the_time_until_a_task_ends():
    watch = seen((WORD, False, True)).heard()
    assert watch.word is None
    assert watch.after(NOW + 2 * WORD - 1, False, True).word is None
    again = watch.after(NOW + 2 * WORD, False, True)
    assert again.word
    assert again.heard().after(NOW + 4 * WORD - 1, False, True).word is None
    assert again.heard().after(NOW + 4 * WORD, False, True).word
    ended = again.heard().after(NOW + 4 * WORD, True, True)
    assert ended.word is None
    assert ended.after(NOW + 5 * WORD, False, True).word


@pytest.mark.parametrize(("seconds", "over"), [(0.0, False), (END, False), (END + 1, True)])
def test_it_is_over_when_no_worker_computes_for_long(seconds, over):
    assert seen((seconds, False, False)).is_over is over


def test_as_long_as_a_worker_computes_it_is_not_over():
    assert not seen((100 * END, False, True)).is_over
    assert not seen((100 * END, False, True), (101 * END, False, False)).is_over
    assert seen((100 * END, False, True), (101 * END + 1, False, False)).is_over
    assert not seen((END, True, False), (2 * END, False, False)).is_over
