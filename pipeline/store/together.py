"""Coroutines from ordinary code, many at the same time."""

from __future__ import annotations

import asyncio
import functools
import threading
from collections.abc import Coroutine, Iterable
from typing import Any


def together(coroutines: Iterable[Coroutine[Any, Any, Any]]) -> list[Any]:
    """Results of coroutines that run at the same time, in a thread of their own.

    The first exception of one is raised; the others run on.

    Examples
    --------
    >>> together(asyncio.sleep(0.01 * number, number) for number in (3, 1, 2))
    [3, 1, 2]
    """

    async def gathered() -> list[Any]:
        return await asyncio.gather(*coroutines)

    return asyncio.run_coroutine_threadsafe(gathered(), _loop()).result()


@functools.cache
def _loop() -> asyncio.AbstractEventLoop:
    loop = asyncio.new_event_loop()
    threading.Thread(target=loop.run_forever, name="together", daemon=True).start()
    return loop
