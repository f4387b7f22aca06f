"""Temporary folders of processes that were killed before they could remove them."""

from __future__ import annotations

import os
import socket
import tempfile
from contextlib import suppress
from pathlib import Path

_FOLDERS, _SOCKETS = "pymp-*", "listener-"  # as `multiprocessing` names those of a forkserver


def remove_dead_folders() -> None:
    """Remove this user's folders with nothing but sockets that no process has open any more."""
    for folder in Path(tempfile.gettempdir()).glob(_FOLDERS):
        with suppress(OSError):  # somebody else removes it, too
            found = list(folder.iterdir()) if folder.stat().st_uid == os.getuid() else []
            if found and all(each.name.startswith(_SOCKETS) and _is_dead(each) for each in found):
                for each in found:
                    each.unlink()
                folder.rmdir()


def _is_dead(file: Path) -> bool:
    """Whether a file is a socket that no process has open.

    To one that is open this is the wrong kind of connection, of which its process does not hear.
    """
    with socket.socket(socket.AF_UNIX, socket.SOCK_DGRAM) as other:
        try:
            other.connect(os.fspath(file))
        except ConnectionRefusedError:
            return file.is_socket()
        except OSError:
            return False
    return False
