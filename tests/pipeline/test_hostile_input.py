"""Input on which no reader may hang, run out of memory or end with a traceback."""

import csv
import json
import os
import re
import subprocess
import sys
import zipfile

import numpy as np
import pandas as pd
import pytest

import tribo
from pipeline import load_scene, open_sweep
from pipeline.cli import main
from pipeline.frames import write_frames
from pipeline.operating_points import OperatingPoints
from pipeline.store.store import opened
from pipeline.surface.scan import read_scan
from tests.helpers import tiny
from tests.helpers.processes import python
from tests.helpers.stores import commit


@pytest.mark.parametrize(
    ("name", "read"),
    [
        ("a.npy", lambda file: read_scan(file, 1.0)),
        ("a.x3p", read_scan),
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
    said = "it has 1e+06 MB; at most 0." if lay is huge else "it is not a file"
    assert f"{chunk} cannot be read: {said}" in irg("verify", copy, code=2)
    assert re.search(f"{name}.* cannot be read", irg("boundary", copy, code=2))


def test_what_a_spreadsheet_would_compute_is_written_as_text(tmp_path):
    texts = ["=1+1", "+x", "-y", "@z", "\tt", "-0.5", "mild"]
    frame = pd.DataFrame({"=head": texts, "number": np.arange(-3.0, 4)})
    cells = list(csv.reader(write_frames([frame], tmp_path / "a.csv").read_text().splitlines()))
    first, second = zip(*cells, strict=True)
    assert first == ("'=head", "'=1+1", "'+x", "'-y", "'@z", "'\tt", "-0.5", "mild")
    assert second == ("number", "-3", "-2", "-1", "0", "1", "2", "3")


def test_a_command_without_a_standard_stream_ends_with_its_code(alone, tmp_path):
    run = 'exec "$0" -m pipeline boundary "$1" '
    for closed, code, store in (("<&- 2>&-", 0, alone), (">&- 2>&-", 2, tmp_path)):
        done = subprocess.run(["sh", "-c", run + closed, sys.executable, store], check=False)
        assert done.returncode == code, closed


def test_any_title_is_shown_and_drawn(tmp_path, capsys):
    path, title = tmp_path / "a.zarr", "$\\frac$ and $x \x1b[31mred\x9b0m" + "long " * 10**4
    commit(path, tiny.sweep(title=title, fields=False), ())
    assert main(["status", str(path)]) == 0
    output = capsys.readouterr().out
    assert output.replace("\n", "").isprintable()
    assert len(output) < 5000
    assert main(["plot", str(path), "--kind", "diagram", "-o", str(tmp_path / "a.png")]) in (0, 2)
    assert open_sweep(path).attrs["title"] == opened(path).sweep.title == title


_VALUES = {"pin.radius": "mm", "pin.length": "mm", "loading.rate": "N/s"}
_FIRST = 'extends = "first_try"\n'
SCENES = {
    "cases exceed the limit": "[sweep.over]\n"
    + "".join(
        f'"{key}" = {json.dumps([f"{5 + number / 100} {unit}" for number in range(149)])}\n'
        for key, unit in _VALUES.items()
    ),
    "at most 10000 are allowed": 'loading.reference_load = "1 N"\nfidelity.increments = 1000',
    "2.5e+07 points are too many": "[sweep]\n"
    + "".join(
        f'{name} = {{ from = "1 {unit}", to = "7 {unit}", count = 5000 }}\n'
        for name, unit in (("loads", "N"), ("velocities", "m/s"))
    ),
    "realizations: 100000": "sweep.realizations = 100000",
    "not valid TOML": f"a = {'[' * 100_000}",
}
_ASKED = """
import sys
from pathlib import Path
from pipeline.cli import main
from pipeline.operating_points import OperatingPoints
from tribo import InputError
codes = [main(["check", path]) for path in sys.argv[3:]]
for book in sys.argv[1:3]:
    try:
        OperatingPoints.read(book)
    except InputError as error:
        print("irg:", error, file=sys.stderr)
# Of this program alone: what the system counts of a child includes what it was forked from.
peak = Path("/proc/self/status").read_text().split("VmHWM:")[1].split()[0]
print(*{*codes}, int(peak) // 1024)
"""


@pytest.mark.skipif(sys.platform != "linux", reason="memory is counted in kB on Linux")
def test_small_files_that_ask_for_much_are_refused_in_a_line_and_take_no_memory(tmp_path):
    for number, text in enumerate(SCENES.values()):
        (tmp_path / f"{number}.toml").write_text(_FIRST + text + "\n")
    with zipfile.ZipFile(tmp_path / "a.xlsx", "w", zipfile.ZIP_DEFLATED) as book:
        book.writestr("xl/worksheets/sheet1.xml", bytes(11_000_000))
    far = pytest.importorskip("openpyxl").Workbook()
    far.active["XFD1048576"] = 1
    far.save(tmp_path / "far.xlsx")
    scenes = [f"{number}.toml" for number in range(len(SCENES))]
    done = python("-c", _ASKED, "a.xlsx", "far.xlsx", *scenes, cwd=tmp_path)
    said = done.stderr.splitlines()
    wanted = [*SCENES, "unpacks to 11 MB", "more than 1000000 cells"]
    assert len(said) == len(wanted), done.stderr[-2000:]
    assert [words for words, line in zip(wanted, said, strict=True) if words not in line] == []
    code, megabytes = done.stdout.split()[-2:]
    assert code == "2"
    assert int(megabytes) < 300
