"""The transforms that a computation contains, and nothing else: what its time is measured in."""

import contextlib
import time
from collections import Counter

import numpy as np
import scipy.fft

_LIBRARIES = {"numpy": np.fft, "scipy": scipy.fft}
_KINDS = ("rfft", "fft", "ifft", "irfft", "rfft2", "fft2", "ifft2", "irfft2")
_REPEATS = 30


@contextlib.contextmanager
def counted_transforms():
    """Context: count transforms by library, kind, array and arguments."""
    counts = Counter()
    originals = {
        (library, kind): getattr(module, kind)
        for library, module in _LIBRARIES.items()
        for kind in _KINDS
    }

    def counting(name, transform):
        def wrapper(array, *args, out=None, **kwargs):
            array = np.asarray(array)
            in_place = out is not None and np.shares_memory(array, out)
            options = tuple(sorted(kwargs.items()))
            counts[*name, array.shape, array.dtype, args, options, in_place] += 1
            return transform(array, *args, **kwargs, **({} if out is None else {"out": out}))

        return wrapper

    for (library, kind), transform in originals.items():
        setattr(_LIBRARIES[library], kind, counting((library, kind), transform))
    try:
        yield counts
    finally:
        for (library, kind), transform in originals.items():
            setattr(_LIBRARIES[library], kind, transform)


def bare_time(counts):
    """Processor time [s] of only the counted transforms, with reused buffers where possible."""
    return sum(count * _time_of(*transform) for transform, count in counts.items())


def _time_of(library, kind, shape, dtype, args, options, in_place):
    transform, array = getattr(_LIBRARIES[library], kind), np.ones(shape, dtype)
    options = dict(options)
    if library == "numpy":
        options["out"] = array if in_place else transform(array, *args, **options)
    return shortest(lambda: transform(array, *args, **options), _REPEATS)


def shortest(run, rounds=3):
    """Shortest processor time [s] of `rounds` calls of `run`."""
    times = []
    for _ in range(rounds):
        began = time.process_time()
        run()
        times.append(time.process_time() - began)
    return min(times)
