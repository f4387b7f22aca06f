"""Imports of every worker, made by the process from which workers are forked."""

import distributed  # noqa: F401
import scipy.fft
import scipy.linalg
import scipy.special  # noqa: F401

import pipeline.run.work  # noqa: F401
