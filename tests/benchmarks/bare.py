"""The transforms that a computation contains, and nothing else: what its time is measured in."""

import contextlib
import time
from collections import Counter

import numpy as np

_KINDS = ("rfft", "fft", "ifft", "irfft", "rfft2", "fft2", "ifft2", "irfft2")
_REPEATS = 30


@contextlib.contextmanager
def counted_transforms():
    """Count NumPy's transforms done meanwhile, by kind, array and arguments."""
    counts = Counter()
    originals = {kind: getattr(np.fft, kind) for kind in _KINDS}

    def counting(kind, transform):
        def wrapper(array, *args, out=None, **kwargs):
            array = np.asarray(array)
            in_place = out is not None and np.shares_memory(array, out)
            options = tuple(sorted(kwargs.items()))
            counts[kind, array.shape, array.dtype, args, options, in_place] += 1
            return transform(array, *args, **kwargs, **({} if out is None else {"out": out}))

        return wrapper

    for kind, transform in originals.items():
        setattr(np.fft, kind, counting(kind, transform))
    try:
        yield counts
    finally:
        for kind, transform in originals.items():
            setattr(np.fft, kind, transform)


def bare_time(counts):
    """Processor time of the counted transforms alone, into kept buffers [s]."""
    return sum(count * _time_of(*transform) for transform, count in counts.items())


def _time_of(kind, shape, dtype, args, options, in_place):
    transform, array = getattr(np.fft, kind), np.ones(shape, dtype)
    out = array if in_place else transform(array, *args, **dict(options))
    return shortest(lambda: transform(array, *args, **dict(options), out=out), _REPEATS)


def shortest(run, rounds=3):
    """Processor time of the fastest of some runs [s]."""
    times = []
    for _ in range(rounds):
        began = time.process_time()
        run()
        times.append(time.process_time() - began)
    return min(times)
