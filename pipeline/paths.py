"""Paths as users write them, the text of a file there, and why it cannot be read.

A file that is written is replaced as a whole and synced to the disk.
"""

from __future__ import annotations

import errno
import os
import stat
from collections.abc import Sequence
from contextlib import suppress
from difflib import get_close_matches
from os import PathLike
from pathlib import Path

from tribo import InputError

TABLES = (".csv", ".md", ".json")
FIGURES = (".pdf", ".png", ".svg")
"""Suffixes of the files that a table, or a figure, may be written to."""


def user_path(path: str | PathLike[str]) -> Path:
    """Expand ``~`` or ``~name`` at the beginning of a path to a home folder.

    Examples
    --------
    >>> user_path("~/sweep.zarr") == Path.home() / "sweep.zarr"
    True
    """
    require_path(path)
    try:
        return Path(path).expanduser()
    except RuntimeError:  # no user has the name after "~", so it is part of a file name
        return Path(path)


def require_path(path: object) -> None:
    """Raise an `InputError` for what is no path, such as a number."""
    if not isinstance(path, str | PathLike):
        raise InputError(f"a path is of type {type(path).__name__}; give text or a Path")


def writable_path(out: str | Path, suffixes: Sequence[str]) -> Path:
    """Check the path of a file to write, and return it.

    Raises an `InputError` unless it ends in one of `suffixes`, and its folder can be written.
    """
    path = user_path(out)
    if path.suffix.lower() not in suffixes:
        allowed = suffixes[0] if len(suffixes) == 1 else f"one of {', '.join(suffixes)}"
        raise InputError(f"cannot write {out}: the file name must end in {allowed}")
    try:
        if not path.parent.is_dir():
            raise InputError(f"cannot write {out}: the folder {path.parent} does not exist")
        targets = (path.parent, path) if path.exists() else (path.parent,)
        if path.is_dir() or not all(os.access(target, os.W_OK) for target in targets):
            problem = "it is a folder, or it or its folder is not writable"
            raise InputError(f"cannot write {out}: {problem}")
    except OSError as error:  # such as a name that is too long
        raise InputError(f"cannot write {out}: {error.strerror}") from error
    return path


def store_path_of(path: str | PathLike[str]) -> str | PathLike[str]:
    """Path of a store to read; the name of a scene without a path becomes ``results/NAME.zarr``.

    An existing path of this name has precedence.
    """
    require_path(path)
    store_path = Path(path)
    is_name = str(path) == store_path.name and not store_path.suffix
    in_results = Path("results") / f"{store_path.name}.zarr"
    with suppress(OSError):  # such as a name that is too long, which opening reports better
        if is_name and not store_path.exists() and in_results.exists():
            return in_results
    return path


def open_regular(path: str | PathLike[str], flags: int) -> int:
    """Open a file without blocking, and return its descriptor.

    Raises an `OSError` unless it is a regular file, not a FIFO, a device or a folder.
    """
    descriptor = os.open(path, flags | os.O_NONBLOCK | os.O_CLOEXEC, 0o666)
    mode = os.fstat(descriptor).st_mode
    if not stat.S_ISREG(mode):
        os.close(descriptor)
        code = errno.EISDIR if stat.S_ISDIR(mode) else errno.EINVAL
        raise OSError(code, "it is not a file", os.fspath(path))
    return descriptor


def read_file(path: str | PathLike[str], max_bytes: int | None = None) -> bytes:
    """Content of a regular file; `OSError` for anything else, or a longer file than `max_bytes`."""
    with open(path, "rb", opener=open_regular) as stream:
        size = os.fstat(stream.fileno()).st_size
        if max_bytes is not None and size > max_bytes:
            reason = f"it has {size / 1e6:.4g} MB; at most {max_bytes / 1e6:.4g} MB are read"
            raise OSError(errno.EFBIG, reason, os.fspath(path))
        return stream.read()


def reason_of(error: OSError, path: Path) -> str:
    """Reason why a file cannot be read; if it is missing, also a similar path that exists."""
    reason = error.strerror or str(error)
    return f"{reason}{path_hint(path)}" if isinstance(error, FileNotFoundError) else reason


def path_hint(path: Path) -> str:
    """Words for an error message that suggest an existing path of similar name; empty if none."""
    missing = next((part for part in (path, *path.parents) if part.parent.is_dir()), path)
    with suppress(OSError):
        names = sorted(entry.name for entry in missing.parent.iterdir())
        longer = [name for name in names if name.startswith(f"{missing.name}.")]
        for name in longer or get_close_matches(missing.name, names, 1, 0.8):
            suggestion = missing.with_name(name) / path.relative_to(missing)
            return f' (did you mean "{suggestion}"?)' if suggestion.exists() else ""
    return ""


def store_hint(path: Path) -> str:
    """Words that suggest a store in results whose scene has a name like that of a missing path."""
    names = [store.stem for store in Path("results").glob("*.zarr")]
    is_name = path.parent == Path.cwd() and not path.suffix
    for name in get_close_matches(path.name, names, 1, 0.8) if is_name else []:
        return f' (did you mean "{name}"?)'
    return ""


def is_workbook(path: Path, content: bytes) -> bool:
    """True for a workbook of a spreadsheet, by the end of its name or its content."""
    is_named_so = path.suffix.lower() in (".xlsx", ".xlsm", ".xlsb", ".xls", ".ods")
    return is_named_so or (content[:2] == b"PK" and b"xl/workbook" in content)


def workbook_problem(path: Path) -> str:
    """Why a workbook is not read, and what to do."""
    csv = path.with_suffix(".csv").name
    return f"a workbook; save its sheet as CSV (File, Save As, file type CSV UTF-8), and give {csv}"


def is_binary(content: bytes) -> bool:
    """True for the content of a file that is no text, in UTF-16 with its mark or any other.

    Examples
    --------
    >>> is_binary(b"load [N],velocity [m/s]"), is_binary(bytes(range(32)))
    (False, True)
    """
    return b"\0" in content[:4096] and content[:2] not in (b"\xff\xfe", b"\xfe\xff")


PARTIAL = ".irg-partial"
"""Ending of files being written."""
_NO_SYNC = (errno.EINVAL, errno.EBADF, errno.ENOTSUP)  # some file systems cannot sync a folder


def store_file(folder: Path, key: str, content: bytes) -> Path:
    """Create or replace the file `key` below a folder; return the folder to sync."""
    path = folder / key
    make_folder(path.parent)
    write_file(path, content)
    return path.parent


def write_file(path: Path, content: bytes) -> None:
    """Write a file under a temporary name, sync it to the disk, and rename it."""
    partial_file = path.with_name(path.name + PARTIAL)
    partial_file.unlink(missing_ok=True)  # left by a kill, or a link to another file
    try:
        with partial_file.open("xb") as stream:
            stream.write(content)
            stream.flush()
            os.fsync(stream.fileno())
        partial_file.replace(path)
    except BaseException:
        partial_file.unlink(missing_ok=True)
        raise


def make_folder(folder: Path) -> None:
    """Make a folder and the folders above it; return once they are on the disk."""
    if not folder.is_dir():
        make_folder(folder.parent)
        folder.mkdir(exist_ok=True)
        sync(folder.parent)


def sync(folder: Path) -> None:
    """Wait until the names of a folder's files are on the disk, if the file system allows it."""
    descriptor = os.open(folder, os.O_RDONLY)
    try:
        os.fsync(descriptor)
    except OSError as error:
        if error.errno not in _NO_SYNC:
            raise
    finally:
        os.close(descriptor)
