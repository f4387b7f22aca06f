"""The progress of a run in a notebook, where nobody asked for another report of it."""

from __future__ import annotations

import sys
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from typing import Any

from pipeline.sweep.stages import duration


def in_notebook() -> bool:
    """Return whether this is a kernel of Jupyter."""
    return "ipykernel" in sys.modules


@contextmanager
def reported(
    progress: Callable[[Any], None] | None,
) -> Iterator[Callable[[Any], None] | None]:
    """Give the callable that was given; in a notebook without one, a bar below the cell."""
    if progress is not None or not in_notebook():
        yield progress
        return
    from tqdm import tqdm

    with tqdm(bar_format="{n_fmt} of {total_fmt} points done{postfix} |{bar:20}|") as bar:

        def show(progress: Any) -> None:
            bar.total, bar.n = progress.total, progress.done
            words = [f"{duration(progress.elapsed)} so far"]
            if progress.failed:
                words.append(f"{progress.failed} failed")
            if progress.time_to_go is not None:
                words.append(f"{duration(progress.time_to_go)} to go")
            bar.set_postfix_str(", ".join(words))

        yield show
