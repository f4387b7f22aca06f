"""The machine, as far as a process may use it: its affinity and a container's limits count."""


def cores() -> int:
    """Number of cores."""
    from dask.system import CPU_COUNT  # here, since it is slow to import

    return int(CPU_COUNT)


def memory() -> int:
    """Memory [B]."""
    from distributed.system import MEMORY_LIMIT

    return int(MEMORY_LIMIT)
