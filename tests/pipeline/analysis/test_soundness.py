"""A result is not read from a damaged point in silence."""

import pytest
import zarr

import pipeline
from pipeline.cli import main
from tests.helpers import tiny
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
    assert "rise_quantile cannot be read; irg verify names what is da" in capsys.readouterr().err


def test_a_sound_chunk_in_the_place_of_another_is_found_by_verify_and_run_alone(copy):
    """Answers trust the checksum of each chunk, and cannot see that a chunk was replaced."""
    before = pipeline.margin(copy, "300 N", "1 m/s").deciding_temperature
    array = zarr.open_array(copy / "rise_quantile", mode="r+")
    array[...] = 0.97 * array[...]
    assert pipeline.margin(copy, "300 N", "1 m/s").deciding_temperature < before
    assert len(pipeline.verify_store(copy).damaged) == 9
    assert pipeline.run_sweep(tiny.full(), copy, workers=1).computed == 9
    assert pipeline.margin(copy, "300 N", "1 m/s").deciding_temperature == before


def test_commands_that_read_write_nothing_into_a_store(copy, irg, tmp_path):
    before = contents(copy)
    for command in ("status", "boundary", "verify"):
        irg(command, copy)
    irg("margin", copy, "--load", "300 N", "--velocity", "1.1 m/s")
    irg("plot", copy, "-o", tmp_path / "a.png")
    assert contents(copy) == before
