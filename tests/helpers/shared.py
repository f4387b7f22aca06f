"""What is dear to make, made once for all processes of the suite."""

import fcntl
import os


def root_of_all(tmp_path_factory):
    """The folder of temporary files that all processes of the suite share."""
    root = tmp_path_factory.getbasetemp()
    return root.parent if "PYTEST_XDIST_WORKER" in os.environ else root


def made_once(tmp_path_factory, name, fill):
    """A folder that the first process of the suite fills; the others wait, and read it alone."""
    root = root_of_all(tmp_path_factory)
    folder, partial = root / f"{name}-once", root / f"{name}-partial"
    with (root / f"{name}.lock").open("w") as lock:
        fcntl.flock(lock, fcntl.LOCK_EX)
        if not folder.exists():
            partial.mkdir(exist_ok=True)
            fill(partial)
            partial.rename(folder)
    return folder
