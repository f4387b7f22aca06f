"""Input for which no reader may hang, run out of memory, or raise an unexpected error."""

import csv
import os
import re

import numpy as np
import pandas as pd
import pytest

import tribo
from pipeline import load_scene
from pipeline.condition_kinds import OperatingPoints
from pipeline.frames import write_frames
from pipeline.paths import read_file
from pipeline.surface.scan import read_scan


@pytest.mark.parametrize(
    ("name", "read"),
    [
        ("a.npy", lambda file: read_scan(file, 1.0)),
        ("a.csv", OperatingPoints.read),
        ("a.toml", load_scene),
    ],
)
def test_a_pipe_is_no_surface_load_record_or_scene(tmp_path, name, read):
    os.mkfifo(tmp_path / name)
    with pytest.raises(tribo.TriboError, match="not a file"):
        read(tmp_path / name)


def a_pipe(file):
    os.mkfifo(file)


def no_end(file):
    file.symlink_to("/dev/zero")


def huge(file):
    file.touch()
    os.truncate(file, 10**12)


@pytest.mark.parametrize(
    ("lay", "name"), [(a_pipe, "status"), (no_end, "rise_quantile"), (huge, "rise_quantile")]
)
def test_a_chunk_that_is_no_file_of_its_size_is_named_at_once(lay, name, copy, irg):
    (chunk,) = sorted((copy / name).glob("c.*"))[:1]
    chunk.unlink()
    lay(chunk)
    reason = "it has 1e+06 MB; at most 0." if lay is huge else "it is not a file"
    assert f"{chunk} cannot be read: {reason}" in irg("verify", copy, code=2)
    assert re.search(f"{name}.* cannot be read", irg("boundary", copy, code=2))


def test_a_file_of_the_largest_size_is_read_and_one_with_a_byte_more_is_not(tmp_path):
    (tmp_path / "a").write_bytes(b"12345")
    assert read_file(tmp_path / "a", 5) == b"12345"
    with pytest.raises(OSError, match=r"it has 5e-06 MB; at most 4e-06 MB are read"):
        read_file(tmp_path / "a", 4)


def test_what_a_spreadsheet_would_compute_is_written_as_text(tmp_path):
    texts = ["=1+1", "+x", "-y", "@z", "\tt", "-0.5", "mild"]
    frame = pd.DataFrame({"=head": texts, "number": np.arange(-3.0, 4)})
    cells = list(csv.reader(write_frames([frame], tmp_path / "a.csv").read_text().splitlines()))
    first, second = zip(*cells, strict=True)
    assert first == ("'=head", "'=1+1", "'+x", "'-y", "'@z", "'\tt", "-0.5", "mild")
    assert second == ("number", "-3", "-2", "-1", "0", "1", "2", "3")
