"""Sensitivity of the tests: they are run on code with one small change at a time."""
