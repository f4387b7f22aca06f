"""Tests, and the campaigns that are programs."""

import os

# Before NumPy is loaded, for what a campaign computes is compared bit for bit with what workers, of
# one thread each, have computed: linear algebra in several threads adds in another sequence.
os.environ |= {"OMP_NUM_THREADS": "1", "OPENBLAS_NUM_THREADS": "1"}
