import pytest

from pipeline.uncertain import design
from tests.helpers.samples import fewer_draws


@pytest.fixture(autouse=True)
def _fewer_draws(monkeypatch):
    fewer_draws(monkeypatch)
    monkeypatch.setattr(design, "_DRAWS", 2**11)
