"""End this process before the n-th change to the files of a folder, as a kill would.

Changes are what the interpreter reports to its audit hooks (a file opened for writing, renamed or
removed, a folder made or removed), each half of what is written to a file, and each fsync.
"""

import io
import os
import signal
import sys
import threading

_CHANGES = {"os.rename": 1, "os.mkdir": 0, "os.remove": 0, "os.rmdir": 0, "os.link": 1}
_WRITING = os.O_WRONLY | os.O_RDWR | os.O_CREAT | os.O_TRUNC | os.O_APPEND


class Countdown:
    """Counts the changes under a folder; kills the process before change number `last`."""

    def __init__(self, folder, last=None):
        self.changes = 0
        self._folder, self._last = os.fspath(folder), last
        self._lock = threading.Lock()
        self._open, self._fsync = io.open, os.fsync
        sys.addaudithook(self._heard)
        io.open, os.fsync = self._opened, self._synced

    def change(self):
        with self._lock:
            self.changes += 1
            if self.changes == self._last:
                os.kill(os.getpid(), signal.SIGKILL)

    def _concerns(self, path):
        return isinstance(path, str | os.PathLike) and os.fspath(path).startswith(self._folder)

    def _heard(self, event, arguments):
        if event == "open":
            path, _, flags = arguments
            if flags & _WRITING and self._concerns(path):
                self.change()
        elif event in _CHANGES and self._concerns(arguments[_CHANGES[event]]):
            self.change()

    def _opened(self, file, mode="r", *arguments, **options):
        opened = self._open(file, mode, *arguments, **options)
        writes = self._concerns(file) and set(mode) & set("wxa+")
        return _Torn(opened, self.change) if writes else opened

    def _synced(self, descriptor):
        self.change()
        self._fsync(descriptor)


class _Torn:
    """A file whose writes may stop half-way."""

    def __init__(self, file, change):
        self._file, self._change = file, change

    def __enter__(self):
        return self

    def __exit__(self, *_):
        self._file.close()

    def write(self, content):
        whole = content if isinstance(content, str) else memoryview(content).cast("B")
        for part in (whole[: len(whole) // 2], whole[len(whole) // 2 :]):
            self._change()
            self._file.write(part)
            self._file.flush()
        return len(whole)

    def __getattr__(self, name):
        return getattr(self._file, name)
