"""Paths as users write them, the text of a file there, and why it cannot be read."""

from contextlib import suppress
from difflib import get_close_matches
from os import PathLike
from pathlib import Path


def user_path(path: str | PathLike[str]) -> Path:
    """Expand ``~`` or ``~name`` at the beginning of a path to a home folder.

    Examples
    --------
    >>> user_path("~/sweep.zarr") == Path.home() / "sweep.zarr"
    True
    """
    try:
        return Path(path).expanduser()
    except RuntimeError:  # no user has the name after "~", so it is part of a file name
        return Path(path)


def found_store(path: str | PathLike[str]) -> str | PathLike[str]:
    """Path of a store that is to be read: ``results/NAME.zarr`` for the name of a scene alone.

    A path that exists comes first.
    """
    name, folder = Path(path), Path("results")
    is_name = str(path) == name.name and not name.suffix
    in_results = folder / f"{name.name}.zarr"
    with suppress(OSError):  # such as a name that is too long, which opening reports better
        if is_name and not name.exists() and in_results.exists():
            return in_results
    return path


def require_file(path: Path) -> None:
    """Raise `InputError` for a path that exists but is no file, such as a device or a FIFO."""
    with suppress(OSError):  # opening it reports the reason better
        if path.exists() and not path.is_file():
            from tribo.errors import InputError  # with NumPy, which --help does not need

            raise InputError(f"{path}: cannot be read: it is not a file")


def reason_of(error: OSError, path: Path) -> str:
    """Reason why a file cannot be read; if it is missing, also a similar path that exists."""
    reason = error.strerror or str(error)
    return f"{reason}{path_hint(path)}" if isinstance(error, FileNotFoundError) else reason


def path_hint(path: Path) -> str:
    """Words for an error message that suggest an existing path of similar name; empty if none."""
    wrong = next((part for part in (path, *path.parents) if part.parent.is_dir()), path)
    with suppress(OSError):
        names = sorted(entry.name for entry in wrong.parent.iterdir())
        longer = [name for name in names if name.startswith(f"{wrong.name}.")]
        for name in longer or get_close_matches(wrong.name, names, 1, 0.8):
            near = wrong.with_name(name) / path.relative_to(wrong)
            return f' (did you mean "{near}"?)' if near.exists() else ""
    return ""


def decoded(content: bytes) -> tuple[str, list[str]]:
    """Decode the content of a file as UTF-8 or UTF-16, else as Windows Latin-1 (cp1252).

    Null characters are removed. Returns the text and a list of notes for the user, which names
    Latin-1 or is empty.
    """
    is_wide = content[:2] in (b"\xff\xfe", b"\xfe\xff") or content[1:200:2].count(0) > 50
    with suppress(UnicodeDecodeError):
        return content.decode("utf-16" if is_wide else "utf-8-sig").replace("\0", ""), []
    return content.decode("cp1252", errors="replace").replace("\0", ""), ["Latin-1"]
