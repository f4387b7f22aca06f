"""What is dear to make, made once for all processes of the suite."""

import fcntl
import os


def root_of_all(tmp_path_factory):
    """Folder of temporary files that all processes of a test run share."""
    root = tmp_path_factory.getbasetemp()
    return root.parent if "PYTEST_XDIST_WORKER" in os.environ else root


def made_once(tmp_path_factory, name, fill):
    """Folder that the first process of a test run fills; other processes wait, and only read it."""
    root = root_of_all(tmp_path_factory)
    folder, partial = root / f"{name}-once", root / f"{name}-partial"
    with (root / f"{name}.lock").open("w") as lock:
        fcntl.flock(lock, fcntl.LOCK_EX)
        if not folder.exists():
            partial.mkdir(exist_ok=True)
            fill(partial)
            partial.rename(folder)
    return folder
