"""A result is not read from a damaged point in silence."""

import pytest

from pipeline.cli import main
from tests.helpers.stores import contents


@pytest.mark.parametrize("command", ["boundary", "plot", "margin"])
@pytest.mark.parametrize("harm", ["flipped", "missing"])
def test_every_command_that_reads_rises_names_the_damage(copy, tmp_path, capsys, command, harm):
    chunk = copy / "rise_quantile" / "c.0.0.0.0"
    content = bytearray(chunk.read_bytes())
    content[len(content) // 2] ^= 1
    chunk.write_bytes(content)
    if harm == "missing":
        chunk.unlink()
    place = ["--load", "300 N", "--velocity", "1.1 m/s"] if command == "margin" else []
    out = []
    out = ["-o", str(tmp_path / "a.png")] if command == "plot" else out
    assert main([command, str(copy), *place, *out]) == 2
    missing = "is missing at 150 N, 0.5 m/s and at 8 more"
    words = {"flipped": "cannot be read", "missing": missing}[harm]
    assert f"rise_quantile {words}; irg verify names what is damaged" in capsys.readouterr().err


def test_commands_that_read_write_nothing_into_a_store(copy, irg, tmp_path):
    before = contents(copy)
    for command in ("status", "boundary", "verify"):
        irg(command, copy)
    irg("margin", copy, "--load", "300 N", "--velocity", "1.1 m/s")
    irg("plot", copy, "-o", tmp_path / "a.png")
    assert contents(copy) == before
