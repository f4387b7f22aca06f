"""Systems without POSIX, as Windows: reading works, writing says what it needs."""

from tests.helpers.processes import python
from tests.helpers.scenes import SCENE

WITHOUT_POSIX = """
import multiprocessing, os, signal, sys
import asyncio, locket, psutil  # which have a part of their own for each system
sys.modules["fcntl"] = None
del os.getuid, os.sysconf, os.O_NONBLOCK, signal.pthread_sigmask
os.O_BINARY = 0
multiprocessing.get_all_start_methods = lambda: ["spawn"]
from pipeline.cli import main
for command in eval(sys.argv[1]):
    print("ended with", main(command))
"""


def test_what_only_reads_works_and_a_run_says_what_it_needs(alone, tmp_path):
    scene = str(tmp_path / "small.toml")
    (tmp_path / "small.toml").write_text(SCENE)
    place = ["--load", "200 N", "--velocity", "1 m/s", "--preset", "draft"]
    commands = [
        ["point", scene, *place],
        ["boundary", str(alone)],
        ["run", scene, "--preset", "draft", "-o", str(tmp_path / "out.zarr")],
    ]
    done = python("-c", WITHOUT_POSIX, repr(commands), variables={"OMP_NUM_THREADS": "1"})
    ends = [line[-1] for line in done.stdout.splitlines() if line.startswith("ended with")]
    assert ends == ["0", "0", "2"], done.stderr
    said = [line for line in done.stderr.splitlines() if "so far" not in line]
    (refused,) = said  # but for progress on a busy machine
    assert "no file locks, which irg run needs; run it on Linux or macOS" in refused
