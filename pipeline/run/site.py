"""Options of a site: the jobs of its batch system, as a file gives them."""

from __future__ import annotations

import re
import tomllib
from collections.abc import Mapping
from dataclasses import dataclass, fields
from pathlib import Path
from typing import Any

from tribo import InputError

SAMPLE = """\
# Options of a site, for: irg run SCENE.toml --cluster slurm --jobs 50 --site FILE.toml
# Each is optional. --dry-run prints the job script that follows from them.

# queue = "standard"            # partition of Slurm; default: the site's own
# account = "wear"              # account that the jobs are charged to
# cores = 8                     # cores of a job, each with one worker; default: 1
# memory = "16 GB"              # memory of a job, all its cores together; default: 1 GB a core
# directives = ["--constraint=avx2", "--qos=long"]    # further lines of #SBATCH
# prologue = ["module load python/3.11"]    # lines of the shell before the workers start
# python = "/sw/irg/bin/python" # Python of the nodes with this package; default: the one here
# interface = "ib0"             # network between this machine and the nodes; default: its main one
# port = 8786                   # port of this machine that the nodes reach; default: any free one
# folder = "/scratch/me/irg"    # logs and certificates, seen by the nodes; default: OUT.zarr.jobs
# scratch = "/local"            # folder of a node for short-lived files; default: its own for them
"""
"""A file of all options, each in a comment."""

_WORDS = {str: "text in quotes", int: "a whole number above 0", list: "a list of texts"}
_KINDS = {"cores": int, "port": int, "directives": list, "prologue": list}  # others are texts
SAFE = re.compile(r"[\w@+=:,./-]+")
"""Words that a job script takes as they are."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Site:
    """Options of the jobs of a site.

    Attributes
    ----------
    queue, account : str, optional
        Queue of the jobs, and account that they are charged to.
    cores : int
        Cores of a job, each with one worker.
    memory : str, optional
        Memory of a job, such as "16 GB"; 1 GB a core if not given.
    directives, prologue : list of str
        Further lines for the batch system, and for the shell before the workers start.
    python : str, optional
        Python of the nodes with this package; the one that runs here if not given.
    interface, port : optional
        Network between this machine and the nodes, and port on which they reach it.
    folder : str, optional
        Folder of the logs and certificates, which the nodes see; beside the store if not given.
    scratch : str, optional
        Folder of a node for short-lived files.

    Raises
    ------
    InputError
        If an option is of another kind.

    Examples
    --------
    >>> Site(cores=4, memory="8 GB").cores
    4
    >>> Site(cores="4")
    Traceback (most recent call last):
    tribo.errors.InputError: cores is '4'; give a whole number above 0
    """

    queue: str | None = None
    account: str | None = None
    cores: int = 1
    memory: str | None = None
    directives: list[str] | tuple[()] = ()
    prologue: list[str] | tuple[()] = ()
    python: str | None = None
    interface: str | None = None
    port: int | None = None
    folder: str | None = None
    scratch: str | None = None

    def __post_init__(self) -> None:
        for field in fields(self):
            kind, value = _KINDS.get(field.name, str), getattr(self, field.name)
            if value is field.default:
                continue
            if not _fits(value, kind):
                raise InputError(f"{field.name} is {value!r}; give {_WORDS[kind]}")
            if kind is str and field.name != "memory" and not SAFE.fullmatch(value):
                raise InputError(
                    f"{field.name} is {value!r}; a job script takes letters, digits and "
                    "@+=:,./_- alone"
                )


def _fits(value: object, kind: type) -> bool:
    if kind is list:
        return isinstance(value, list) and all(isinstance(line, str) for line in value)
    if kind is int:
        return isinstance(value, int) and not isinstance(value, bool) and value > 0
    return isinstance(value, str) and value != ""


def site_of(file: Path) -> Site:
    """Read the options of a site.

    Raises
    ------
    InputError
        If the file cannot be read, or has other entries.
    """
    try:
        entries: Mapping[str, Any] = tomllib.loads(file.read_text(encoding="utf-8"))
    except (OSError, UnicodeError, tomllib.TOMLDecodeError) as error:
        raise InputError(f"{file} cannot be read as TOML: {error}") from None
    allowed = [field.name for field in fields(Site)]
    if unknown := [name for name in entries if name not in allowed]:
        raise InputError(f"{file} has {', '.join(unknown)}; it may have {', '.join(allowed)}")
    try:
        return Site(**entries)
    except InputError as error:
        raise InputError(f"{file}: {error}") from None
