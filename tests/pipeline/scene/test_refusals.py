"""All refusals of scenes and of their files: what causes each; tests/kept has what it says."""

import math
from pathlib import Path

import numpy as np
import pandas as pd
import pint

from pipeline import load_scene, new_scene, run_point, to_si
from pipeline.kinds import LOAD, WORKERS
from pipeline.scene.contact_estimate import require_admissible_load
from pipeline.scene.variants import variants_of
from pipeline.units import share_of
from tests.helpers import laws, tiny
from tests.helpers.refusals import refusal_tests
from tests.pipeline.scene.conftest import MEASURED_SURFACE, ROUGHNESS, TEXT

RAMP = 'rate = "150 N/s"\nreference_load = "750 N"'
STAGES = '\n[[tests]]\nvelocity = "2 m/s"\nmild_up_to = "400 N"\n'


def scene(*changes, text=TEXT, **overrides):
    """Read the scene of these tests with texts replaced, or with other entries."""
    for old, new in changes:
        assert old in text
        text = text.replace(old, new)
    Path("scene.toml").write_text(text, encoding="utf-8")
    return load_scene("scene.toml", overrides=overrides)


def entry(key, value, **other_entries):
    return lambda: scene(**{key: value}, **other_entries)


def text(old, new):
    return lambda: scene((old, new))


def toml(content, name="scene.toml"):
    def read():
        Path(name).write_bytes(content)
        return load_scene(name)

    return read


def file(read, name, content):
    """Function that writes a file and reads it by `read`."""

    def build():
        Path(name).write_bytes(content)
        return read(Path(name))

    return build


def load(content):
    """Function that reads a scene with a load record of this content."""
    return file(lambda path: scene((RAMP, f'file = "{path}"')), "load.csv", content)


def chain():
    for number in range(25):
        Path(f"c{number}.toml").write_text(f'extends = "c{number + 1}.toml"\n')
    return load_scene("c0.toml")


def long_load():
    with Path("load.csv").open("wb") as record:
        record.truncate(40_000_001)
    return scene((RAMP, 'file = "load.csv"'))


def along(rows, **other_entries):
    def build():
        Path("rows.csv").write_text(rows)
        return scene(**{"sweep.along": "rows.csv"}, **other_entries)

    return build


ROW = "load [N],velocity [m/s]\n300,2\n"


def measured(shape, **other_entries):
    np.save("surface.npy", np.zeros(shape))
    return scene((ROUGHNESS, MEASURED_SURFACE), **other_entries)


def new_scene_twice():
    new_scene("mine.toml")
    return new_scene("mine.toml")


def new_scene_at_a_link():
    Path("link.toml").symlink_to("no scene.toml")
    return new_scene("link.toml")


def over(path, values, **other_entries):
    return entry("sweep.over", {path: values}, **other_entries)


def uncertain(paths, deviation):
    return entry("uncertainty", {paths: deviation})


def with_law():
    """A scene whose wear law is a user's."""
    return load_scene("first_try").with_scene(wear=laws.ByPressure())


def nested(levels):
    """A number in lists in lists."""
    return [nested(levels - 1)] if levels else 1.0


FILES = {
    "load header": load(b"time [s],load [N],load [kN]\n0,0,0\n1,5,1\n"),
    "load inf": load(b"time [s],load [N]\n0,0\n\n1,1e999\n"),
    "load back": load(b"time [s],load [N]\n0,0\n\n2,5\n1,6\n"),
    "load large": long_load,
}  # fmt: skip

QUANTITIES = {
    "no unit": lambda: to_si("4 m/m", like="1 m"),
    "degrees": lambda: to_si("25 C", like="1 K"),
    "dimension": lambda: to_si("7 kg", like="750 N"),
    "no quantity": lambda: to_si("five", like="1 m"),
    "hardness": lambda: to_si("19 HRC", like="6 GPa"),
    "unknown": lambda: to_si("4 kx", like="1 N"),
    "infinite": lambda: to_si("1e400 N", like="1 N"),
    "unit": lambda: to_si("4 2 um", like="1 m"),
    "named": lambda: LOAD.argument("load", "4 m"),
    "count": lambda: WORKERS.argument("samples", 1.5),
    "an array": lambda: to_si(np.eye(2), "1 N"),
    "a frame": lambda: LOAD.argument("load", pd.DataFrame({"load": [4.0]})),
    "share": lambda: share_of("ten"),
    "a long text": lambda: to_si("4" * 300, like="1 m"),
    "another scale": lambda: to_si("90 HRB", like="6 GPa"),
    "unreadable unit": lambda: to_si("4 m^^2", like="1 m"),
    "a type": lambda: LOAD.argument("load", object()),
    "a complex quantity": lambda: LOAD.argument("load", pint.Quantity(1j, "N")),
    "nested lists": lambda: LOAD.argument("load", nested(99)),
}


EVEN = '{ first = "200 N", step = "200 N", hold = "60 s" }'


def stages(stage_text, loads=("200 N", "400 N"), more="", **other_entries):
    """Function that reads the scene with the loading in stages."""
    loading = (RAMP, f'rate = "150 N/s"\nstages = {stage_text}\n{more}')
    return lambda: scene(loading, **{"sweep.loads": [*loads], "without": "tests"} | other_entries)


def staged(test, loading=RAMP):
    """Function that reads the scene with one test by stages."""
    text = f"{TEXT[: TEXT.index('[[tests]]')]}\n[[tests]]\nstages = {EVEN}\n{test}\n"
    return lambda: scene((RAMP, loading), text=text)


def staged_record():
    """Read a scene whose load is recorded, with a test by stages."""
    Path("load.csv").write_text("time [s],load [N]\n0,0\n1,100\n2,200\n")
    return staged('velocity = "2 m/s"\nsevere_at = "400 N"', 'file = "load.csv"')()


RELIEF = {"depth": "2 um", "length": "0.3 mm"}
TEST = {"load": "400 N", "velocity": "1 m/s", "outcome": "mild"}
ENTRIES = {
    "ra": entry("disk.roughness.ra", 0.27),
    "no list": entry("sweep.loads", []),
    "one side": entry("window.pixels", [480]),
    "number twice": entry("tests", [{**TEST, "number": 2}] * 2, without="tests"),
    "entry of a test": entry("tests", [{**TEST, "with": {"pin.radius": 3}}], without="tests"),
    "entries of a test": entry("tests", [{**TEST, "with": ["1 mm"]}], without="tests"),
    "test without outcome": entry("tests", [{"load": "4 N", "velocity": "1 m/s"}]),
    "outcome of stages": entry("tests", [{
        "velocity": "1 m/s", "outcome": "mild", "severe_at": "4 N"}]),
    "load of stages": entry("tests", [{"velocity": "1 m/s", "load": "4 N", "severe_at": "4 N"}]),
    "stages of velocity": entry("tests", [{"velocity": "1 m/s", "severe_at": "4 m/s"}]),
    "outcome OK": entry("tests", [TEST | {"outcome": "OK"}]),
    "outcome scuffed": entry("tests", [TEST | {"outcome": "scuffed"}]),
    "test without load": entry("tests", [{"velocity": "1 m/s", "outcome": "mild"}]),
    "stages of a transition": entry("tests", [{
        **TEST, "outcome": "transition", "stages": [["400 N", "1 s"]]}]),
    "load without stage": stages(EVEN, ["300 N"]),
    "hold of stages": stages(EVEN, more='hold = "4 s"'),
    "stage without hold": stages('[["4 N"]]', ["4 N"]),
    "steps of stages": stages(EVEN, **{"sweep.steps": "course"}),
    "many stages": stages(EVEN.replace('step = "200', 'step = "1e-4')),
    "severe without stage": staged('velocity = "2 m/s"\nsevere_at = "350 N"'),
    "stages of a record": staged_record,
    "degrees of an entry": entry("temperature.bulk", "25 C"),
    "nan": entry("materials.steel.poisson_ratio", math.nan),
    "short pin": entry("pin.length", "0.455 mm"),
    "material": entry("disk.material", "stell"),
    "like": entry("oil", "vg33"),
    "pixels": entry("window.pixels", [480, 481]),
    "one pixel": entry("window.pixels", [1, 1], **{"fidelity.pixels_per_element": 1}),
    "relief of a repeating pin": lambda: load_scene("first_try", overrides={"pin.relief": RELIEF}),
    "long relief": lambda: load_scene("whole_pin", overrides={
        "pin.relief": RELIEF | {"length": "2 mm"}}),
    "ends of a ball": lambda: load_scene("ball_on_disk", overrides={"pin.ends": "free"}),
    "sharp ends": entry("pin.ends", "sharp"),
    "long text": entry("pin.ends", "sharp " * 40),
    "vast number": entry("increments", 10**35),
    "crown": entry("pin.shape", "crowned", without="pin.length"),
    "no length": lambda: scene(without="disk.roughness.correlation_length"),
    "two spellings": entry("increments", 5, **{"fidelity.increments": 6}),
    "two lengths": entry("disk.roughness", {"ra": "0.27 um", "hurst_exponent": 0.8,
                                             "correlation_length": "4 um", "rsm": "30 um"}),
    "rsm below ra": entry("disk.roughness.rsm", ["30 um", "0.2 um"]),
    "another track": entry("motion", {"slide_roll_ratio": 1, "disk_track_length": "30 mm"},
                            **{"disk.track_length": "40 mm"}),
    "short track": entry("motion", {"slide_roll_ratio": 1, "pin_track_length": "0.1 mm"}),
    "critical": entry("temperature.critical", "25 degC"),
    "far": entry("temperature.bulk", "1e9 degC"),
    "comma": entry("friction.coefficient", "0,1"),
    "step": entry("sweep.velocities.step", "0.7 m/s"),
    "both": entry("sweep.velocities", {"step": "1 m/s", "count": 4}),
    "falling": entry("sweep.velocities.to", "0.1 m/s"),
    "falling band": entry("friction.band", [0.2, 0.1]),
    "materials": entry("materials", 3),
    "entries as a preset": lambda: load_scene("first_try", {"pin.radius": "3 mm"}),
    "pin": entry("pin", 3),
    "key": entry("realisations", 3),
    "seeds": entry("sweep.realizations", [3, 3]),
    "without": entry("without", "pin.lenght"),
    "load": lambda: require_admissible_load(scene(), 1e6, "--load"),
    "points": entry("sweep.loads", {"from": "1 N", "to": "7 N", "count": 5000},
                     **{"sweep.velocities": {"from": "1 m/s", "to": "7 m/s", "count": 5000}}),
    "long list": entry("sweep.velocities", [f"{k + 1} m/s" for k in range(5001)]),
    "scan": lambda: measured((48, 20), **{"window.pixels": [48, 20]}),
    "scan without a unit": lambda: measured((480, 480), without="disk.roughness.height_unit"),
    # tracks, discs and surfaces
    "track": entry("disk.diameter", "0.5 mm", **{"disk.width": "9 mm"}),
    "track of a plate and a disc": entry("disk", {
        "material": "steel", "track_length": "0.3 m", "diameter": "9 mm", "width": "9 mm"},
        without="disk.roughness"),
    "half a disc": entry("disk.width", "9 mm"),
    "narrow disc": entry("disk.diameter", "90 mm", **{"disk.width": "1 mm"}),
    "disc at rest": entry("pin.diameter", "90 mm", **{"pin.width": "9 mm"}),
    "realizations of a smooth disk": entry("sweep.realizations", 3, without="disk.roughness"),
    "listed realizations of a smooth disk": entry("sweep.realizations", [3, 4],
                                                   without="disk.roughness"),
    "rsm of finer pixels": entry("disk.roughness.rsm", "3 um",
                                  without="disk.roughness.correlation_length"),
    # tests
    "step of a mild test": entry("tests", [TEST | {"step": "50 N"}]),
    "long step": entry("tests", [TEST | {"outcome": "transition", "step": "400 N"}]),
    "entry that tests share": entry("tests", [TEST | {"with": {"oil.like": "vg32"}}]),
    "entry of a test twice": entry("tests", [
        TEST | {"friction": 0.2, "with": {"friction.coefficient": 0.3}}]),
    # uncertain inputs
    "no input": uncertain("pin.radios", "5 %"),
    "infinite input": entry("uncertainty", {"materials.steel.hardness": "5 %"},
                             without="materials.steel.hardness"),
    "zero deviation": uncertain("pin.radius", "0 %"),
    "no temperature difference": uncertain("temperature.bulk", "5 %"),
    "input twice": uncertain("pin.radius, pin.radius", "5 %"),
    "input in two keys": entry("uncertainty", {
        "pin.radius": "5 %", "pin.length, pin.radius": "2 %"}),
    "kelvins of a length": uncertain("pin.radius", "5 K"),
    "kelvins of both": uncertain("pin.radius, temperature.bulk", "5 K"),
    "a temperature": uncertain("temperature.bulk", "5 degC"),
    "bare difference": uncertain("temperature.bulk", 5),
    "many per cent": uncertain("pin.radius", "500 %"),
    "scale in micrometres": lambda: load_scene("scan", overrides={
        "uncertainty": {"disk.roughness.height_unit": "0.05 um"}}),
    "more than a radius": uncertain("pin.radius", "3 mm"),
    "several deviations": uncertain("pin.radius, pin.length", "0.1 mm"),
    "sensitivity of a store": lambda: variants_of(tiny.sweep(), [(400.0, 2.0, ())]),
    "input of a part of a user": lambda: variants_of(
        with_law(), [(400.0, 2.0, ())], {"wear.specific_wear_rate"}),
    "entry of a part of a user": lambda: with_law().source.changed("wear.specific_wear_rate", 0),
    "input refused on both sides": lambda: variants_of(
        load_scene("first_try", overrides=TIGHT), [(20.0, 2.0, ())], {"pin.length"}),
    # several values of an entry
    "over fixed": over("sweep.loads", [1, 2]),
    "over twice": over("pin.radius", ["1 mm", "1000 um"]),
    "over nothing": over("materials.x.like", ["AISI 52100", "42CrMo4"]),
    "over faulty": over("pin.radius", ["2 mm", "-1 mm"]),
    "over grid": over("fidelity.pixels_per_element", [2, 4]),
    "along many entries": entry("sweep.along", [{f"pin.k{k}": 1} for k in range(101)]),
    "test many entries": entry("tests", [{"load": "300 N", "velocity": "2 m/s", "outcome": "mild",
                                           "with": {f"pin.k{k}": 1 for k in range(101)}}]),
    "over a list": over("pin.radius", [["1 mm"]]),
    "over many entries": entry("sweep.over", {f"pin.k{k}": [1] for k in range(101)}),
    "over many": over("pin.radius", [f"{2 + n / 1000} mm" for n in range(149)], **{
        "sweep.over.pin.length": [f"{3 + n / 1000} mm" for n in range(149)]}),
    # rows of a scene
    "rows": entry("sweep.along", [{"load": "1 N", "velocity": "1 m/s"},
                                   {"load": "1 N", "velocity": "2 m/s", "pin.radius": "2 mm"}]),
    "empty table": lambda: scene(text='extends = "first_try"\n[sweep]\nloads = {}\n'),
    "row lacks": entry("sweep.along", [{"load": "1 N"}]),
    "row faulty": along("load [N],velocity [m/s],pin.radius [mm]\n300,2,3\n300,3,-3\n"),
    "row faulty without loads": along("load [N],velocity [m/s]\n300,\n", without=[
        "sweep.loads", "sweep.velocities"]),
    "row with a short track": entry("sweep.along", [{"load": "400 N", "velocity": "2 m/s",
                                                      "disk.track_length": "0.5 mm"}]),
    "heat counts twice": entry("disk.track_length", "314 mm",
                                **{"temperature.includes_earlier_revolutions": True}),
    "row column": along("load [N],pin.radius [mm]\n300,3\n"),
    "row angle": along("angle [deg],load [N],velocity [m/s]\n30,300,1\n"),
    "row name": along("number,load [N],velocity [m/s]\n\x1b[31mA,300,3\n"),
    "load factors of a plane": entry("sweep.load_factors", [0.5, 1]),
    "load factors without 1": along(ROW, **{"sweep.load_factors": [0.5, 2]}),
    "near load factors": along(ROW, **{"sweep.load_factors": [1, 1.00005]}),
    "load factor 0": along(ROW, **{"sweep.load_factors": [0, 1]}),
    "many load factors": along(ROW, **{"sweep.load_factors": [*range(1, 5003)]}),
    "row at a factor beyond the stages": along(ROW, **{
        "sweep.load_factors": [0.5, 1],
        "loading": {"stages": [["100 N", "1 s"], ["300 N", "1 s"]], "rate": "150 N/s"}}),
    "rows by load factors": along("load [N],velocity [m/s]\n" + "".join(
        f"{300 + n / 100},1\n" for n in range(2600)), **{"sweep.load_factors": [0.5, 1]}),
    "row count": along("load [N],velocity [m/s]\n" + "".join(
        f"{300 + n / 100},1\n" for n in range(5001))),
}  # fmt: skip

TEXTS = {
    "odd key": text("[pin]", '"a\\u2028b" = 1\n[pin]'),
    "thousands": text('["200 N"', '["1,200 N"'),
    "utf-16": toml(TEXT.encode("utf-16")),
    "workbook": toml(b"PK\x03\x04", "tests.xlsx"),
    "table": toml(b"load [N]\n300\n", "tests.csv"),
    "binary": toml(bytes(range(32))),
    "one test": entry("tests", {"file": "a.csv"}),
    "deep": toml(b"a = " + b"[" * 50_000),
    "no toml": toml(b"a = [1"),
    "digits": toml(b"a = " + b"9" * 5000),
    "large file": toml(b"a = 1\n" + b"[b.c.d]\n" * 40_000),
    "folder": lambda: load_scene("."),
    "no scene": lambda: load_scene("first_tyr"),
    "number as a scene": lambda: run_point(5, "400 N", "2 m/s"),
    "circle": toml(b'extends = "scene.toml"\n'),
    "no value": lambda: load_scene("first_try", overrides={"pin.radius": None}),
    "chain": chain,
    "dotted": toml(b"a = 1\n[b]\n" + b".".join([b'"a b"'] * 30_000) + b" = 1\n"),
    "without extends": toml(b'without = ["pin"]\n'),
    "no radius": lambda: scene(without="pin.radius"),
    "changed": lambda: scene().changed("pin.radius", "3 N"),
    "long path": entry(".".join("a" * 500), 1),
    "changed long path": lambda: scene().changed(".".join("a" * 500), 1),
    "extends none": toml(b'extends = "no.toml"\n'),
    "extends": toml(b"extends = 3\n"),
    "stages fall": lambda: scene(text=TEXT + STAGES + 'severe_at = "3 N"\n'),
    "new": lambda: new_scene("mine.txt"),
    "new like": lambda: new_scene("mine.toml", "twin_disk"),
    "new again": new_scene_twice,
    "new at a link": new_scene_at_a_link,
    "new folder": lambda: new_scene("no/mine.toml"),
}


TIGHT = {
    "window.pixels": [96, 48], "window.pixel_size": ["5 um", "5 um"], "pin.length": "0.24 mm",
    "disk.diameter": "50 mm", "disk.width": "0.24 mm", "sweep.loads": ["20 N"],
}  # fmt: skip

REFUSALS = {**FILES, **QUANTITIES, **ENTRIES, **TEXTS}

refusals, test_each_is_one_line, test_all_read_as_they_are_kept, test_all_are_here = refusal_tests(
    "scene", REFUSALS
)
