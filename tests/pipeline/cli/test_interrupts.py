"""Signals that end a command as Ctrl-C does, in a process of its own."""

import re
import signal
import subprocess
import sys

import pytest

from pipeline import summary, verify_store
from pipeline.interrupts import keyboard_interrupts
from tests.helpers.scenes import SCENE

MANY = 'velocities = { from = "1 m/s", to = "4 m/s", count = 400 }'


@pytest.fixture
def running(tmp_path):
    """Process of ``irg run`` with very many points, some of which are done."""
    scene, out = tmp_path / "many.toml", tmp_path / "many.zarr"
    scene.write_text(re.sub("^velocities = .*$", MANY, SCENE, flags=re.MULTILINE))
    command = [sys.executable, "-m", "pipeline", "run", scene, "-o", out, "--workers", "1"]
    command += ["--preset", "standard"]
    process = subprocess.Popen(
        command, stderr=subprocess.PIPE, text=True, start_new_session=True,
        # Ctrl-C acts as in a terminal, even if this suite was started by nohup, which ignores it.
        preexec_fn=lambda: signal.signal(signal.SIGHUP, signal.SIG_DFL),
    )  # fmt: skip
    said = []
    while not any(" points done" in line for line in said):
        said.append(process.stderr.readline())
        assert said[-1], said
    yield process, out
    process.kill()
    process.communicate()


@pytest.mark.parametrize("number", [signal.SIGINT, signal.SIGTERM, signal.SIGHUP])
def test_each_signal_ends_a_command_once_and_acts_as_before_afterwards(number):
    before = signal.signal(number, signal.SIG_DFL)
    try:
        with pytest.raises(KeyboardInterrupt), keyboard_interrupts():
            signal.raise_signal(number)
        assert signal.getsignal(number) == signal.SIG_DFL
    finally:
        signal.signal(number, before)


def test_a_run_that_is_told_to_end_keeps_its_points_and_says_so(running):
    process, out = running
    process.send_signal(signal.SIGTERM)
    said = process.stderr.read()
    assert process.wait() == 130
    assert "irg: interrupted; finished points are saved: run the same command again" in said
    assert "Traceback" not in said
    assert verify_store(out).is_clean
    assert summary(out).running is None
