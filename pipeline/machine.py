"""Cores and memory that this process may use, by its affinity and a container's limits."""

from __future__ import annotations

from contextlib import suppress
from pathlib import Path

# Files with the count of kills: of a container (control groups 2, then 1), of the machine.
_COUNTS = (
    "/sys/fs/cgroup/memory.events",
    "/sys/fs/cgroup/memory/memory.oom_control",
    "/proc/vmstat",
)


def cores() -> int:
    """Number of cores that this process may use."""
    from dask.system import CPU_COUNT  # here, since it is slow to import

    return int(CPU_COUNT)


def memory() -> int:
    """Memory that this process may use [B]."""
    from distributed.system import MEMORY_LIMIT

    return int(MEMORY_LIMIT)


def oom_kills() -> int:
    """Number of processes that the kernel has killed so far for lack of memory; 0 if unknown."""
    for file in _COUNTS:
        with suppress(OSError, KeyError, ValueError):
            lines = Path(file).read_text().splitlines()
            return int(dict(line.split() for line in lines)["oom_kill"])
    return 0
