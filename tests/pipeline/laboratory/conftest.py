"""Scenes like those in tests/pipeline/scene."""

from tests.pipeline.scene.conftest import faults as faults
from tests.pipeline.scene.conftest import read as read
