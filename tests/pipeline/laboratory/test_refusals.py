"""All refusals of a laboratory's files: what causes each, and what its message says."""

import io
import math
import sys
import zipfile
from pathlib import Path
from types import SimpleNamespace

import numpy as np
import pytest

from pipeline.laboratory import plain_scan, spreadsheet, surfaces
from pipeline.laboratory.scan import surface_statistics
from pipeline.laboratory.spreadsheet import read_rows
from pipeline.laboratory.surfaces import filled, read_surface
from pipeline.scene.faults import SceneFileError
from pipeline.scene.scenefile import load_scene
from tests.helpers.refusals import Refusals, command
from tests.pipeline.laboratory.test_surfaces import FakeTopography
from tests.pipeline.scene.conftest import MEASURED_SURFACE, ROUGHNESS, TEXT

SQUARE = (480, 480)


def scan(text, unit=1.0, name="scan.csv"):
    def build():
        Path(name).write_text(text, encoding="utf-8")
        return read_surface(name, unit)

    return build


def book(**sheets):
    def build():
        made = pytest.importorskip("openpyxl").Workbook()
        made.active.title = "Log"
        made.active["A1"] = "load"
        made.save("log.xlsx")
        return read_rows(Path("log.xlsx"), lambda cells: True, **sheets)

    return build


def rows_of(name, content=b"", **options):
    def build():
        Path(name).write_bytes(content)
        return read_rows(Path(name), lambda cells: True, **options)

    return build


def patched(module, name, value, build):
    def run():
        with pytest.MonkeyPatch.context() as patch:
            patch.setattr(module, name, value)
            return build()

    return run


def far_cell():
    made = pytest.importorskip("openpyxl").Workbook()
    made.active["XFD1048576"] = 1
    made.save("far.xlsx")
    return read_rows(Path("far.xlsx"), lambda cells: True)


def no_openpyxl():
    with pytest.MonkeyPatch.context() as patch:
        patch.setitem(sys.modules, "openpyxl", None)
        return bomb("log.xlsx", 1000, lambda path: read_rows(path, bool))()


def damaged(*_, **__):
    raise ZeroDivisionError


def pixels_of_another_size():
    Path("scan.csv").write_text(SIZED, encoding="utf-8")
    text = TEXT.replace(ROUGHNESS, 'file = "scan.csv"\n').replace("[480, 480]", "[4, 4]")
    Path("scene.toml").write_text(text, encoding="utf-8")
    return load_scene("scene.toml")


def bomb(name, size, read):
    def build():
        with zipfile.ZipFile(name, "w", zipfile.ZIP_DEFLATED) as archive:
            archive.writestr("xl/worksheets/sheet1.xml", bytes(2**10))
            archive.filelist[0].file_size = size  # as its directory says
        return read(Path(name))

    return build


def instrument(topography, unit=None):
    """A file of an instrument, which a library reads as this topography."""

    def read(*_):
        if isinstance(topography, Exception):
            raise topography
        return topography

    library = SimpleNamespace(open_topography=lambda path: SimpleNamespace(topography=read))

    def build():
        Path("a.x3p").touch()
        with pytest.MonkeyPatch.context() as patch:
            patch.setattr(surfaces.importlib, "import_module", lambda name: library)
            return read_surface("a.x3p", unit)

    return build


def no_library():
    def missing(name):
        raise ImportError(name)

    Path("a.x3p").touch()
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(surfaces.importlib, "import_module", missing)
        return read_surface("a.x3p")


def plain(content):
    def build():
        Path("a.npy").write_bytes(content)
        return read_surface("a.npy", 1.0)

    return build


def header(shape, descr="<f8"):
    text = f"{{'descr': '{descr}', 'fortran_order': False, 'shape': {shape}, }}"
    return b"\x93NUMPY\x01\x00" + (118).to_bytes(2, "little") + text.ljust(117).encode() + b"\n"


def saved(save, **array):
    buffer = io.BytesIO()
    save(buffer, **array)
    return buffer.getvalue()


def vast(descr="<f8", shape=(10**5, 10**5)):
    """A file of so many heights, most of them holes."""
    with Path("a.npy").open("wb") as file:
        start = file.write(header(shape, descr))
        file.truncate(start + math.prod(shape) * np.dtype(descr).itemsize)
    return read_surface("a.npy", 1.0)


def array(heights, sides=("1 um", "1 um"), unit="um"):
    def build():
        np.save("plane.npy", heights)
        return surface_statistics("plane.npy", unit, sides)

    return build


def measured(heights, extra="", **overrides):
    """A scene on a measured surface."""

    def build():
        np.save("surface.npy", heights)
        text = TEXT.replace(ROUGHNESS, MEASURED_SURFACE + extra)
        Path("scene.toml").write_text(text, encoding="utf-8")
        return load_scene("scene.toml", overrides=overrides)

    return build


def endless():
    with Path("a.csv").open("wb") as file:
        file.truncate(2**31)
    return read_surface("a.csv", 1.0)


def log_command(text, *options):
    def build():
        Path("log.csv").write_text(text)
        return command("tests", "log.csv", *options)

    return build


def logged(text):
    def build():
        Path("log.csv").write_text(text)
        Path("scene.toml").write_text(f'{TEXT}\n[[tested]]\nfile = "log.csv"\n', encoding="utf-8")
        with pytest.raises(SceneFileError) as caught:
            load_scene("scene.toml")
        return " ".join(caught.value.faults)

    return build


def no_log():
    Path("scene.toml").write_text(f'{TEXT}\n[[tested]]\nfile = "no.csv"\n', encoding="utf-8")
    return load_scene("scene.toml")


SIZED = "# Width: 4.00 µm\n# Height: 4.00 µm\n# Value units: µm\n" + "1 2 3 4\n" * 4
HOLED = np.where(np.arange(480) % 3, 1.0, np.nan) * np.ones(SQUARE)
FLAT = FakeTopography(np.ones((4, 4)), dim=1)
BARE = FakeTopography(np.ones((4, 4)), unit=None)
REFUSALS = {
    # text
    "unequal": (scan("1 2 3\n4 5\n"), "all rows must be of equal length"),
    "few": (scan("1,2,3\n4,5\n7,8,9\n"), "2 numbers in the row"),
    "commas": (scan("0,12,1,05\n0,33,1,25\n"), "commas stand between cells and before decimals"),
    "word": (scan("1;2;x\n4;5;6\n"), '"x" is not a number'),
    "nothing": (scan("no numbers\n"), "no line of numbers"),
    "line": (scan("".join(f"0 {k} 1\n" for k in range(9))), "one x or y alone"),
    "uneven": (scan("".join(f"{k**1.5} {k} 1\n" for k in range(9))), "not on a regular grid"),
    "sparse": (scan("".join(f"{k} {k} 1\n" for k in range(40))), "not on a regular grid"),
    "infinite": (scan("1,inf\n3,4\n"), "the height at row 0, column 1 (counted from"),
    "no unit": (scan("1,2\n3,4\n", None), "the text says no unit of its heights"),
    "no text": (lambda: read_surface("no.csv", 1.0), "no.csv"),
    "endless": (endless, "more than 1 GiB; crop or average"),
    # plain arrays
    "no file": (lambda: read_surface("a.npy", 1.0), "a.npy: cannot be read"),
    "no length": (array(np.eye(20), unit=0.0), "unit"),
    "npz": (plain(saved(np.savez, heights=np.ones((2, 2)))), "begin as NumPy"),
    "npy text": (plain(saved(np.save, arr=np.array([["a"]]))), "real numbers"),
    "npy vast": (plain(header("(10000000, 10000000)")), "more than there is memory"),
    "npy large": (vast, "74.5 GiB"),
    "npy heights": (lambda: vast("|i1", (10_001, 10_000)), "100010000 heights"),
    "npy short": (plain(header("(3, 3)") + b"12345678"), "not a plain array"),
    "npy none": (plain(header("(0, 5)")), "shape (0, 5)"),
    "npy inf": (array(np.diag([np.inf] * 3)), "3 of 9 heights are not finite, the first at row 0"),
    # files of instruments
    "plain": (array(np.eye(20), unit=None), "a plain array has no unit of its own"),
    "damaged": (patched(plain_scan, "_read_array", damaged, array(np.eye(20))),
                "not a plain array of numbers: ZeroDivisionError"),
    "image": (lambda: (Path("a.tif").touch(), read_surface("a.tif")), "an image, whose grey"),
    "profile": (instrument(FLAT), "a profile, or unevenly spaced"),
    "unitless": (instrument(BARE), "the file does not give the unit of its heights"),
    "broken": (instrument(RuntimeError("bad header\nmore")), "as a surface: bad header"),
    "no library": (no_library, "pip install SurfaceTopography"),
    "bomb": (bomb("a.x3p", 2**31, read_surface), "unpacks to 2.0 GiB; at most 1 GiB are"),
    # statistics
    "no pixels": (array(np.eye(20), None), "no size of a pixel; give pixel_size"),
    "flat pixels": (array(np.eye(20), ("1 um", 0.0)), "no size of a pixel; give pixel_size"),
    "plane": (array(np.indices((20, 30))[1] * 0.1), "the heights are a plane, without"),
    "high": (array(np.eye(20) * 1e9), "heights of 1e+03 m; give the unit"),
    "row": (array(np.ones((1, 20))), "a profile; give a map of heights"),
    "small": (array(np.eye(10)), "plane.npy: 10 × 10 heights are too few"),
    "unit": (array(np.eye(20), unit="kg"), '"1 kg" cannot be converted'),
    "missing": (lambda: filled(np.full((3, 3), np.nan)), "all heights are missing"),
    # scenes
    "all missing": (measured(np.full(SQUARE, np.nan), 'missing = "fill"\n'), "all heights are mis"),
    "holes": (measured(HOLED), "disk.roughness.missing: 76800 of 230400 heights (33 %) are missing,"
              " the first at x 0, y 0 (counted from 0)"),
    "pixels": (pixels_of_another_size, "the pixels of disk.roughness.file are"),
    "crop of y": (measured(np.eye(490), "crop = [0, 100]\n"), "from 0, 100 on reaches beyond"),
    "crop": (measured(np.eye(490), "crop = [100, 0]\n"), "reaches beyond the surface of 490 × 490"),
    # tables
    "sheet": (rows_of("log.csv", sheet="one"), 'has no sheets, so none called "one"'),
    "kind": (rows_of("log.ods"), "log.ods cannot be read: rows are read from"),
    "no sheet": (book(sheet="Lag"), 'has no sheet "Lag"; give one of Log'),
    "no book": (rows_of("log.xlsx", b"text"), "is no sound .xlsx file"),
    "long cell": (rows_of("log.csv", b"a,b\n1," + b"9" * 200_000), "field larger than"),
    "far": (far_cell, "more than 1000000 cells"),
    "large": (bomb("log.xlsx", 11_000_000, lambda path: read_rows(path, bool)), "unpacks to 11 MB"),
    "no openpyxl": (no_openpyxl, "pip install openpyxl"),
    "unreadable": (patched(spreadsheet, "decoded", lambda _: Path("no").stat(),
                           rows_of("log.csv", b"a")), "cannot be read: No such file"),
    # logs
    "runs": (log_command("time [s],COF\n" + "1,0.1\n" * 20 + "0,0.1\n"), "row 22: time falls from"),
    "no run": (log_command("time [s],COF,run\n" + "1,0.1,A\n" * 20, "--where", "run=B"),
               'no row has "B" as run; give one of A'),
    "column": (log_command("load [N],velocity [m/s],outcome\n400,2,mild\n", "--column", "lod=load"),
               'no test has "lod"'),
    "log": (logged("load [N],velocity [m/s],outcome\n400,2,mlid\n"), "row 2, outcome"),
    "log of": (logged("Kraft [N],speed [rpm],result\n400,500,ok\n"), "printed by: irg tests"),
    "no log": (no_log, "no.csv"),
}  # fmt: skip


@pytest.fixture(scope="module")
def refusals(tmp_path_factory):
    return Refusals("laboratory", REFUSALS, tmp_path_factory.mktemp("refusals"))


@pytest.mark.parametrize("name", REFUSALS)
def test_what_is_refused_is_named(refusals, name):
    refusals.check(name)


def test_the_table_has_every_refusal(refusals):
    refusals.check_all()
