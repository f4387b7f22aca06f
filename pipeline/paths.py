"""Paths as users write them."""

from os import PathLike
from pathlib import Path


def user_path(path: str | PathLike[str]) -> Path:
    """The path, with a home folder in place of ``~`` or ``~name`` at its beginning.

    Examples
    --------
    >>> user_path("~/sweep.zarr") == Path.home() / "sweep.zarr"
    True
    """
    try:
        return Path(path).expanduser()
    except RuntimeError:  # nobody has this name, so that it is a file's
        return Path(path)
