"""Kinds of disks: those of this machine alone, and those that other machines see, too."""

from __future__ import annotations

import re
from pathlib import Path

_LOCAL = {"tmpfs", "ramfs", "overlay", "zfs", "bcachefs"}
"""File systems without a device of blocks of which no other machine writes the files."""


def is_local(folder: Path) -> bool:
    """True for a folder on a disk of this machine, where a `flock` reaches all who write to it.

    Elsewhere, as on NFS, FUSE or the folders of a virtual machine's host, locks may reach one
    machine alone, or nobody. Systems without ``/proc`` are taken for local.

    Examples
    --------
    >>> is_local(Path("/"))
    True
    """
    try:
        mounts, kinds = (
            Path("/proc/self/mounts").read_bytes(),
            Path("/proc/filesystems").read_text(),
        )
    except OSError:
        return True
    kind = filesystem_of(folder, mounts.decode(errors="surrogateescape"))
    return kind in _LOCAL | _of_blocks(kinds)


def filesystem_of(folder: Path, mounts: str) -> str:
    r"""Name of the file system of an absolute path, by the kernel's table of mounts.

    Examples
    --------
    >>> mounts = "/dev/sda / ext4 rw 0 0\nhost:/home /home/my\\040group nfs4 rw 0 0\n"
    >>> [filesystem_of(Path(name), mounts) for name in ("/home/my group/sweep.zarr", "/home/mine")]
    ['nfs4', 'ext4']
    """
    found, length = "", -1
    for line in mounts.splitlines():
        _, point, kind, *_ = line.split(" ")
        point = re.sub(r"\\([0-7]{3})", lambda code: chr(int(code[1], 8)), point)
        above = Path(point)
        if len(above.parts) >= length and folder.is_relative_to(above):  # the last one lies on top
            found, length = kind, len(above.parts)
    return found


def _of_blocks(kinds: str) -> set[str]:
    """File systems on devices of blocks, by the kernel's table."""
    rows = (line.partition("\t") for line in kinds.splitlines())
    return {kind for nodev, _, kind in rows if not nodev}
