"""A folder of an object store, as much of one as a store of a sweep needs.

Each object is replaced at one stroke and is safe once that returns, so there is nothing to sync
and nothing partial is left behind.
"""

from __future__ import annotations

import functools
from collections.abc import Iterator
from contextlib import contextmanager, nullcontext, suppress
from dataclasses import dataclass
from typing import Any

SCHEME = "s3://"

_OPTIONS = {"use_listings_cache": False, "skip_instance_cache": True}


@contextmanager
def as_os_error() -> Iterator[None]:
    """Raise an `OSError` for whatever goes wrong on the way to the object store."""
    try:
        yield
    except OSError:
        raise
    except Exception as error:
        raise OSError(str(error)) from error


@dataclass(frozen=True, slots=True)
class Remote:
    """An address of an object or of a folder of objects, used like a `Path`."""

    url: str

    def __str__(self) -> str:
        return self.url

    def __truediv__(self, name: str) -> Remote:
        return Remote(f"{self.url}/{name}")

    @property
    def key(self) -> str:
        """Bucket and key."""
        return self.url.removeprefix(SCHEME)

    @property
    def name(self) -> str:
        """Last part of the address."""
        return self.url.rsplit("/", 1)[-1]

    @property
    def suffix(self) -> str:
        """Ending of the name."""
        return f".{self.name.rsplit('.', 1)[-1]}" if "." in self.name else ""

    def with_name(self, name: str) -> Remote:
        """The address of this name beside this one."""
        return Remote(f"{self.url.rsplit('/', 1)[0]}/{name}")

    def exists(self) -> bool:
        """Whether there is an object, or objects below."""
        with as_os_error():
            return bool(_objects().exists(self.key))

    def is_dir(self) -> bool:
        """Whether there are objects below."""
        with as_os_error():
            return bool(_objects().isdir(self.key))

    def iterdir(self) -> list[Remote]:
        """Addresses one level below."""
        with as_os_error():
            found = _objects().ls(self.key, detail=False, refresh=True)
        return [Remote(f"{SCHEME}{key}") for key in found]

    def read_bytes(self) -> bytes:
        """Content of the object."""
        with as_os_error():
            content: bytes = _objects().cat_file(self.key)
        return content

    def write_bytes(self, content: bytes, *, exclusive: bool = False) -> None:
        """Replace the object; or create it, if nobody else has.

        Raises
        ------
        FileExistsError
            If somebody has.
        """
        mode = "create" if exclusive else "overwrite"
        with as_os_error():
            _objects().pipe_file(self.key, content, mode=mode)

    def unlink(self, missing_ok: bool = False) -> None:
        """Remove the object."""
        with as_os_error(), suppress(FileNotFoundError) if missing_ok else nullcontext():
            _objects().rm_file(self.key)


@functools.cache
def _objects() -> Any:
    return _file_system()


def asynchronous() -> Any:
    """The file system for one event loop alone."""
    return _file_system(asynchronous=True)


def _file_system(**options: Any) -> Any:
    import fsspec  # which stores in folders do without

    return fsspec.filesystem("s3", **_OPTIONS, **options)
