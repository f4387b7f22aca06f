"""All refusals of a laboratory's files: what causes each, and what its message says."""

import io
import math
import sys
import zipfile
from pathlib import Path
from types import SimpleNamespace

import numpy as np
import pytest

from pipeline import SceneFileError, load_scene, surface_statistics
from pipeline.laboratory import instruments
from pipeline.laboratory.spectrum import fit_profiles, fit_self_affine
from pipeline.laboratory.surfaces import filled, read_surface
from pipeline.scene.along import OperatingPoints
from pipeline.scene.choices import Choices
from tests.helpers.instruments import gwy, sur, x3p
from tests.helpers.refusals import command, refusal_tests
from tests.pipeline.laboratory.test_surfaces import FakeTopography
from tests.pipeline.scene.conftest import MEASURED_SURFACE, ROUGHNESS, TEXT
from tribo import InputError

SQUARE = (480, 480)
SMALL = np.eye(8)
PIXEL = (1e-6, 1e-6)


def scan(text, unit=1.0, name="scan.csv"):
    """Function that reads a surface file with this content."""

    def build():
        Path(name).write_bytes(text if isinstance(text, bytes) else text.encode())
        return read_surface(name, unit)

    return build


def book(sheet=None):
    def build():
        made = pytest.importorskip("openpyxl").Workbook()
        made.active.title = "Log"
        made.active["A1"] = "load"
        made.save("log.xlsx")
        return OperatingPoints.read("log.xlsx", Choices(sheet=sheet))

    return build


def table(name, content=b"", sheet=None):
    def build():
        Path(name).write_bytes(content)
        return OperatingPoints.read(name, Choices(sheet=sheet))

    return build


def far_cell():
    made = pytest.importorskip("openpyxl").Workbook()
    made.active["XFD1048576"] = 1
    made.save("far.xlsx")
    return OperatingPoints.read("far.xlsx")


def no_openpyxl():
    with pytest.MonkeyPatch.context() as patch:
        patch.setitem(sys.modules, "openpyxl", None)
        return bomb("log.xlsx", 1000, OperatingPoints.read)()


def pixels_of_another_size():
    Path("scan.csv").write_text(SIZED, encoding="utf-8")
    text = TEXT.replace(ROUGHNESS, 'file = "scan.csv"\n').replace("[480, 480]", "[4, 4]")
    Path("scene.toml").write_text(text, encoding="utf-8")
    return load_scene("scene.toml")


def bomb(name, size, read):
    def build():
        with zipfile.ZipFile(name, "w", zipfile.ZIP_DEFLATED) as archive:
            archive.writestr("xl/worksheets/sheet1.xml", bytes(2**10))
            archive.filelist[0].file_size = size  # unpacked size stated by its directory
        return read(Path(name))

    return build


def instrument(topography, unit=None, sizes=(1.0, 1.0)):
    """Function that reads a file in which the library finds this topography."""

    def read(*_):
        if isinstance(topography, Exception):
            raise topography
        return topography

    channel = SimpleNamespace(physical_sizes=sizes)
    reader = SimpleNamespace(topography=read, default_channel=channel, channels=[channel])
    library = SimpleNamespace(open_topography=lambda path, format: reader)

    def build():
        Path("a.opd").touch()
        with pytest.MonkeyPatch.context() as patch:
            patch.setattr(instruments.importlib, "import_module", lambda name: library)
            return read_surface("a.opd", unit)

    return build


def no_library():
    def missing(name):
        raise ImportError(name)

    Path("a.opd").touch()
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(instruments.importlib, "import_module", missing)
        return read_surface("a.opd")


def packed_bomb():
    content = bytearray(sur(SMALL, PIXEL, is_compressed=True))
    content[524:528] = (2**31).to_bytes(4, "little")  # stated unpacked size of a block
    return scan(bytes(content), None, "a.sur")()


def header(shape, descr="<f8"):
    text = f"{{'descr': '{descr}', 'fortran_order': False, 'shape': {shape}, }}"
    return b"\x93NUMPY\x01\x00" + (118).to_bytes(2, "little") + text.ljust(117).encode() + b"\n"


def saved(save, **array):
    buffer = io.BytesIO()
    save(buffer, **array)
    return buffer.getvalue()


def vast(descr="<f8", shape=(10**5, 10**5)):
    """Read a file with very many heights, most of them holes."""
    with Path("a.npy").open("wb") as file:
        start = file.write(header(shape, descr))
        file.truncate(start + math.prod(shape) * np.dtype(descr).itemsize)
    return read_surface("a.npy", 1.0)


def plain(content):
    return scan(content, 1.0, "a.npy")


def array(heights, sides=("1 um", "1 um"), unit="um"):
    def build():
        np.save("plane.npy", heights)
        return surface_statistics("plane.npy", unit, sides)

    return build


def measured(heights, extra="", **overrides):
    """Function that reads a scene with a measured surface of these heights."""

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


def surface_command(text, *options):
    """Function that runs ``irg surface`` on a text, or without a file."""

    def build():
        Path("p.txt").write_text(text)
        return command("surface", *["p.txt"] * bool(text), *options)

    return build


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


def many(rows, head="time [s],COF"):
    return f"{head}\n" + rows * 20


GRIDDED = "".join(f"{x} {y} {x * y % 3}\n" for x in range(4) for y in range(4))
SIZED = "# Width: 4.00 µm\n# Height: 4.00 µm\n# Value units: µm\n" + "1 2 3 4\n" * 4
HOLED = np.where(np.arange(480) % 3, 1.0, np.nan) * np.ones(SQUARE)
FLAT = FakeTopography(np.ones((4, 4)))
FLAT.is_uniform = False
REFUSALS = {
    # text
    "unequal": (scan("1 2 3\n4 5\n"), "all rows must be of equal length"),
    "commas": (scan("0,12,1,05\n0,33,1,25\n"), "commas stand between cells and before decimals"),
    "word": (scan("1;2;x\n4;5;6\n"), '"x" is not a number'),
    "nothing": (scan("no numbers\n"), "no line of numbers"),
    "line": (scan("".join(f"0 {k} 1\n" for k in range(9))), "a profile of 9 heights"),
    "uneven": (scan("".join(f"{k**1.5} {k} 1\n" for k in range(9))), "not on a regular grid"),
    "sparse": (scan("".join(f"{k} {k} 1\n" for k in range(40))), "not on a regular grid"),
    "twice": (scan("0 0 1\n1 0 1\n0 1 1\n" * 4), "two heights at one place"),
    "two tables": (scan("1 2 3\n4 5 6\n\n7 8 9\n1 2 3\n"), "2 tables, separated by blank lines"),
    "second table": (scan("1 2\n4 5\nmore\n7 8\n1 2\n"), "a second table stands in the file"),
    "no unit": (scan("1,2\n3,4\n", None), "the file states no unit of its heights"),
    "no text": (lambda: read_surface("no.csv", 1.0), "no.csv"),
    "endless": (endless, "2.0 GiB; at most 1 GiB are read"),
    # plain arrays
    "no length": (array(np.eye(20), unit=0.0), "give height_unit"),
    "npz": (plain(saved(np.savez, heights=np.ones((2, 2)))), "a.npy: "),
    "npy text": (plain(saved(np.save, arr=np.array([["a"]]))), "real numbers"),
    "npy large": (vast, "74.5 GiB"),
    # files of instruments
    "zip cut": (scan(b"PK\1\2" + bytes(60) + b"PK\5\6" + bytes(8) + b"\1\0\1\0" + bytes(10),
                     None, "a.x3p"), "is a damaged archive"),
    "npy cut": (scan(b"\x93NUMPY\x01", None, "a.npy"), "not a plain array"),
    "tmd": (scan(b"Binary TrueMap Data File v2.0\r\n", None, "a.tmd"), "by a factor of 1000"),
    "place twice": (surface_command("1 5\n" * 9, "--height-unit", "um", "--length-unit", "mm"),
                    "two heights at one place"),
    "no scan": (surface_command("", "--ra", "1 um"), "give a SCAN, or --ra and --rsm"),
    "no profile": (surface_command("1 2 3\n4 5 6\n7 8 9\n", "--cutoff", "none"), "is a map, and"),
    "turned profile": (surface_command("0.1 5\n0.2 6\n", "--transpose"), "is no map, which --tr"),
    "flat profile": (surface_command("0 1\n" + "".join(f"{k} 1\n" for k in range(1, 9)),
                     "--height-unit", "um", "--length-unit", "um"), "without any roughness; give"),
    "few for a profile": (lambda: fit_profiles(np.eye(9), 1e-6, None), "9 heights are too few for"),
    "repeats": (lambda: fit_profiles(np.sin(np.arange(999.0))[:, None], 1e-6, None),
                "it repeats every 6.2"),
    "profile units": (surface_command("0.1 5\n0.2 6\n"), 'give --height-unit "um" and --length'),
    "short profile": (surface_command("0.1 5\n0.2 6\n", "--height-unit", "um", "--length-unit",
                                      "mm"), "a profile of 2 heights; give 8 or more"),
    "coarse": (surface_command("", "--ra", "1 um", "--rsm", "1 um", "-q"), "give smaller pixels"),
    "image": (scan(b"II*\0", None, "a.tif"), "an image, whose grey"),
    "profile": (instrument(FLAT), "unevenly spaced; give an even map"),
    "sizeless": (instrument(None, sizes=None), "states no sizes; save the heights as"),
    "broken": (instrument(RuntimeError("bad header\nmore")), "cannot be read as .opd: bad header"),
    "no library": (no_library, "pip install SurfaceTopography"),
    "unknown": (scan(b"x", None, "a.abc"), "SurfaceTopography has no reader for .abc"),
    "packed": (bomb("a.x3p", 200_000_000, read_surface), "unpacks to 200 MB, "),
    "bomb": (bomb("a.x3p", 2**31, read_surface), "2.0 GiB; at most 1 GiB are"),
    "packed bomb": (packed_bomb, "unpacks to more than 1 GiB"),
    "no main": (bomb("a.x3p", 2**10, read_surface), "damaged .x3p file"),
    "x3p profile": (scan(x3p(SMALL, PIXEL, edit=("SUR</F", "PRF</F")), None, "a.x3p"),
                    "FeatureType should be 'SUR'; save"),
    "x3p short": (scan(x3p(SMALL, PIXEL, edit=("eY>8", "eY>9")), None, "a.x3p"), "ended after 512"),
    "gwy": (scan(b"x", None, "a.gwy"), "damaged .gwy file"),
    "gwy phase": (scan(gwy([("p", SMALL, "deg")], PIXEL), None, "a.gwy"), "no channel of heights"),
    # statistics
    "no pixels": (array(np.eye(20), None), "no size of a pixel; give pixel_size"),
    "ratio": (lambda: (scan(GRIDDED)(), surface_statistics("scan.csv", "um", ("1 um", "2 um"))),
              "the file's are as 1 to 1; give the same ratio"),
    "plane": (array(np.indices((20, 30))[1] * 0.1), "the heights are a plane, without"),
    "high": (array(np.random.default_rng(0).normal(size=(20, 20)) * 1e9), "m; give the unit, he"),
    "unit": (array(np.eye(20), unit="kg"), '"1 kg" cannot be converted'),
    "few heights": (lambda: fit_self_affine(np.eye(6, 5), (1.0, 1.0)), "6 × 5 heights are too few"),
    "missing": (lambda: filled(np.full((3, 3), np.nan)), "all heights are missing"),
    # scenes
    "all missing": (measured(np.full(SQUARE, np.nan), 'missing = "fill"\n'), "all heights are mis"),
    "holes": (measured(HOLED), "disk.roughness.missing: 76800 of 230400 heights (33 %) are missing,"
              " the first at x 0, y 0 (counted from 0)"),
    "pixels": (pixels_of_another_size, "the pixels of disk.roughness.file are"),
    "crop of y": (measured(np.eye(490), "crop = [0, 100]\n"), "from 0, 100 on extends beyond"),
    "crop": (measured(np.eye(490), "crop = [100, 0]\n"), "extends beyond the surface of 490"),
    # tables
    "sheet": (table("log.csv", sheet="one"), 'log.csv has no sheet "one", as it is a text'),
    "kind": (table("log.xlsx", b"%PDF"), "log.xlsx is a PDF; save the table as .xlsx or CSV"),
    "no sheet": (book("Lag"), 'has no sheet "Lag"; give one of Log'),
    "no book": (table("log.xlsx", b"PKtext"), "is a damaged .xlsx file"),
    "far": (far_cell, "more than 1000000 cells"),
    "large": (bomb("log.xlsx", 11_000_000, OperatingPoints.read), "unpacks to 11 MB"),
    "no openpyxl": (no_openpyxl, "pip install openpyxl"),
    # logs and traces
    "form": (log_command("a,b\n1,2\n", "--form", "rteck"), 'no form "rteck" (did you mean "rtec"'),
    "quantity": (log_command("a,b\n1,2\n", "--given", "warmth=9"), "given.warmth: no such quant"),
    "runs": (log_command(many("1,0.1\n") + "0,0.1\n"), "row 22: time falls from"),
    "cell": (log_command(many("1,0.1\n") + "2x,0.1\n"), 'row 22, time: "2x" has an unknown unit'),
    "at rest": (log_command(many("1,0.1,5\n", "time [s],COF,load [N]") + "2,0.1,999\n" * 9),
                "9 rows in motion; a trace needs 20"),
    "thousandths": (log_command(many("1,100\n")), "friction is 100; in a contact it is"),
    "no trace": (log_command("load [N],velocity [m/s],outcome\n4,2,mild\n", "-o", "a.png"),
                 "is no record of friction over time, which -o needs"),
    "late": (log_command(many("1,0.1\n"), "--scuffed-at", "9 s"), "and the record ends at 0 s"),
    "outcome of a word": (log_command("a,b\n1,2\n", "--word", "broken=gone"),
                          '"gone" is no outcome; give'),
    "log": (logged("load [N],velocity [m/s],outcome\n400,2,mlid\n"), "row 2, outcome"),
    "log of": (logged("Kraft [N],speed [rpm],result\n400,500,ok\n"), "printed by: irg tests"),
    "no log": (no_log, "no.csv"),
}  # fmt: skip


refusals, test_what_is_refused_is_named, test_the_table_has_every_refusal = refusal_tests(
    "laboratory", REFUSALS
)


def test_a_surface_with_holes_is_refused_each_time(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    sweep = measured(np.ones(SQUARE))()
    np.save("holed.npy", HOLED)
    for _ in range(2):
        with pytest.raises(InputError, match=r"76800 of 230400 heights \(33 %\) are missing"):
            sweep.changed("disk.roughness", {"file": "holed.npy", "height_unit": "um"})
