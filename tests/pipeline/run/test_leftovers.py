"""What is removed of processes that were killed (pipeline/run/leftovers.py)."""

import socket
import tempfile

import pytest

from pipeline.run.leftovers import remove_dead_folders


@pytest.fixture
def places(tmp_path, monkeypatch):
    monkeypatch.setattr(tempfile, "tempdir", str(tmp_path))
    return [tmp_path / f"pymp-{name}" for name in ("dead", "alive", "other", "empty")]


def test_only_folders_with_nothing_but_dead_sockets_go(places):
    dead, alive, other, _ = places
    for folder in places:
        folder.mkdir()
    sockets = {folder: socket.socket(socket.AF_UNIX) for folder in (dead, alive, other)}
    for folder, each in sockets.items():
        each.bind(str(folder / "listener-1"))
    (other / "arena").write_text("of another program")
    sockets[alive].listen()
    sockets[dead].close()
    sockets[other].close()
    remove_dead_folders()
    assert [folder.exists() for folder in places] == [False, True, True, True]
    sockets[alive].settimeout(0.1)
    with pytest.raises(TimeoutError):  # nor has it heard of this
        sockets[alive].accept()
    sockets[alive].close()


def test_a_file_in_place_of_a_socket_stays(places):
    places[0].mkdir()
    (places[0] / "listener-1").write_text("no socket")
    remove_dead_folders()
    assert (places[0] / "listener-1").exists()
