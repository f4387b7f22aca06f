import pytest

from tests.helpers.samples import fewer_draws


@pytest.fixture(autouse=True)
def _fewer_draws(monkeypatch):
    fewer_draws(monkeypatch)
