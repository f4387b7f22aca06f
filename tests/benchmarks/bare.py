"""The transforms that convolutions contain, and nothing else: what the rest is measured in."""

import time

import numpy as np

from tribo.convolution import padded_shape


def bare_transforms(grid, count):
    """Return what does the transforms of `count` convolutions on `grid`, into kept buffers."""
    nx, (mx, my) = grid.shape[0], padded_shape(grid)
    modes = np.zeros((mx, my // 2 + 1), dtype=complex)
    field = np.ones((nx, my))

    def run():
        for _ in range(count):
            np.fft.rfft(field, axis=1, out=modes[:nx])
            np.fft.fft(modes, axis=0, out=modes)
            np.fft.ifft(modes, axis=0, out=modes)
            np.fft.irfft(modes[:nx], n=my, axis=1, out=field)

    return run


def shortest(run, rounds=3):
    """Processor time of the fastest of some runs [s]."""
    times = []
    for _ in range(rounds):
        began = time.process_time()
        run()
        times.append(time.process_time() - began)
    return min(times)
