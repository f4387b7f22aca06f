import pytest
from matplotlib.figure import Figure

from pipeline.report.report import _drawn


@pytest.fixture
def undrawn(monkeypatch):
    """Leave the diagram of a report empty: to draw it takes most of the time of a report."""
    empty = Figure()
    empty.add_subplot()
    monkeypatch.setitem(_drawn.__globals__, "diagram", lambda ds: empty)
