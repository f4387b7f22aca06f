"""Damaged files of laboratories: each is read or refused in some lines, and none ends otherwise."""

import io
import random

import numpy as np
import pytest

from pipeline.cli import main
from tests.helpers.instruments import gwy, sur, x3p
from tests.pipeline.laboratory import samples
from tests.pipeline.laboratory.test_staged import RUNS

HEIGHTS = 1e-7 * np.random.default_rng(1).normal(size=(24, 20))
SIDES = (1e-6, 1e-6)


def array():
    file = io.BytesIO()
    np.save(file, HEIGHTS * 1e6)
    return file.getvalue()


def table(rows):
    return "\n".join(" ".join(f"{cell:.4f}" for cell in row) for row in rows).encode()


TRACE = "--given", "track_radius=20 mm", "--given", "velocity=1 m/s", "--scuffed-at", "90 s"
MAP = "--height-unit", "um", "--pixel-size", "1 um"
PLACES = np.column_stack([np.arange(80) * 0.5, HEIGHTS.ravel()[:80] * 1e6])
FILES = {
    "trace.csv": (samples.rtec().encode(), ("tests", *TRACE)),
    "log.csv": (RUNS.encode(), ("tests",)),
    "map.txt": (table(HEIGHTS * 1e6), ("surface", *MAP)),
    "profile.txt": (table(PLACES), ("surface", "--height-unit", "um", "--length-unit", "um")),
    "map.npy": (array(), ("surface", *MAP)),
    "map.x3p": (x3p(HEIGHTS, SIDES), ("surface",)),
    "map.gwy": (gwy([("Heights", HEIGHTS, "m")], SIDES), ("surface",)),
    "map.sur": (sur(HEIGHTS, SIDES), ("surface",)),
}
PIECES = b"\0", b'"', b";;;", b",,,,", b"\xff\xfe", b"nan", b"1e999", b"-inf", b"\r", b"1.200"


def mutated(content, draw):
    """The content with a part cut out, doubled or moved, other bytes, separators or encoding."""
    begin = draw.randrange(len(content))
    end = min(len(content), begin + draw.choice([1, 10, 300, 5000]))
    within, piece = content[begin:end], draw.choice(PIECES)
    return draw.choice([
        content[:begin], content[begin:], content[:begin] + content[end:],
        content[:end] + within + content[end:], content[:begin] + piece + content[begin:],
        content[:begin] + draw.randbytes(len(within)) + content[end:],
        content.replace(*draw.choice([(b",", b";"), (b".", b","), (b" ", b"\t"), (b"\n", b",")])),
        content.decode("latin-1").encode(draw.choice(["utf-16", "utf-32", "cp037"])),
    ])  # fmt: skip


@pytest.mark.parametrize("name", FILES)
def test_a_damaged_file_is_read_or_refused_in_some_lines(tmp_path, capsys, name):
    content, (command, *options) = FILES[name]
    draw, codes = random.Random(name), []
    for _ in range(16):
        (tmp_path / name).write_bytes(mutated(content, draw))
        codes.append(main([command, str(tmp_path / name), *options]))
        assert len(capsys.readouterr().err.splitlines()) <= 20
    assert {*codes} <= {0, 2}
    assert 2 in codes
