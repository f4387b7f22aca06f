"""Power cuts of a disk while a sweep on it is created, written to and made longer.

The disk is a file, mounted through a loop device. At a random moment its file system is shut down
without a last flush: nothing more reaches the disk, and what waits in memory is lost, as when the
power fails. Mounted again, it replays its journal. What a drive loses after it has said that all is
written is not tried here. Needs root and loop devices.
"""

import fcntl
import os
import shutil
import struct
import subprocess
from contextlib import contextmanager
from pathlib import Path

from tests.crash.loop import code_of, end

TRIALS = 28
MISTAKE = "unsynced"
CUTS = 4  # power cuts in a trial
_SHUT_DOWN = (2 << 30) | (4 << 16) | (ord("X") << 8) | 125  # ioctl _IOR('X', 125, __u32)
_WITHOUT_FLUSH = struct.pack("I", 2)
_MEMORY = Path("/dev/shm")  # the file that counts as the disk is in memory
# By default ext4 writes data before their names, and syncs a file renamed over another one.
_KINDS = {
    "ext4": ["mkfs.ext4", "-q", "-F"],
    "ext4 -o noauto_da_alloc": ["mkfs.ext4", "-q", "-F"],
    "ext4 -o noauto_da_alloc,data=writeback": ["mkfs.ext4", "-q", "-F"],
    "xfs": ["mkfs.xfs", "-q", "-f"],
}
_SIZE = {"mkfs.ext4": 64, "mkfs.xfs": 320}  # [MB]


def kinds():
    """Kinds of file systems that this process can create and mount."""
    if os.geteuid() != 0 or not Path("/dev/loop-control").exists():
        return []
    return [kind for kind, command in _KINDS.items() if shutil.which(command[0])]


class Disk:
    """A file system in an image file, mounted at a folder."""

    def __init__(self, folder, kind):
        self.folder, self._image = folder / "disk", folder / "image"
        _, _, self._options = kind.partition(" -o ")
        self.folder.mkdir(parents=True)
        self._image.touch()
        os.truncate(self._image, _SIZE[_KINDS[kind][0]] * 2**20)
        _called(*_KINDS[kind], self._image)

    def mount(self):
        options = ",".join(filter(None, ("loop", self._options)))
        _called("mount", "-o", options, self._image, self.folder)

    def unmount(self):
        _called("umount", self.folder)

    def cut_power(self):
        descriptor = os.open(self.folder, os.O_RDONLY)
        try:
            fcntl.ioctl(descriptor, _SHUT_DOWN, _WITHOUT_FLUSH)
        finally:
            os.close(descriptor)


def _called(*command):
    subprocess.run(command, check=True, timeout=60)


@contextmanager
def _mounted(disk):
    disk.mount()
    try:
        yield disk
    finally:
        disk.unmount()


def campaign(run):
    """Cut the power of `run.count` disks, several times each."""
    if not (on := kinds()):
        run.report.counts["skipped: needs root, loop devices and mkfs.ext4"] = 1
        return
    if _MEMORY.is_dir():
        run.folder = _MEMORY / f"irg-{os.getpid()}"
    try:
        for number, trial in enumerate(run.trials()):
            kind = on[number % len(on)]
            disk = Disk(trial.folder, kind)
            trial.path = disk.folder / "results" / "out.zarr"

            def cut(driver, disk=disk, kind=kind, trial=trial):
                trial.wait(driver)
                late = driver.returncode is not None
                run.report.counts["cuts, too late" if late else f"cuts of {kind}"] += 1
                disk.cut_power()
                code_of(driver)
                end(driver)
                disk.unmount()
                disk.mount()

            with _mounted(disk):
                trial.go([cut] * CUTS)
            shutil.rmtree(trial.folder)
    finally:
        if run.folder.parent == _MEMORY:
            shutil.rmtree(run.folder, ignore_errors=True)
