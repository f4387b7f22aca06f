"""Tests, and the campaigns that are programs."""

import os

# Set before NumPy is loaded: results of a campaign are compared bit for bit with those of workers,
# which have one thread each. Linear algebra in several threads adds in another order.
os.environ |= {"OMP_NUM_THREADS": "1", "OPENBLAS_NUM_THREADS": "1"}
