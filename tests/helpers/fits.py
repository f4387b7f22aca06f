"""Constants of emulators, found once for all tests and processes: most tests ask a few designs.

A plugin of pytest, so that it reaches the examples of the packages, too.
"""

import os

import pytest

from pipeline import extras
from tests.helpers.shared import root_of_all


class Folder:
    """Keeper of fits that has a file in a folder for each, instead of a store."""

    def __init__(self, path):
        self._path = path

    def kept(self, name):
        file = self._path / name
        return file.read_bytes() if file.exists() else None

    def keep(self, name, content):
        partial = self._path / f"{name}.{os.getpid()}"
        partial.write_bytes(content)
        partial.replace(self._path / name)


@pytest.fixture(scope="session", autouse=True)
def _constants_are_found_once(tmp_path_factory):
    emulator = next(extras.modules("emulator"), None)
    if emulator is None:
        yield
        return
    (path := root_of_all(tmp_path_factory) / "fits").mkdir(exist_ok=True)
    found, folder = emulator.load_or_compute, Folder(path)

    def load_or_compute(keeper, *fit):
        return found(keeper if getattr(keeper, "may_keep", False) else folder, *fit)

    with pytest.MonkeyPatch.context() as patched:
        patched.setattr(emulator, "load_or_compute", load_or_compute)
        yield
