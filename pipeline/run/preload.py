"""Imports of every worker, made by the process from which workers are forked."""

import gc

gc.disable()  # modules are never freed, and searching them for garbage takes 0.1 s
import distributed  # noqa: E402, F401
import scipy.fft  # noqa: E402
import scipy.linalg  # noqa: E402
import scipy.special  # noqa: E402, F401

import pipeline.run.work  # noqa: E402, F401

gc.freeze()
gc.enable()
