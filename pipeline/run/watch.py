"""Patience with a sweep in which nothing moves."""

from __future__ import annotations

from dataclasses import dataclass, replace

WORD = 60.0  # [s] without a task that ends, after which the user is told; then after twice that
END = 300.0  # [s] without a worker that computes, after which the sweep is given up


@dataclass(frozen=True, slots=True)
class Watch:
    """Watches for how long nothing has moved.

    A point may take its time: as long as a worker computes one, there is no limit. But if tasks
    wait and no worker has been given one, something is wrong.

    Attributes
    ----------
    ended, computed : float
        Times at which a task last ended, and a worker was last seen with one [s].
    patience : float
        Time without an end after which there is a word to say [s].
    now : float
        Time of this observation [s].

    Examples
    --------
    >>> watch = Watch.begin(0.0).after(59.0, ended=False, computing=True)
    >>> watch.word
    >>> watch = watch.after(61.0, ended=False, computing=False)
    >>> watch.word
    'no point has been finished for 61 s'
    >>> watch.heard().after(360.0, ended=False, computing=False).is_over
    True
    """

    ended: float
    computed: float
    now: float
    patience: float

    @classmethod
    def begin(cls, now: float) -> Watch:
        """Begin to watch."""
        return cls(now, now, now, WORD)

    def after(self, now: float, ended: bool, computing: bool) -> Watch:
        """Take note whether a task has ended, or a worker still computes one."""
        if ended:
            return Watch.begin(now)
        return replace(self, now=now, computed=now if computing else self.computed)

    def heard(self) -> Watch:
        """The watch after its word was said, which is said again after twice the time."""
        return replace(self, patience=2 * self.patience)

    @property
    def words(self) -> str:
        """Time without an end, in words."""
        return f"no point has been finished for {self.now - self.ended:.0f} s"

    @property
    def word(self) -> str | None:
        """Words for the user, if it is time for them."""
        return None if self.now - self.ended < self.patience else self.words

    @property
    def is_over(self) -> bool:
        """True if no worker has had a task for so long that the run gives up."""
        return self.now - self.computed > END
